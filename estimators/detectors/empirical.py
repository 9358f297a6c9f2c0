"""The threshold from residuals themselves, where they are not Gaussian: an empirical quantile of the run length.

A record of residuals without a change is played through the detector, which restarts after each alarm, at many
thresholds; the alarms per sample are the false-alarm rate that the threshold really has, with whatever tails and
correlation the record has.
- If arl0 calls for at least `ENOUGH` alarms in the record, the threshold that gives them is read off.
- Else the tail is extrapolated: the logarithm of the rate is taken as linear in h from `MANY` to `ENOUGH` alarms, as it
  is for CUSUM, GLR (exactly in the limit) and, conservatively for Gaussian ones, others. The interval says how well
  that is known, not whether the tail stays as it is. The interval of the rate is Poisson's (for the number of alarms,
  if they come independently).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import chi2

from estimators.detectors.detector import Detector, RunLength
from estimators.detectors.loops import intervals

ENOUGH = 20
MANY = 400
LEAST = 1e-9  # threshold: some kinds have none at 0
FARTHEST = 1000.0  # times the record's own reach, beyond which no tail is trusted


@dataclass(frozen=True)
class EmpiricalThreshold:
    """threshold, the run length that the record gives it (with interval and method), and the alarms in the record."""

    threshold: float
    arl0: RunLength
    alarms: int


def count_alarms(detector: Detector, x: ArrayLike) -> int:
    """False alarms in residuals x, shape (n,), when the detector restarts after each."""
    samples = np.ascontiguousarray(x, dtype=np.float64)
    lengths = np.empty(len(samples) + 1, dtype=np.int64)
    state = np.zeros(detector.state_size)
    return int(intervals(detector.kind, detector.numbers(), detector.level, state, 0, samples, lengths)[0])


def poisson_interval(count: int) -> tuple[float, float]:
    """95 % interval of the expected number when `count` were seen."""
    low = chi2.ppf(0.025, 2 * count) / 2.0 if count else 0.0
    return float(low), float(chi2.ppf(0.975, 2 * count + 2) / 2.0)


def empirical_threshold(x: ArrayLike, detector_at: Callable[[float], Detector], arl0: float) -> EmpiricalThreshold:
    """The threshold whose false alarms in x, shape (n,), are one in arl0 samples.

    detector_at: the detector with a threshold. ValueError if the record is too short even to extrapolate.
    """
    samples = np.ascontiguousarray(x, dtype=np.float64)
    samples = samples[np.isfinite(samples)]
    n, reach = len(samples), len(samples) / ENOUGH
    if not (np.isfinite(arl0) and 1.0 <= arl0 <= FARTHEST * reach and n >= 5 * MANY):
        feasible = f"1 to {FARTHEST * reach:.3g}" if n >= 5 * MANY else f"none, give at least {5 * MANY} residuals"
        raise ValueError(f"arl0 is {arl0:g} samples for a record of {n} residuals, feasible: {feasible}")
    if arl0 <= reach:
        h = _threshold_with(samples, detector_at, n / arl0)
        alarms = count_alarms(detector_at(h), samples)
        low, high = poisson_interval(alarms)
        return EmpiricalThreshold(
            h, RunLength(n / max(alarms, 0.5), n / high, n / low if low else np.inf, "record"), alarms
        )
    return _extrapolated(samples, detector_at, arl0)


def _threshold_with(x: NDArray[np.float64], detector_at: Callable[[float], Detector], alarms: float) -> float:
    """The least threshold with at most so many alarms, `LEAST` if that has fewer already."""
    low, high = 0.0, 1.0
    while count_alarms(detector_at(high), x) > alarms:
        low, high = high, 2.0 * high
    while high - low > 1e-6 * high and high > LEAST:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if count_alarms(detector_at(middle), x) > alarms else (low, middle)
    return high


def _extrapolated(x: NDArray[np.float64], detector_at: Callable[[float], Detector], arl0: float) -> EmpiricalThreshold:
    at_many, at_enough = (_threshold_with(x, detector_at, count) for count in (MANY, ENOUGH))
    if at_enough <= at_many:
        raise ValueError(f"arl0 is {arl0:g} samples, feasible with this record: at most {len(x) / ENOUGH:.3g}")
    many, enough = (count_alarms(detector_at(h), x) for h in (at_many, at_enough))
    slope = np.log(many / enough) / (at_enough - at_many)
    ahead = np.log(arl0 * enough / len(x)) / slope
    # ln(rate) at the new threshold = ln(enough) - slope * ahead; the two counts as independent Poisson numbers
    leverage = ahead / (at_enough - at_many)
    spread = 1.96 * float(np.hypot((1.0 + leverage) / enough**0.5, leverage / many**0.5))
    h = float(at_enough + ahead)
    arl = RunLength(arl0, arl0 * np.exp(-spread), arl0 * np.exp(spread), "record, extrapolated")
    return EmpiricalThreshold(h, arl, count_alarms(detector_at(h), x))
