"""A CUSUM that knows the leak rate, on the same whitened innovations at the same false-alarm rate: the bound.

It has the whole false-alarm rate of the wheel for itself (the monitor shares it among its shifts), and the drift that
is the quickest for this very leak: for each drift of a fine grid the exact threshold, and of all the least mean delay.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.detectors import CusumMean, design_cusum_mean
from estimators.direct_pressure.numbers import BETWEEN_FALSE_ALARMS, CLIP
from estimators.drive_log import WHEELS

SHIFTS = tuple(float(s) for s in np.geomspace(0.03, 4.0, 24))  # std
Array = NDArray[np.float64]


@cache
def levels(interval: float) -> Array:
    """Threshold [std] of each shift when samples come every `interval` [s]."""
    length = len(WHEELS) * BETWEEN_FALSE_ALARMS / interval
    designs = (design_cusum_mean(shift, length, "lower").detector for shift in SHIFTS)
    return np.array([d.threshold for d in designs if isinstance(d, CusumMean)])


@compiled
def first_alarms(x, shifts, thresholds, onset):
    """Samples from `onset` (a number) to the first alarm there or after it, by shift; -1 where there is none. x: shape
    (n,). An alarm before the onset starts the CUSUM anew."""
    found = np.full(len(shifts), -1)
    for j in range(len(shifts)):
        g = 0.0
        for i in range(len(x)):
            g = max(g - min(max(x[i], -CLIP), CLIP) - 0.5 * shifts[j], 0.0)
            if g > thresholds[j]:
                if i >= onset:
                    found[j] = i - onset
                    break
                g = 0.0
    return found
