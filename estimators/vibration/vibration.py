"""Vibration of the four wheels from a car's signals: the plain class that a fusion builds on.

    vibration = Vibration(car)
    heard = vibration.update(samples, until)     # as `Estimator.update`; whole seconds, however the stream is cut
    for reading in heard.readings: ...           # see `wheel_vibration.Reading`

Each second gives a `running` reading for each wheel and mode, and now and then a `block` one, which rests on its own
some 8 s alone: average blocks with their `information` (of ln frequency), or add up their ln likelihoods
-information / 2 (ln frequency - ln expected)^2. `reading.mode` has what a change of pressure does (`sensitivity`) and
by how much roads and speeds move the frequency all the same (`road_std`, of ln f).

A wheel with edges is read from them; one that only has a bus speed from that, if its rate carries the mode.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimators.car import Car
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Flag
from estimators.grid import LATENCY, REPEAT
from estimators.vibration.line import Complaint, Line
from estimators.vibration.modes import MODES, Mode
from estimators.vibration.wheel_vibration import Reading, WheelVibration
from estimators.wheel_speed.bus_speed import BusSpeed
from estimators.wheel_speed.edge_speed import EdgeSpeed

EDGES = {wheel: f"wheel/{wheel}/edges" for wheel in WHEELS}
SPEEDS = {wheel: f"wheel/{wheel}/speed" for wheel in WHEELS}
READS = (*EDGES.values(), *SPEEDS.values())
TURNING = 1.0  # rad/s: a wheel of which edges should be heard
LONGEST_SILENCE = 3600.0  # s without any sample, over which the clock jumps


@dataclass(frozen=True)
class Heard:
    """readings and flags in time order."""

    readings: tuple[Reading, ...] = ()
    flags: tuple[Flag, ...] = ()


class _Wheel:
    """Lines, tracker and analysis of one wheel."""

    def __init__(self, wheel: str, car: Car, modes: tuple[Mode, ...]) -> None:
        self.edges, self.speed = Line(EDGES[wheel]), Line(SPEEDS[wheel])
        self.tracker, self.bus = EdgeSpeed(), BusSpeed()
        self.analysis = WheelVibration(wheel, car.rolling_radius, modes)
        self._modes = modes
        self._has_edges = self._has_speed = False
        self._carried: tuple[str, ...] | None = None  # modes that the bus speed carries, as last said

    def advance(self, begin: float, end: float) -> tuple[list[Reading], list[Complaint]]:
        """The second from `begin` to `end` [s]."""
        time, _, complaints = self.edges.take(begin, end)
        stamps, speeds, more = self.speed.take(begin, end)
        complaints += more
        self._has_edges |= len(time) > 0
        self._has_speed |= len(stamps) > 0
        if self._has_edges:
            self.tracker.add(time)
            samples, texts = self.tracker.advance(end)
            complaints += [(end, f"{self.edges.name}: {text}") for text in texts]
            return self.analysis.advance(samples, end, float(self.tracker.ring.turns.min())), complaints
        if not self._has_speed:
            return [], complaints
        self.bus.add(stamps, np.clip(np.abs(speeds), 0.0, 1e3))
        samples, _ = self.bus.advance(end)
        carried = tuple(mode.name for mode in self._modes if self.bus.carries(mode.highest_needed))
        turns = len(speeds) > 0 and float(np.median(np.abs(speeds))) > TURNING
        if turns and carried != self._carried and len(carried) < len(self._modes):
            self._carried = carried
            lost = " and ".join(mode.name for mode in self._modes if mode.name not in carried)
            text = f"{lost} frequency not observable at {self.bus.rate:.3g} Hz, from edges only"
            complaints.append((end, f"{self.speed.name}: {text}"))
        readings = self.analysis.advance(samples, end, math.inf)
        return [r for r in readings if r.mode.name in carried], complaints


class Vibration:
    """Running analysis of a car. modes: those that are read."""

    def __init__(self, car: Car, modes: tuple[Mode, ...] = MODES) -> None:
        self._wheels = {wheel: _Wheel(wheel, car, modes) for wheel in WHEELS}
        self._second: int | None = None
        self._raised: dict[str, float] = {}

    def update(self, samples: Mapping[str, Signal], until: float) -> Heard:
        """Take the samples that arrived before `until` [s]; say what the seconds since the last call held."""
        complaints: list[Complaint] = []
        lines = [line for w in self._wheels.values() for line in (w.edges, w.speed)]
        for line in lines:
            if line.name in samples:
                complaints += line.add(samples[line.name])
        flags = self._flags(complaints)
        readings: list[Reading] = []
        last = math.floor(until - LATENCY + 1e-9)
        while (second := self._following(lines, last)) is not None:
            complaints = []
            for wheel in self._wheels.values():
                said, more = wheel.advance(float(second), second + 1.0)
                readings += said
                complaints += more
            flags += self._flags(complaints)
        return Heard(tuple(sorted(readings, key=lambda r: r.time)), tuple(sorted(flags)))

    def _following(self, lines: list[Line], last: int) -> int | None:
        """The next whole second to work on: one before `last` up to which a sample waits; None if there is none. So
        the clock goes on while any wheel says something, bus speeds of a standing car included."""
        earliest, latest = min(line.earliest for line in lines), max(line.latest for line in lines)
        if not math.isfinite(earliest):
            return None
        if self._second is None or earliest - self._second > LONGEST_SILENCE:
            self._second = math.floor(earliest)
            for wheel in self._wheels.values():
                wheel.analysis.forget()
        if self._second >= last or self._second > latest:
            return None
        self._second += 1
        return self._second - 1

    def _flags(self, complaints: list[Complaint]) -> list[Flag]:
        """Complaints in time order, the same text at most once in `REPEAT` seconds."""
        flags = []
        for time, text in sorted(complaints):
            if time - self._raised.get(text, -math.inf) >= REPEAT:
                self._raised[text] = time
                flags.append(Flag(time, text))
        return flags

    def calibration(self) -> dict[str, Any] | None:
        """Tooth patterns by wheel (JSON values), None while none is known."""
        found = {wheel: w.tracker.ring.document() for wheel, w in self._wheels.items()}
        return {"teeth": {w: d for w, d in found.items() if d is not None}} if any(found.values()) else None

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """Start from `calibration()` of an earlier drive. ValueError if it is malformed."""
        teeth = document.get("teeth")
        if set(document) != {"teeth"} or not isinstance(teeth, Mapping):
            raise ValueError(f"vibration's calibration has {sorted(document)}, valid: teeth, a mapping by wheel")
        for wheel, pattern in teeth.items():
            if wheel not in self._wheels:
                raise ValueError(f"vibration's calibration has a wheel {wheel!r}, valid: {', '.join(WHEELS)}")
            self._wheels[wheel].tracker.ring.use(pattern)
