"""Thresholds of the bank of CUSUMs, exact, for a mean time between false alarms that is the same at any sampling rate.

Four wheels with a CUSUM each for every one of M shifts: each gets 4 M times the run length that is asked for, so that
together they alarm falsely at most as often (less, as they see the same residuals). Run lengths are computed
(`estimators.detectors`) at `LENGTHS` and interpolated in their logarithm, in which thresholds are almost linear. The
table stands here, since the design takes seconds; a test designs it anew.
"""

from __future__ import annotations

from math import log

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined
from estimators.detectors import CusumMean, design_cusum_mean
from estimators.direct_pressure.numbers import BETWEEN_FALSE_ALARMS, SHIFTS
from estimators.drive_log import WHEELS

LENGTHS = (1e3, 1e4, 1e6, 1e8, 1e10)  # samples
LOGARITHMS = tuple(log(length) for length in LENGTHS)
CUSUMS = len(WHEELS) * len(SHIFTS)


# threshold [std] of each shift (rows) at each of LENGTHS (columns), as `designed` gives it
LEVELS = (
    (24.981540958, 59.755817884, 166.189445146, 281.083205192, 396.208689804),
    (21.211257007, 43.835474984, 99.756560556, 157.286337698, 214.850418396),
    (16.397562013, 29.441684062, 57.94759472, 86.724872616, 115.507114013),
    (11.42756582, 18.374237477, 32.722157201, 47.112601216, 61.503750756),
    (7.201092836, 10.757673274, 17.946777777, 25.142254149, 32.337833598),
    (4.094328309, 5.886774445, 9.483621631, 13.081398471, 16.679186137),
    (2.051241217, 2.939534201, 4.739197694, 6.537838554, 8.336746868),
)


def table() -> NDArray[np.float64]:
    """`LEVELS` as an array."""
    return np.array(LEVELS)


def designed() -> NDArray[np.float64]:
    """Threshold [std] of each shift (rows) at each of `LENGTHS` (columns), designed anew."""
    levels = np.empty((len(SHIFTS), len(LENGTHS)))
    for row, shift in zip(levels, SHIFTS, strict=True):
        for j, length in enumerate(LENGTHS):
            detector = design_cusum_mean(shift, length, "lower").detector
            assert isinstance(detector, CusumMean)
            row[j] = detector.threshold
    return levels


@inlined
def place(interval):
    """Where among `LENGTHS` the run length lies when samples come every `interval` [s]: a column, and the share to the
    next one."""
    wanted = np.log(BETWEEN_FALSE_ALARMS * CUSUMS / interval)
    j = 0
    while j < len(LENGTHS) - 2 and wanted > LOGARITHMS[j + 1]:
        j += 1
    return j, max((wanted - LOGARITHMS[j]) / (LOGARITHMS[j + 1] - LOGARITHMS[j]), 0.0)
