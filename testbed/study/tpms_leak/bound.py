"""Detectors that know the leak rate, on the same whitened innovations at the same false-alarm rate: the bound.

Each has the whole false-alarm rate of the wheel for itself (the monitor shares it among its shifts).
    constant   CUSUMs with the drift that is the quickest for this very leak: a fine grid, each with its exact threshold
    matched    a leak is no step of the innovations but a ramp that the filter follows more and more: the likelihood
               ratio of this very rate with its signature (`onsets`), summed over every onset (Shiryaev-Roberts; a CUSUM
               takes the largest). That sum less the number of samples is a martingale, so its mean run length is at
               least its threshold. Onsets are those that the monitor keeps, each for the samples about it
The bound of a leak is the one of them with the least mean delay.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.detectors import CusumMean, design_cusum_mean
from estimators.direct_pressure import onsets
from estimators.direct_pressure.monitor import KNOWN, follow
from estimators.direct_pressure.noise import WARM
from estimators.direct_pressure.numbers import BETWEEN_FALSE_ALARMS, CLIP
from estimators.drive_log import WHEELS

SHIFTS = tuple(float(s) for s in np.geomspace(0.03, 4.0, 24))  # std
Array = NDArray[np.float64]


def length(interval: float) -> float:
    """Samples between false alarms of a wheel when they come every `interval` [s]."""
    return len(WHEELS) * BETWEEN_FALSE_ALARMS / interval


@cache
def levels(interval: float) -> Array:
    """Threshold [std] of each shift when samples come every `interval` [s]."""
    designs = (design_cusum_mean(shift, length(interval), "lower").detector for shift in SHIFTS)
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


@compiled
def first_matched(m, time, kind, value, said, rate, interval, threshold, onset):
    """Time from `onset` [s] to the alarm of the matched detector there or after it, infinite where there is none.

    m: a monitor's memory with infinite levels, so that it never alarms itself; events as `follow` takes them; rate:
    [Pa/s] at the reference temperature. An alarm before the onset starts it anew.
    """
    for i in range(len(time)):
        if follow(m, time[i : i + 1], kind[i : i + 1], value[i : i + 1], said) == 0 or m.noise[WARM] > 0.0:
            continue
        rows, known, total = m.onsets, int(m.status[KNOWN]), 0.0
        for k in range(known):
            about = 0.5 * (rows[min(k + 1, known - 1), onsets.AT] - rows[max(k - 1, 0), onsets.AT]) / interval
            total += about * np.exp(min(rate * (rows[k, onsets.A] - 0.5 * rate * rows[k, onsets.B]), 300.0))
        if total > threshold:
            if time[i] >= onset:
                return time[i] - onset
            m.status[KNOWN] = 0.0
    return np.inf
