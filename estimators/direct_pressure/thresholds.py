"""Thresholds of the bank of CUSUMs, exact, for a mean time between false alarms that is the same at any sampling rate.

Four wheels with a CUSUM each for every one of M shifts: each gets 4 M times the run length that is asked for, so that
together they alarm falsely at most as often (less, as they see the same residuals). Run lengths are computed
(`estimators.detectors`) at `LENGTHS` and interpolated in their logarithm, in which thresholds are almost linear.
"""

from __future__ import annotations

from functools import cache
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


@cache
def table() -> NDArray[np.float64]:
    """Threshold [std] of each shift (rows) at each of `LENGTHS` (columns); read-only."""
    levels = np.empty((len(SHIFTS), len(LENGTHS)))
    for row, shift in zip(levels, SHIFTS, strict=True):
        for j, length in enumerate(LENGTHS):
            detector = design_cusum_mean(shift, length, "lower").detector
            assert isinstance(detector, CusumMean)
            row[j] = detector.threshold
    levels.flags.writeable = False
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
