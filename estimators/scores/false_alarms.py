"""How often does an alarm come without a fault? Count, hours, and the rate with Garwood's exact Poisson interval.

The interval is Poisson's, so alarms must be independent: alarms that follow each other closer than a gap are one
episode (runs declustering), and the rate is one of episodes. No alarm in T hours leaves an upper limit of 3.689 / T
(95 %, two-sided). To claim a designed rate of one in 10 000 h from 100 h of driving, extrapolate the statistic's tail:
see `tail`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from estimators.scores.interval import CONFIDENCE, Interval, poisson_rate_interval


@dataclass(frozen=True)
class FalseAlarms:
    """count: episodes. hours: driven without a fault [h]. rate: episodes an hour [1/h]."""

    count: int
    hours: float
    rate: Interval


def false_alarms(
    alarms: Sequence[ArrayLike], duration: ArrayLike, gap: float, confidence: float = CONFIDENCE
) -> FalseAlarms:
    """Rate of episodes over sound drives.

    alarms: alarm times [s] of each drive, possibly none. duration: sound time of each drive [s], shape (drives,), not
    negative and above 0 in sum. gap: alarms closer than this [s] to the one before are the same episode.
    """
    spans = np.asarray(duration, dtype=np.float64)
    if spans.shape != (len(alarms),) or len(alarms) == 0:
        raise ValueError(f"duration has shape {spans.shape} beside {len(alarms)} drives, valid: one [s] a drive")
    if not (np.isfinite(spans).all() and (spans >= 0.0).all()):
        raise ValueError(f"duration holds {spans[~(spans >= 0.0)][:1]}, valid: finite seconds from 0")
    count = sum(episodes(given, gap) for given in alarms)
    hours = float(spans.sum()) / 3600.0
    return FalseAlarms(count, hours, poisson_rate_interval(count, hours, confidence))


def episodes(alarms: ArrayLike, gap: float) -> int:
    """Number of episodes among alarm times [s], any order: runs whose neighbours are closer than `gap` [s]."""
    if not gap >= 0.0:
        raise ValueError(f"gap is {gap}, valid: a number of seconds from 0")
    times = np.sort(np.asarray(alarms, dtype=np.float64).reshape(-1))
    if not np.isfinite(times).all():
        raise ValueError(f"alarms hold {times[~np.isfinite(times)][0]}, valid: finite times [s]")
    return int(len(times) > 0) + int(np.sum(np.diff(times) >= gap))
