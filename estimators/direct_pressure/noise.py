"""How noisy the pressure samples are, how coarse, and how often they come: measured, since no log says it.

The variance of a sample is first taken from second differences (a ramp, and so a leak, has none), then follows the
squared whitened innovations, each at most 9; it is frozen while a CUSUM is above half its threshold. It is never below
that of the rounding, which repeats itself and so cannot be seen while nothing moves. Until it is well known it is taken
larger, by two of its standard deviations, for alarms.
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import inlined
from estimators.direct_pressure.numbers import LONGEST_WEIGHT, MODEL, PRIOR_WEIGHT, WARM_UP, WARM_UP_TIME

VARIANCE, WEIGHT, COUNT, INTERVAL, STEP, LAST, Z1, Z2, SQUARES, WARM, SIZE = range(11)
CLIPPED = 9.0
MEAN_CLIPPED = 0.97867  # of min(x^2, 9), x standard normal
CORRELATED = 0.5  # second differences tell half as much as independent ones
LEAST_STEP = 1.0  # Pa: smaller differences are no rounding


@inlined
def start(n):
    """Nothing heard yet."""
    n[:] = 0.0
    n[VARIANCE], n[WEIGHT], n[STEP], n[LAST] = MODEL.noise_std**2, PRIOR_WEIGHT, np.inf, np.nan
    n[WARM] = 1.0


@inlined
def heard(n, dt, raw, z):
    """Counts a sample: dt since the last [s] (0 for the first), the sensor's value [Pa], and at reference temperature
    [Pa]. During the warm-up the variance is measured."""
    n[COUNT] += 1.0
    change = abs(raw - n[LAST])
    if change > LEAST_STEP:
        n[STEP] = min(n[STEP], change)
    n[LAST] = raw
    if n[COUNT] == 2.0:
        n[INTERVAL] = dt
    elif n[COUNT] > 2.0 and (dt < 5.0 * n[INTERVAL] or n[COUNT] < 10.0):
        n[INTERVAL] += (dt - n[INTERVAL]) / min(n[COUNT] - 1.0, 300.0)
    warm = n[WARM] > 0.0
    if warm and n[COUNT] >= 3.0:
        n[SQUARES] += (z - 2.0 * n[Z1] + n[Z2]) ** 2 / 6.0
        told = n[COUNT] - 2.0
        n[VARIANCE] = (PRIOR_WEIGHT * MODEL.noise_std**2 + n[SQUARES]) / (PRIOR_WEIGHT + told)
        n[WEIGHT] = PRIOR_WEIGHT + CORRELATED * told
    n[Z2], n[Z1] = n[Z1], z
    if warm and n[COUNT] > WARM_UP and n[COUNT] * n[INTERVAL] > WARM_UP_TIME:
        n[WARM] = 0.0
    return warm and n[WARM] == 0.0


@inlined
def follow(n, square):
    """A squared innovation in units of its variance [-]."""
    n[WEIGHT] = min(n[WEIGHT] + 1.0, LONGEST_WEIGHT)
    n[VARIANCE] *= 1.0 + (min(square, CLIPPED) / MEAN_CLIPPED - 1.0) / n[WEIGHT]


@inlined
def likely(n):
    """Variance of a sample [Pa^2], as it is likely to be."""
    step = n[STEP] if n[STEP] < np.inf else MODEL.noise_std * 12.0**0.5
    return max(n[VARIANCE], step**2 / 12.0 + MODEL.least_noise_std**2)


@inlined
def variance(n):
    """The same, on the safe side: for alarms."""
    return likely(n) * (1.0 + 2.0 * (2.0 / n[WEIGHT]) ** 0.5)
