"""Does the pinion stand where steering wheel and motor put it? The motor's angle as the pinion tells it.

    delta_G = a delta_S + b delta_M + e d delta_S/dt + f d delta_M/dt + c        (1.1) with signals of unlike delay
    pinion error = delta_M - (delta_G - a delta_S - e d delta_S/dt - f d delta_M/dt) / b - offset    [rad of motor]

offset: what the sensors' own adjustment leaves, of each car its own (0.3 deg of the pinion is 12 of the motor), a slow
random walk, followed a BLOCK at a time and not while the error is accused. An error that is there before the first
block counts as such an offset, as far as PRIOR allows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.steering_actuator.residuals import STEP

BLOCK = round(1.0 / STEP)  # cells
PRIOR = np.radians(20.0)  # rad of motor: std of the offset at first. Declared
WALK = np.radians(0.05)  # rad per sqrt(s). Declared
NOISE, LATE = np.radians(3.0), 0.02  # rad, s of the motor's speed: std of a block's mean. Declared
SURE = np.radians(4.0)  # rad: std of the offset from which on the error is judged
WILD = 1e6  # rad/s

Array = NDArray[np.float64]


class Ratios(NamedTuple):
    """a, b, e [s], f [s]; see the module."""

    wheel: float
    motor: float
    wheel_lag: float
    motor_lag: float


def ratios(pinion: Array, wheel: Array, motor: Array) -> Ratios:
    """Least squares over a drive, (n,) each [rad], NaN where missing. ValueError where they cannot be told."""
    rows = np.column_stack([wheel, motor, rates(wheel, np.nan), rates(motor, np.nan), np.ones(len(wheel))])
    kept = np.isfinite(rows).all(axis=1) & np.isfinite(pinion)
    if kept.sum() < 10:
        raise ValueError(f"{kept.sum()} cells with all three angles, want at least 10")
    found, _, rank, _ = np.linalg.lstsq(rows[kept] / (scale := np.abs(rows[kept]).max(axis=0) + 1e-12), pinion[kept])
    if rank < 5:
        raise ValueError("steering wheel and motor move only together, their ratios cannot be told apart")
    return Ratios(*(found / scale)[:4].tolist())


def checked_ratios(found: Ratios) -> Ratios:
    """ValueError unless they make sense."""
    if not (np.isfinite(found).all() and found.motor != 0.0):
        raise ValueError(f"ratios are {tuple(found)}, valid: finite numbers, that of the motor not 0")
    return found


def rates(angle: Array, before: float) -> Array:
    """Change over a cell [rad/s], (n,); before: the cell before the first, NaN without one. 0 where unknown."""
    change = np.diff(np.concatenate([[before], angle])) / STEP
    return np.where(np.isfinite(change), np.clip(change, -WILD, WILD), 0.0)


class Pinion:
    """The error before and after its offset, block by block of cells that follow one another."""

    def __init__(self, found: Ratios) -> None:
        self._ratios = found
        self._last = (np.nan, np.nan)
        self._offset, self._variance, self._started = 0.0, PRIOR * PRIOR, False
        self._sums = np.zeros(3)  # cells, of the error, of the motor's speed squared, in this block

    def raw(self, pinion: Array, wheel: Array, motor: Array) -> tuple[Array, Array]:
        """Error with its offset [rad of motor], (n,); its causes (n, 2): speeds of motor and steering wheel [rad/s]."""
        turning, running = rates(wheel, self._last[0]), rates(motor, self._last[1])
        if len(wheel):
            self._last = float(wheel[-1]), float(motor[-1])
        a, b, e, f = self._ratios
        return motor - (pinion - a * wheel - e * turning - f * running) / b, np.column_stack([running, turning])

    def piece(self, error: Array) -> tuple[Array, float]:
        """Without the offset, NaN as long as none is known; and what it is unsure by [rad]. Cells of one block."""
        if not self._started:
            return np.full(len(error), np.nan), 0.0
        return error - self._offset, self._variance**0.5

    def learn(self, error: Array, causes: Array, ends: bool, accused: bool) -> None:
        """Takes a piece of a block, with its offset; `ends`: the last one."""
        known = np.isfinite(error)
        parts = np.stack([np.ones(int(known.sum())), error[known], causes[known, 0] ** 2])
        self._sums = np.cumsum(np.concatenate([self._sums[:, None], parts], axis=1), axis=1)[:, -1]
        if not ends:
            return
        count, total, squares = self._sums.tolist()
        self._variance += WALK * WALK * BLOCK * STEP
        if count >= BLOCK // 4 and not accused:
            noise = NOISE * NOISE + LATE * LATE * squares / count
            gain = self._variance / (self._variance + noise)
            self._offset += gain * (total / count - self._offset)
            self._variance *= 1.0 - gain
            self._started |= self._variance < SURE * SURE
        self._sums = np.zeros(3)

    def forget(self) -> None:
        """After a silence: the angles before it, not the offset."""
        self._last = (np.nan, np.nan)
        self._sums = np.zeros(3)


def without_offset(found: Ratios, pinion: Array, wheel: Array, motor: Array) -> tuple[Array, Array]:
    """Of a sound drive from its beginning: error, (n,), and causes, (n, 2)."""
    check = Pinion(found)
    raw, causes = check.raw(pinion, wheel, motor)
    parts = []
    for begin in range(0, len(raw), BLOCK):
        span = slice(begin, begin + BLOCK)
        parts.append(check.piece(raw[span])[0])
        check.learn(raw[span], causes[span], True, False)
    return np.concatenate(parts), causes
