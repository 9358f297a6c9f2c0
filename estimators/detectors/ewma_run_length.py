"""Exact average run length of a GMA (EWMA), by its integral equation.

g = phi g + (1 - phi) x, x ~ N(mean, std^2), alarm if g > h (one-sided) or |g| > h (both sides), from g = 0:
    L(z) = 1 + integral over the silent range of L(y) f(y | z) dy,  y | z ~ N(phi z + (1 - phi) mean, ((1 - phi) std)^2)
(Crowder, Technometrics 1987), solved by Gauss-Legendre Nystrom with node doubling. The silent range of a one-sided GMA
has no lower end; it is cut where the average comes with a chance below 1e-20, and the mass beyond stays at the cut.
"""

from __future__ import annotations

from math import ceil, sqrt

import numpy as np
from scipy.special import ndtr

from estimators.detectors.absorption import SIZES, legendre, mean_steps, size_above
from estimators.detectors.increments import normal_density

_REACH = 9.5  # standard deviations of the average


def ewma_run_length(
    threshold: float, forgetting: float, both_sides: bool, mean: float = 0.0, std: float = 1.0
) -> float:
    """Samples to the alarm. forgetting: phi in [0, 1), 0 is no memory."""
    spread = std * sqrt((1.0 - forgetting) / (1.0 + forgetting))
    low = -threshold if both_sides else min(0.0, mean) - _REACH * spread
    width = (1.0 - forgetting) * std
    if threshold <= low:
        return 1.0
    n = size_above(24 + 2 * ceil((threshold - low) / width))
    length = _nystrom(n, low, threshold, forgetting, width, mean, both_sides)
    while n < SIZES[-1]:
        n = size_above(n + 1)
        before, length = length, _nystrom(n, low, threshold, forgetting, width, mean, both_sides)
        if abs(length - before) <= 1e-8 * length:
            return length
    raise ArithmeticError(f"run length at forgetting {forgetting:g} is not resolved: about {length:g}, choose less")


def _nystrom(n: int, low: float, high: float, phi: float, width: float, mean: float, both_sides: bool) -> float:
    """Unknowns: L at 0 (asked for), at `low` (holds the mass beyond, one-sided only), and at n nodes."""
    nodes, weights = legendre(n, low, high)
    z = np.concatenate([[0.0, low], nodes])
    centre = phi * z + (1.0 - phi) * mean
    steps = np.zeros((n + 2, n + 2))
    steps[:, 2:] = weights * normal_density((nodes - centre[:, None]) / width) / width
    below, above = ndtr((low - centre) / width), ndtr((centre - high) / width)
    if both_sides:
        return mean_steps(steps, above + below)
    steps[:, 1] = below
    return mean_steps(steps, above)
