"""The bank of steady filters over stiffness and road level, for the present speed, of one axle's two wheels.

Nodes: `STIFFNESSES` (6 % apart) times `LEVELS` (a factor 4 apart; what lies between is `posterior`'s). Filters depend
on speed through the road's intensity and the footprint's delay; they are designed when the speed has moved by
`SPEED_STEP` and kept for when it comes back. All of them hear every sample, whatever they are believed, so that the
right one has settled when the road changes. State of each filter as in `chain`.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.vertical_pressure.anti_alias import RATE, STEP, analogue
from estimators.vertical_pressure.chain import FIRST_LOW_PASS, Quarter, continuous, sampled
from estimators.vertical_pressure.innovations import filter_from, step

STIFFNESSES = np.exp(np.linspace(math.log(95e3), math.log(370e3), 24))  # N/m
LEVELS = 1e-6 * 4.0 ** np.arange(-1.0, 5.0)  # G at 1 rad/m [m^3/rad]: half of class A's lower limit to class E
SPEED_STEP = 0.05  # of ln speed: the footprint is a fortieth wrong at most
_KEPT = 256  # designs, 60 kB each
SENSOR_STD = 0.5  # m/s^2 at 1 kHz: the paper's data sheet
SENSOR_VARIANCE = SENSOR_STD**2 / (RATE * STEP)  # of a decimated sample: the same density over its narrower band
# (m/s^2)^2: below it the sensor hears itself and no road; the lowest level at the slowest speed makes twice as much
QUIET = 3.0 * SENSOR_VARIANCE
STATES = FIRST_LOW_PASS + len(analogue()[1])


@compiled
def design(quarter, speed, low, stiffnesses, levels, sensor_variance, dt):
    """(A (k, n, n), c (k, n), K (k, l, n), S (k, l)) of all nodes; S in units of their level."""
    n, k, m = FIRST_LOW_PASS + len(low[1]), len(stiffnesses), len(levels)
    A, c, K, S = np.empty((k, n, n)), np.empty((k, n)), np.empty((k, m, n)), np.empty((k, m))
    for i in range(k):
        M, b, C = continuous(quarter, stiffnesses[i], speed, low[0], low[1], low[2])
        A[i], Q = sampled(M, b, dt)
        c[i] = C[1]
        for j in range(m):
            K[i, j], S[i, j] = filter_from(A[i], c[i], Q, speed, quarter.hub_error, levels[j], sensor_variance)
    return A, c, K, S


@compiled
def hear(A, c, K, S, samples, x, summed):
    """Runs all filters over samples (n,); x (k, l, n) moves on; summed (k, l) gets the sums of nu^2 / S."""
    scratch = np.empty(A.shape[1])
    summed[:] = 0.0
    for i in range(K.shape[0]):
        for j in range(K.shape[1]):
            for t in range(len(samples)):
                nu = step(A[i], c[i], K[i, j], x[i, j], scratch, samples[t])
                summed[i, j] += nu * nu / S[i, j]


@lru_cache(maxsize=_KEPT)
def _designed(quarter: Quarter, place: int) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    speed = math.exp(place * SPEED_STEP)
    return design(quarter, speed, analogue(), STIFFNESSES, LEVELS, SENSOR_VARIANCE, STEP)


class AxleBank:
    """Filters of one axle by speed. A speed is rounded to a grid of SPEED_STEP, the last one kept while it is near."""

    def __init__(self, quarter: Quarter) -> None:
        self.quarter = quarter
        self._place: int | None = None

    def at(self, speed: float) -> tuple[NDArray, NDArray, NDArray, NDArray]:
        """`design` for a speed [m/s]; shared, not to be written to."""
        exact = math.log(speed) / SPEED_STEP
        if self._place is None or abs(exact - self._place) > 0.75:
            self._place = round(exact)
        return _designed(self.quarter, self._place)


def at_rest() -> NDArray[np.float64]:
    """States of one wheel's filters at the start."""
    return np.zeros((len(STIFFNESSES), len(LEVELS), STATES))
