"""The threshold of the alarm, and how it comes from a stated false-alarm rate.

`designed` plays the significances of sound drives through the detector at many thresholds and takes the one with
FALSE_PER_HOUR, extrapolating the tail. Tuned on simulated drives of cars that the reported study does not use.
"""

from __future__ import annotations

from dataclasses import replace

from numpy.typing import ArrayLike

from estimators.detectors import EmpiricalThreshold, Ewma, empirical_threshold, samples_between

FALSE_PER_HOUR = 0.01
RATE = 1.0  # [Hz] of significances
FORGETTING = 0.8
THRESHOLD = 3.5


def alarm_detector() -> Ewma:
    """The detector of the alarm."""
    return Ewma(FORGETTING, THRESHOLD, "upper")


def designed(significance: ArrayLike) -> EmpiricalThreshold:
    """The threshold that sound tyres' significances, one a second, shape (n,), call for."""
    return empirical_threshold(
        significance, lambda h: replace(alarm_detector(), threshold=h), samples_between(FALSE_PER_HOUR, RATE)
    )
