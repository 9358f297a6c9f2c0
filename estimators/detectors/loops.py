"""Compiled loops of a detector over samples: for a monitor, and for measuring run lengths.

`follow` keeps the books of a monitor sample by sample, `intervals` counts the samples from alarm to alarm with a fresh
start after each. A sample that is NaN or infinite changes nothing but its count.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.detectors.recursions import advance

LATCH, CLEAR, RESTART = range(3)
USED, REFUSED, ALARMS, ALARM_ON = range(4)  # places in a monitor's counts

Array = NDArray[np.float64]


@compiled
def follow(
    kind: int,
    numbers: Array,
    level: float,
    after_alarm: int,
    state: Array,
    last: Array,
    counts: NDArray[np.int64],
    x: Array,
    statistic: Array,
    alarm: NDArray[np.bool_],
) -> None:
    """Statistic and alarm after each sample of x, shape (n,). Changes state, last (the statistic as it is) and
    counts.
    """
    for i in range(len(x)):
        if not np.isfinite(x[i]):
            counts[REFUSED] += 1
            statistic[i] = last[0]
            alarm[i] = counts[ALARM_ON] > 0
            continue
        counts[USED] += 1
        last[0] = statistic[i] = advance(kind, numbers, state, x[i])
        over = last[0] > level
        if over and counts[ALARM_ON] == 0:
            counts[ALARMS] += 1
        alarm[i] = over or (after_alarm == LATCH and counts[ALARM_ON] > 0)
        counts[ALARM_ON] = alarm[i]
        if over and after_alarm == RESTART:
            state[:] = 0.0
            last[0] = 0.0
            counts[ALARM_ON] = 0


@compiled
def intervals(
    kind: int, numbers: Array, level: float, state: Array, waited: int, x: Array, lengths: NDArray[np.int64]
) -> tuple[int, int]:
    """Samples from alarm to alarm in x, into `lengths`; how many alarms, and the samples waited since the last.

    waited: samples before x since the last alarm. Stops early when `lengths` is full.
    """
    alarms = 0
    for i in range(len(x)):
        if not np.isfinite(x[i]):
            continue
        waited += 1
        if advance(kind, numbers, state, x[i]) > level:
            lengths[alarms] = waited
            alarms += 1
            waited = 0
            state[:] = 0.0
            if alarms == len(lengths):
                break
    return alarms, waited
