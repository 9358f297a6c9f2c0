"""Did a tyre's level fall once, or does it go on falling? Two least-squares fits of its last days' values, compiled.

    step    y = a before day k, b since
    leak    y = a before day k, a - rate (t - t_k) since

each with three parameters and the k that fits best; the smaller sum of squares is believed, a step only if it is much
smaller. A wheel or sensor change,
or a sudden loss, of a few noises is too small for one day to show it and would raise a CUSUM as a leak does.
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import compiled

LEAST = 6  # values that a step is told from
DECISIVE = 0.75  # of the leak's sum of squares, below which a step is believed; up to it, neither is
LEAK, STEP, EITHER = 0, 1, 2


@compiled
def step_misfit(y):
    """Least sum of squares of a step, and the first value after it."""
    n = len(y)
    best, where = np.inf, 0
    for k in range(1, n - 1):
        misfit = np.sum((y[:k] - np.mean(y[:k])) ** 2) + np.sum((y[k:] - np.mean(y[k:])) ** 2)
        if misfit < best:
            best, where = misfit, k
    return best, where


@compiled
def leak_misfit(t, y):
    """Least sum of squares of a level that begins to fall (or rise) on one of the days t."""
    centred = y - np.mean(y)
    best = np.sum(centred**2)
    for k in range(len(y) - 2):
        ramp = np.maximum(t - t[k], 0.0)
        ramp = ramp - np.mean(ramp)
        best = min(best, np.sum(centred**2) - np.sum(ramp * centred) ** 2 / np.sum(ramp**2))
    return best


@compiled
def shape_of(t, y):
    """LEAK, STEP, or EITHER until more days tell; and the first value after the step. t: days, rising, y: their values,
    shape (n,)."""
    if len(y) < LEAST:
        return LEAK, 0
    step, where = step_misfit(y)
    leak = leak_misfit(t, y)
    if leak <= step:
        return LEAK, where
    return (STEP if step < DECISIVE * leak else EITHER), where
