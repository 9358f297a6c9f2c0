"""Torsional frequencies of the four wheels, block by block, from tooth edges.

Each wheel: edges in order (`Line`), speed at RATE (`EdgeSpeed`), cut into blocks of BLOCK seconds on the clock, and of
each block the two modes (`mode_grid`). Wheel orders are masked while the tooth ring is not learnt; a block in which the
speed changes too much for that or for the mode, or is not known throughout, or is outside a mode's speeds, says
nothing. A block is there `DELAY` seconds after its end.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.drive_log import WHEELS, Signal
from estimators.itpms.mode_grid import ANTIPHASE, BLOCK, IN_PHASE, SIZE, ModeGrid
from estimators.vibration.line import Complaint, Line
from estimators.wheel_speed.edge_speed import EdgeSpeed
from estimators.wheel_speed.orders import order_lines
from estimators.wheel_speed.resampling import USABLE

EDGES = tuple(f"wheel/{wheel}/edges" for wheel in WHEELS)
LEARNT_TIME = 20.0  # s of turning over which a ring was learnt: its own lines are then below a tenth of the spectrum
STEADIEST = 0.05  # largest relative change of speed in a block in which wheel orders can be masked
DELAY = 1.0  # s
BETWEEN = 0.75 * BLOCK  # s from the middle of a block's first quarter to that of its last
_GRIDS: dict[str, ModeGrid] = {}  # templates are the same for every car


def grids() -> tuple[ModeGrid, ModeGrid]:
    """Of the antiphase and the in-phase mode, made once."""
    for band in (ANTIPHASE, IN_PHASE):
        if band.name not in _GRIDS:
            _GRIDS[band.name] = ModeGrid(band)
    return _GRIDS[ANTIPHASE.name], _GRIDS[IN_PHASE.name]


class FrequencyBlocks:
    """Running analysis. speed: of the last block of each wheel [rad/s], shape (4,), NaN where it is not known."""

    def __init__(self, car: Car) -> None:
        self._radius = car.rolling_radius
        self._lines = [Line(name) for name in EDGES]
        self._trackers = [EdgeSpeed() for _ in WHEELS]
        self._speed = [np.empty(0) for _ in WHEELS]
        self._first: list[int | None] = [None] * 4
        self.omega = np.full(4, np.nan)

    def add(self, samples: Mapping[str, Signal]) -> list[Complaint]:
        """Take samples as they arrived."""
        complaints: list[Complaint] = []
        for line in self._lines:
            if line.name in samples:
                complaints += line.add(samples[line.name])
        return complaints

    @property
    def earliest(self) -> float:
        """Time of the first edge that waits [s], inf if none does."""
        return min(line.earliest for line in self._lines)

    @property
    def latest(self) -> float:
        """Time of the last edge that waits [s], -inf if none does."""
        return max(line.latest for line in self._lines)

    def second(self, second: int) -> list[Complaint]:
        """Work on the second that begins at `second` [s]."""
        complaints: list[Complaint] = []
        for w, (line, tracker) in enumerate(zip(self._lines, self._trackers, strict=True)):
            time, _, more = line.take(float(second), second + 1.0)
            tracker.add(time)
            samples, texts = tracker.advance(second + 1.0)
            complaints += [*more, *((second + 1.0, f"{line.name}: {text}") for text in texts)]
            end = None if self._first[w] is None else self._first[w] + len(self._speed[w])  # type: ignore[operator]
            if end != samples.first:
                self._speed[w], self._first[w] = np.empty(0), samples.first
            self._speed[w] = np.concatenate([self._speed[w], samples.speed])
        return complaints

    def block(self, number: int) -> NDArray[np.float64]:
        """mean and std of ln f of block `number` by mode and wheel, shape (2, 4, 2); forgets what is before its end."""
        speed = np.array([self._cut(w, number * SIZE, (number + 1) * SIZE) for w in range(4)])
        self.omega = speed.mean(axis=1)
        found = np.full((2, 4, 2), np.nan)
        change = speed[:, -SIZE // 4 :].mean(axis=1) - speed[:, : SIZE // 4].mean(axis=1)
        for m, grid in enumerate(grids()):
            v = self.omega * self._radius
            steady = np.abs(change) * self._radius <= BETWEEN * grid.band.steadiest
            heard = np.flatnonzero((v >= grid.band.slowest) & (v <= grid.band.fastest) & steady)
            if len(heard):
                used = np.array([self._used(w, grid.frequency, float(change[w])) for w in heard.tolist()])
                found[m, heard] = grid.fit(speed[heard], used)
        return found

    def _cut(self, w: int, low: int, high: int) -> NDArray[np.float64]:
        """Samples low to high of a wheel, NaN where missing."""
        out, first = np.full(high - low, np.nan), self._first[w]
        if first is None:
            return out
        begin, end = max(low, first), min(high, first + len(self._speed[w]))
        if begin < end:
            out[begin - low : end - low] = self._speed[w][begin - first : end - first]
        keep = max(high - first, 0)
        self._speed[w], self._first[w] = self._speed[w][keep:], first + min(keep, len(self._speed[w]))
        return out

    def _used(self, w: int, frequency: NDArray[Any], change: float) -> NDArray[np.bool_]:
        """Which lines of a band count."""
        turns = float(self.omega[w]) / (2.0 * math.pi)
        ring = self._trackers[w].ring
        used = frequency < USABLE * ring.teeth * turns
        if float(ring.turns.min()) < LEARNT_TIME * turns:
            if abs(change) > STEADIEST * self.omega[w]:
                return np.zeros(len(frequency), dtype=bool)
            used &= ~order_lines(frequency, float(self.omega[w]), abs(change), ring.teeth // 2)
        return used

    def calibration(self) -> dict[str, Any]:
        """Tooth patterns by wheel (JSON values); empty while none is known."""
        found = {wheel: tracker.ring.document() for wheel, tracker in zip(WHEELS, self._trackers, strict=True)}
        return {wheel: document for wheel, document in found.items() if document is not None}

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """The inverse. ValueError if it is malformed."""
        for wheel, pattern in document.items():
            if wheel not in WHEELS:
                raise ValueError(f"tooth patterns have a wheel {wheel!r}, valid: {', '.join(WHEELS)}")
            self._trackers[WHEELS.index(wheel)].ring.use(pattern)
