"""Whether a hub's accelerometer still tells gravity: its mean gives a faulty one away before its road is believed.

A hub goes nowhere on the whole, so the mean of its vertical specific force is g whatever the road; a wrong scale, an
offset, a dead or a stuck sensor, nothing but noise, a loose contact move it. Leaky mean over MEMORY, block by block;
not believed from LIMIT off (or SHARE of what the hub feels, on very rough roads) until BACK of that. Sound drives on
classes A to D come to 0.9 m/s^2, offsets of 0.33 included. What it cannot see: a small scale error (below 10 %), and
noise on top of a sound signal."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.car import GRAVITY
from estimators.estimator import Flag

MEMORY = 2.0  # s
LIMIT = 1.1  # m/s^2, declared: ten times the spread of such sensors' offsets
SHARE = 0.15  # of the r.m.s. that is felt, declared
BACK = 0.7
DOUBT = 0.6  # of that, from which on an alarm waits for what becomes of it


class GravityCheck:
    """One hub. seconds: of a block."""

    def __init__(self, seconds: float) -> None:
        self._keeps = math.exp(-seconds / MEMORY)
        self._off, self._square = 0.0, 0.0
        self.believed = True
        self.doubted = False

    def block(self, value: NDArray[np.float64]) -> bool:
        """Takes a block, NaN where missing, shape (n,). Whether the sensor is believed now."""
        finite = value[np.isfinite(value)] - GRAVITY
        if len(finite):
            with np.errstate(over="ignore"):
                finite = np.clip(finite, -1e3, 1e3)
            self._off += (1.0 - self._keeps) * (float(finite.mean()) - self._off)
            self._square += (1.0 - self._keeps) * (float(np.mean(finite**2)) - self._square)
        most = max(LIMIT, SHARE * math.sqrt(max(self._square - self._off**2, 0.0)))
        self.believed = abs(self._off) < (most if self.believed else BACK * most)
        self.doubted = abs(self._off) > DOUBT * most
        return self.believed

    @property
    def mean(self) -> float:
        """[m/s^2]"""
        return GRAVITY + self._off


def not_gravity(signal: str, time: float, mean: float) -> Flag:
    """What a reader is told of a sensor that is not believed."""
    return Flag(time, f"{signal}: its mean of {mean:.1f} m/s^2 is not gravity, not used")
