"""Thresholds of the statistics [nats] at one false alarm in 100 h, and how they were found.

The statistics are likelihood ratios of a model, so their own scale promises a rate that roads need not keep. They are
therefore set by `estimators.detectors.empirical_threshold` on sound driving of tuning cars (seeds 1 and 2 of
`testbed.study.itpms_fusion`; the study reports another seed): the largest statistic of each SPAN is a residual, an
alarm a residual above the threshold, and the tail is extrapolated to the designed rate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from estimators.detectors import EmpiricalThreshold, Integrator, empirical_threshold
from estimators.itpms.voting import Thresholds

FALSE_ALARMS_PER_HOUR = 0.01
SPAN = 10.0  # s


@dataclass(frozen=True)
class Tuned:
    """The thresholds of the three sources and h_0 of the voting scheme [nats]."""

    alone: Mapping[str, float]
    agreed: float

    @property
    def voting(self) -> Thresholds:
        return Thresholds(self.agreed, self.alone["vibration"], self.alone["radius"])


TUNED = Tuned({"vibration": 16.0, "radius": 16.0, "fused": 14.0}, 8.0)


def threshold_of(largest: ArrayLike) -> EmpiricalThreshold:
    """The threshold of a statistic from its largest values in each SPAN of sound driving, shape (n,), below 0 as 0."""
    residuals = np.maximum(np.asarray(largest, dtype=np.float64), 0.0)
    return empirical_threshold(residuals, lambda h: Integrator(1, h, "upper"), 3600.0 / (SPAN * FALSE_ALARMS_PER_HOUR))
