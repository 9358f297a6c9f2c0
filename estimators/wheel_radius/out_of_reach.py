"""Wheels that turn otherwise than any pressure makes them: a faulty speed sensor, another wheel, a tyre that slips.

The residuals' filters are bounded, so a wheel off by 5 % moves them by little, and for long: as a loss of a few tenths
of a per cent it would be told as a low tyre, or as the other ones'. Here each wheel's speed, over what the curve asks
of it, stands against the median of the four; leaky mean over MEMORY of what is driven without slipping as much
(MOST_PULL). Beyond REACH off no pressure is told, nor for AFTER of readable driving thereafter, until the filters have
forgotten. A mean tyre at zero pressure has lost 0.010 of its radius, the most sensitive 0.014 (`Car`). It is a flag,
no alarm: wheels slip as much on ice and in slaloms (as an alarm after 10 s it came 12 times in 7 h of sound drives)."""

from __future__ import annotations

import numpy as np

from estimators.car import Car
from estimators.drive_log import WHEELS
from estimators.wheel_radius.motion import Motion

REACH = 0.02  # [-] of radius, declared
UNKNOWN_RADIUS = 0.1  # [-], std of a radius that is then told, declared
SLOWEST = 3.0  # m/s
MOST_PULL = 0.2  # force over load of an axle; at a slip slope of 20 a wheel slips 1 % there
MEMORY, AFTER = 20, 300  # cells of 0.1 s


class OutOfReach:
    """State of four wheels."""

    def __init__(self, car: Car) -> None:
        self._radius = car.rolling_radius
        self._off = np.zeros(4)
        self._beyond = np.zeros(4, dtype=bool)
        self._rest = 0

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
        self._beyond = np.abs(self._off) > REACH
        self._rest = AFTER if self._beyond.any() else max(self._rest - 1, 0)

    @property
    def any(self) -> bool:
        """Whether no pressure can be told."""
        return self._rest > 0

    def wheels(self) -> list[str]:
        """Beyond it now."""
        return [wheel for wheel, beyond in zip(WHEELS, self._beyond, strict=True) if beyond]
