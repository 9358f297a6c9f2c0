"""Exact average run length of an integrator that is zeroed every N samples (thesis: AC, ACS, ACF).

S_n = sum of n residuals x ~ N(mean, std^2), alarm if S_n > h or |S_n| > h for some n <= N. The density of S_n on paths
without an alarm is carried from n to n + 1 on Gauss-Legendre nodes; e_n is the chance of the alarm at n. Periods are
independent, so with the chance E = e_1 + ... + e_N of an alarm within a period
    L = (sum of P(no alarm up to n), n = 0 .. N-1) / E
N = 1 is a plain threshold: L = 1 / P(|x| > h). Summing e_n avoids 1 - P(no alarm), which would cancel.
"""

from __future__ import annotations

from math import ceil, sqrt

import numpy as np
from scipy.special import ndtr

from estimators.detectors.absorption import legendre, size_above
from estimators.detectors.increments import normal_density

LONGEST_PERIOD = 2000
_REACH = 9.0  # standard deviations of the sum, below which a one-sided integrator never is


def integrator_run_length(
    threshold: float, period: int, both_sides: bool, mean: float = 0.0, std: float = 1.0
) -> float:
    """Samples to the alarm from a fresh start; one-sided means upward."""
    h, m = threshold / std, mean / std
    low = -h if both_sides else min(0.0, m * period) - _REACH * sqrt(period)

    def alarm_from(sums: np.ndarray) -> np.ndarray:
        up = ndtr(sums + m - h)
        return up + ndtr(low - sums - m) if both_sides else up

    alarms = [float(alarm_from(np.zeros(1))[0])]
    if period > 1 and h > low:
        nodes, weights = legendre(size_above(32 + 2 * ceil(h - low)), low, h)
        carry = weights * normal_density(nodes[:, None] - nodes - m)  # from the second index to the first
        density, leaving = normal_density(nodes - m), weights * alarm_from(nodes)
        for _ in range(period - 1):
            alarms.append(float(leaving @ density))
            density = carry @ density
    within = np.cumsum(alarms)
    if within[-1] <= 0.0:
        return np.inf
    return float((1.0 + np.sum(1.0 - within[:-1])) / within[-1])
