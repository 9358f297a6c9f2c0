"""What is true of a case: which wheels really are off the car's speed, and for how long it can be judged at all.

An outlier is a wheel more than OUTLIER off the car's true forward speed, whether it slips or its sensor lies. An alarm
is false if its wheel was within that for the SECOND before. A case ends where the car has spun: where it drifts at more
than SPUN, a wheel's speed is none along the car, and backwards tooth edges have no sign."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from estimators.car import Car
from estimators.wheel_plausibility.geometry import car_speeds
from estimators.wheel_plausibility.kernel import STEP, constants, sideways_speed
from testbed.study.wheel_plausibility.heard import Heard

KMH = 1.0 / 3.6
OUTLIER = 13.0 * KMH  # m/s
SECOND = round(1.0 / STEP)  # cells
SPUN, CREEPING = np.cos(np.radians(25.0)), 2.0  # forward over ground speed; m/s below which it is not asked


@dataclass(frozen=True)
class Truth:
    """end: cells that can be judged; off: |v_i - v| by the true v [m/s], worst: the largest of the last SECOND, (n, 4),
    NaN where a wheel said nothing."""

    end: int
    off: NDArray[np.float64]
    worst: NDArray[np.float64]


def truth(drive: Heard, car: Car) -> Truth:
    """By the true forward speed and yaw rate, and the steering angle that is measured."""
    c, off = constants(car), np.full((len(drive.index), 4), np.nan)
    speeds = np.empty(4)
    for k, (value, v, turn) in enumerate(zip(drive.value, drive.forward, drive.yaw_rate, strict=True)):
        steer = value[6] / c.ratio if np.isfinite(value[6]) else 0.0
        across = sideways_speed(c, v, turn)
        car_speeds(value[:4] * c.radius, turn, across, steer, c.front, c.rear, c.front_half, c.rear_half, speeds)
        off[k] = np.abs(speeds - v)
    spun = np.flatnonzero((drive.forward < SPUN * drive.speed) & (drive.speed > CREEPING))
    filled = np.nan_to_num(off)
    worst = maximum_filter1d(filled, SECOND, axis=0, origin=(SECOND - 1) // 2)
    return Truth(int(spun[0]) if len(spun) else len(off), off, worst)


def outliers(of: Truth) -> list[tuple[int, int, int]]:
    """Real ones: (wheel, first cell, cell after the last), each at least a quarter of a SECOND long."""
    found = []
    for wheel in range(4):
        over = np.concatenate([[False], np.nan_to_num(of.off[: of.end, wheel]) > OUTLIER, [False]])
        starts, ends = np.flatnonzero(~over[:-1] & over[1:]), np.flatnonzero(over[:-1] & ~over[1:])
        found += [(wheel, int(a), int(b)) for a, b in zip(starts, ends, strict=True) if b - a >= SECOND // 4]
    return found
