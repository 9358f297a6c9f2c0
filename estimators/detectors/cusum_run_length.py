"""Exact average run length of a one-sided CUSUM, by its integral equation.

g = max(g + s - k, 0), alarm if g > h. With F the distribution of s, the run length from g = z is
    L(z) = 1 + F(k - z) L(0) + integral over (0, h] of L(y) dF(y - z + k)                        (thesis 2.20 to 2.23)
where the first term is the atom of g at 0. Two solutions:
- `gaussian_run_length`: Gauss-Legendre Nystrom, for s ~ N(mean, std^2); the kernel is smooth, so it converges at once.
- `run_length`: L piecewise linear on equal cells, exact integrals of dF over each; for any F, also with atoms and
  singular densities (chi-square), where Nystrom fails. Cells are halved, with Richardson's extrapolation, until two
  results agree.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from estimators.detectors.absorption import SIZES, legendre, mean_steps, size_above
from estimators.detectors.increments import Increments, normal_density

AGREE = 5e-5  # relative, of two successive extrapolations; the last is about four times as good
ROUGHLY = 0.03  # the same, for the first steps of a search
CLOSE = 5e-3  # the same, at the finest cells: else the result is refused
_MOST_CELLS = 2048

Array = NDArray[np.float64]


def gaussian_run_length(threshold: float, drift: float, mean: float = 0.0, std: float = 1.0) -> float:
    """Samples to the alarm from g = 0, for s ~ N(mean, std^2)."""
    h, k = threshold / std, (drift - mean) / std
    if h == 0.0:
        return float(1.0 / max(ndtr(-k), 1e-300))
    n = size_above(16 + 2 * ceil(h))
    length = _nystrom(n, h, k)
    while n < SIZES[-1]:
        n *= 2
        before, length = length, _nystrom(n, h, k)
        if abs(length - before) <= 1e-9 * length:
            break
    return length


def _nystrom(n: int, h: float, k: float) -> float:
    """Unknowns: L at 0 and at n nodes."""
    nodes, weights = legendre(n, 0.0, h)
    z = np.concatenate([[0.0], nodes])
    steps = np.empty((n + 1, n + 1))
    steps[:, 0] = ndtr(k - z)
    steps[:, 1:] = weights * normal_density(nodes - z[:, None] + k)
    return mean_steps(steps, ndtr(z - h - k))


def run_length(threshold: float, drift: float, increments: Increments, agree: float = AGREE) -> float:
    """Samples to the alarm from g = 0, for s of any distribution. ArithmeticError if it cannot be resolved."""
    if threshold == 0.0:
        return float(1.0 / max(float(increments.tail(np.array([drift]))[0]), 1e-300))
    cells, length, best = 32, _collocation(32, threshold, drift, increments), np.nan
    while cells < _MOST_CELLS:
        cells *= 2
        before, length = length, _collocation(cells, threshold, drift, increments)
        previous, best = best, length + (length - before) / 3.0
        if abs(best - previous) <= agree * best:
            return best
    if abs(best - previous) <= CLOSE * best:
        return best
    raise ArithmeticError(f"run length at threshold {threshold:g} and drift {drift:g} is not resolved: about {best:g}")


def _collocation(cells: int, h: float, k: float, increments: Increments) -> float:
    """Unknowns: L at cells + 1 equal steps from 0 to h. The integrals depend on the difference of two nodes alone."""
    width = h / cells
    u: Array = k + width * np.arange(-cells, cells + 1, dtype=np.float64)
    inside, moment = np.diff(increments.cdf(u)), np.diff(increments.partial_mean(u))
    left = np.maximum((u[1:] * inside - moment) / width, 0.0)  # weight of the left node of each cell
    right = np.maximum((moment - u[:-1] * inside) / width, 0.0)
    difference = cells + np.arange(cells)[None, :] - np.arange(cells + 1)[:, None]
    steps = np.zeros((cells + 1, cells + 1))
    steps[:, :-1] += left[difference]
    steps[:, 1:] += right[difference]
    steps[:, 0] += increments.cdf(u[cells::-1])
    return mean_steps(steps, increments.tail(u[: cells - 1 : -1]))
