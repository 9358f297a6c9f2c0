"""How fast each side rolls and how the car turns, block by block, from wheel speeds and gyro.

Within a block a wheel's speed is the straight line through its samples, so that acceleration does not shift the delay.
A side's speed is the mean of its two wheels; a wheel that is further than `AGREE` from the median of the four (slip,
a dead sensor) does not count. Yaw rate: the gyro's mean, or without one the difference of the sides.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.vertical_pressure.intake import BLOCK

AGREE = 0.06  # of the median: a turn at 12 m radius
_TIME = (np.arange(BLOCK) + 0.5) / BLOCK - 0.5  # of a block


def line(value: NDArray[np.float64]) -> tuple[float, float]:
    """Level at the middle and rise over a block of value (BLOCK,), NaN where missing; (NaN, NaN) of none."""
    good = np.isfinite(value)
    count = int(good.sum())
    if count == 0:
        return float("nan"), float("nan")
    time, heard = _TIME[good], value[good]
    centre, mean = float(time.mean()), float(heard.mean())
    spread = float(np.sum((time - centre) ** 2))
    rise = float(np.sum((time - centre) * heard)) / spread if spread > 0.01 * count else 0.0
    return mean - rise * centre, rise


class Motion:
    """Of one block. speed: of left and right side [m/s], each a millisecond, (2, BLOCK), NaN where not known; mean:
    of the car; acceleration [m/s^2]; yaw_rate [rad/s]."""

    def __init__(self, car: Car, wheels: NDArray[np.float64], gyro: NDArray[np.float64]) -> None:
        """wheels: rad/s of fl fr rl rr, (BLOCK, 4); gyro: rad/s, (BLOCK,); NaN where missing."""
        lines = np.array([line(w) for w in wheels.T]) * car.rolling_radius
        known = np.isfinite(lines[:, 0])
        self.mean = float(np.median(lines[known, 0])) if known.any() else float("nan")
        with np.errstate(invalid="ignore"):
            agreed = known & (np.abs(lines[:, 0] - self.mean) <= AGREE * self.mean)
        self.acceleration = float(np.median(lines[agreed, 1])) / (BLOCK * 1e-3) if agreed.any() else 0.0
        self.speed = np.full((2, BLOCK), np.nan)
        levels = []
        for side in range(2):
            own = [w for w in (side, 2 + side) if agreed[w]] or [w for w in range(4) if agreed[w]]
            if own:
                level, rise = lines[own].mean(axis=0)
                self.speed[side] = level + rise * _TIME
                levels.append(level)
        track = 0.5 * (car.front_track + car.rear_track)
        turning = (levels[1] - levels[0]) / track if len(levels) == 2 else 0.0
        heard = gyro[np.isfinite(gyro)]
        self.yaw_rate = float(heard.mean()) if len(heard) else float(turning)


def stretch(speed: float, acceleration: float, wheelbase: float) -> float:
    """Speed of the front wheel, when it was where the rear wheel is now, over the present speed [-]; m/s, m/s^2, m."""
    return float(np.sqrt(max(1.0 - 2.0 * acceleration * wheelbase / speed**2, 0.25)))
