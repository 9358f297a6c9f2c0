"""Wheels that turn otherwise than any pressure makes them: a faulty speed sensor, a flat tyre, another wheel.

The residuals' filters are bounded, so a wheel off by 5 % moves them by little, and for long: as a loss of a few tenths
of a per cent it would be told as a low tyre, or as the other ones'. Here each wheel's speed, over what the curve asks
of it, stands against the median of the four; leaky mean over MEMORY of what is driven without slipping as much
(MOST_PULL). Beyond REACH off no pressure is told, nor for AFTER of readable driving thereafter, until the filters have
forgotten. A mean tyre at zero pressure has lost 0.010 of its radius, the most sensitive 0.014 (`Car`). A wheel that has
turned faster for FLAT_AFTER is a flat tyre or its sensor: an alarm says so, once; a spin does not last as long."""

from __future__ import annotations

import numpy as np

from estimators.car import Car
from estimators.drive_log import WHEELS
from estimators.wheel_radius.motion import Motion

REACH = 0.02  # [-] of radius, declared
UNKNOWN_RADIUS = 0.1  # [-], std of a radius that is then told, declared
SLOWEST = 3.0  # m/s
MOST_PULL = 0.2  # force over load of an axle; at a slip slope of 20 a wheel slips 1 % there
MEMORY, AFTER, FLAT_AFTER = 20, 300, 100  # cells of 0.1 s


class OutOfReach:
    """State of four wheels."""

    def __init__(self, car: Car) -> None:
        self._radius = car.rolling_radius
        self._off = np.zeros(4)
        self._beyond = np.zeros(4, np.int64)  # cells for which a wheel has been beyond
        self._rest = 0
        self._announced: set[int] = set()

    def step(self, motion: Motion) -> None:
        """One cell."""
        even = motion.omega / motion.roll
        if np.isfinite(even).sum() < 3 or not np.nanmedian(even) * self._radius > SLOWEST:
            return
        if np.abs(motion.pull).max() > MOST_PULL:
            return
        off = even / np.nanmedian(even) - 1.0
        heard = np.isfinite(off)
        self._off[heard] += (np.clip(off[heard], -1.0, 1.0) - self._off[heard]) / MEMORY
        self._off[~heard] = 0.0
        beyond = np.abs(self._off) > REACH
        self._beyond = np.where(beyond, self._beyond + 1, 0)
        self._rest = AFTER if beyond.any() else max(self._rest - 1, 0)

    @property
    def any(self) -> bool:
        """Whether no pressure can be told."""
        return self._rest > 0

    def wheels(self) -> list[str]:
        """Beyond it now."""
        return [wheel for wheel, count in zip(WHEELS, self._beyond, strict=True) if count]

    def flat(self) -> list[tuple[str, float]]:
        """Wheels that have been smaller by that much for long and were not told before, with how much [-]."""
        due = [i for i in range(4) if self._beyond[i] >= FLAT_AFTER and self._off[i] > 0.0 and i not in self._announced]
        self._announced |= set(due)
        return [(WHEELS[i], float(self._off[i])) for i in due]
