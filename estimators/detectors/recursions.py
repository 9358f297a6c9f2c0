"""What each kind of detector does with one sample: compiled recursions on a small state.

x: residual in units of its own standard deviation before a change. Every recursion has the signature (numbers, state,
x) -> statistic >= 0; `numbers` are the kind's parameters, of which the first two are 1 or 0 for whether an upward and a
downward change is looked for; `state` is all zeros after a reset. Sources: Razavi, Error Detection in the Active Front
Steering system, Lund 2006 (equations by its numbers); Basseville & Nikiforov, Detection of Abrupt Changes, 1993.

    CUSUM         g+ = max(g+ + x - k+, 0), g- = max(g- - x - k-, 0)                          (2.13), (2.26)
    CUSUM_SQUARE  the same with x^2 for x                                                      (2.18)
    EWMA          g = phi g + (1 - phi) x, phi the forgetting factor (1 - alpha of 2.29)       (2.29), (2.30)
    GLR           max over n <= N of (sum of the last n x)^2 / (2 n): unknown shift in the last N samples
    LOCAL_CUSUM   for each channel a CUSUM of x where |x| <= limit, 0 else, in units of its threshold   (chapter 3)
    INTEGRATOR    |sum of x since it was last zeroed|, zeroed every N samples    (4.2.1: AC for N = 1, else ACF, ACS)

Left out: any notion of time; a lost sample is no sample.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined

CUSUM, CUSUM_SQUARE, EWMA, GLR, LOCAL_CUSUM, INTEGRATOR = range(6)
LARGEST = 1e100  # a finite sample beyond counts as this, so that its square and sums of it stay finite

Array = NDArray[np.float64]


@inlined
def _cusum(numbers: Array, state: Array, x: float) -> float:
    up, down = state[0] + x - numbers[2], state[1] - x - numbers[3]
    state[0] = up if up > 0.0 and numbers[0] > 0.0 else 0.0
    state[1] = down if down > 0.0 and numbers[1] > 0.0 else 0.0
    return max(state[0], state[1])


@inlined
def _ewma(numbers: Array, state: Array, x: float) -> float:
    state[0] = numbers[2] * state[0] + (1.0 - numbers[2]) * x
    return max(numbers[0] * state[0], -numbers[1] * state[0], 0.0)


@inlined
def _glr(numbers: Array, state: Array, x: float) -> float:
    """state: how many samples the window holds, the place of the next one, the window as a ring."""
    window = int(numbers[2])
    place = int(state[1])
    state[2 + place] = x
    state[1] = (place + 1) % window
    state[0] = min(state[0] + 1.0, numbers[2])
    total, most = 0.0, 0.0
    for n in range(1, int(state[0]) + 1):
        total += state[2 + place]
        place = place - 1 if place > 0 else window - 1
        if (total > 0.0 and numbers[0] > 0.0) or (total < 0.0 and numbers[1] > 0.0):
            most = max(most, total * total / (2.0 * n))
    return most


@inlined
def _local_cusum(numbers: Array, state: Array, x: float) -> float:
    """numbers: after the sides, limit, drift and threshold of each channel. state: g+ and g- of each channel."""
    most = 0.0
    for c in range((len(numbers) - 2) // 3):
        limit, drift, threshold = numbers[2 + 3 * c], numbers[3 + 3 * c], numbers[4 + 3 * c]
        seen = x if abs(x) <= limit else 0.0
        if numbers[0] > 0.0:
            state[2 * c] = max(state[2 * c] + seen - drift, 0.0)
        if numbers[1] > 0.0:
            state[2 * c + 1] = max(state[2 * c + 1] - seen - drift, 0.0)
        most = max(most, max(state[2 * c], state[2 * c + 1]) / threshold)
    return most


@inlined
def _integrator(numbers: Array, state: Array, x: float) -> float:
    """state: the sum, the number of samples in it."""
    if state[1] >= numbers[2]:
        state[0] = state[1] = 0.0
    state[0] += x
    state[1] += 1.0
    return max(numbers[0] * state[0], -numbers[1] * state[0], 0.0)


@inlined
def advance(kind: int, numbers: Array, state: Array, x: float) -> float:
    """The statistic after the finite sample x; `state` is changed."""
    x = min(max(x, -LARGEST), LARGEST)
    if kind == CUSUM:
        return _cusum(numbers, state, x)
    if kind == CUSUM_SQUARE:
        return _cusum(numbers, state, x * x)
    if kind == EWMA:
        return _ewma(numbers, state, x)
    if kind == GLR:
        return _glr(numbers, state, x)
    if kind == LOCAL_CUSUM:
        return _local_cusum(numbers, state, x)
    return _integrator(numbers, state, x)
