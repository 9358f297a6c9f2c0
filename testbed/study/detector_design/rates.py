"""False-alarm rates with intervals, where alarms come independently and where they come together."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from estimators.scores.interval import Interval, mean_interval, poisson_rate_interval
from testbed.study.detector_design.thesis import RATE

PER_HOUR = 3600.0 * RATE  # samples


def pooled_rate(counts: Sequence[int], samples: Sequence[int]) -> Interval:
    """Alarms per sample, Poisson: for independent residuals."""
    return poisson_rate_interval(sum(counts), sum(samples))


def clustered_rate(counts: Sequence[int], samples: Sequence[int]) -> Interval:
    """Alarms per sample from what repetitions differ by: for residuals in bursts, whose alarms come together.

    One repetition bounds nothing. Without any alarm, Poisson's upper limit.
    """
    if not sum(counts):
        return pooled_rate(counts, samples)
    rate = mean_interval([count / n for count, n in zip(counts, samples, strict=True)])
    return Interval(rate.value, max(rate.low, 0.0), rate.high)


def inverse(rate: Interval) -> Interval:
    """Samples between alarms."""
    return Interval(*(1.0 / x if x > 0.0 else inf for x in (rate.value, rate.high, rate.low)))
