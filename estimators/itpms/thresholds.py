"""Thresholds of the statistics [nats] at one false alarm in 100 h, and how they were found.

The statistics are likelihood ratios of a model, so their own scale promises a rate that roads need not keep. They are
therefore set by `estimators.detectors.empirical_threshold` on sound driving of tuning cars (cars of seeds 1 and 2 of
`testbed.study.itpms_fusion`, 8.8 h; the study reports another seed): the largest statistic of each SPAN is a residual,
an alarm a residual above the threshold, and the tail is extrapolated to the designed rate: vibration 15.0, radius 18.6,
fused 12.2. For the fused one 14.0 is taken, above that, above the upper 95 % limit of the peaks over threshold
(`estimators.scores.tail`: 9.6, 8.6 to 12.6) and above the largest ever seen there, 12.7.

h_0 of the voting scheme: two independent likelihood ratios multiply, so c_1 + c_2 stands for the fused statistic, and
h_0 is half of its threshold. Flags agree too seldom on sound cars for a rate of its own (largest mean seen: 6.2).
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


TUNED = Tuned({"vibration": 15.0, "radius": 18.6, "fused": 14.0}, 7.0)


def threshold_of(largest: ArrayLike) -> EmpiricalThreshold:
    """The threshold of a statistic from its largest values in each SPAN of sound driving, shape (n,), below 0 as 0."""
    residuals = np.maximum(np.asarray(largest, dtype=np.float64), 0.0)
    return empirical_threshold(residuals, lambda h: Integrator(1, h, "upper"), 3600.0 / (SPAN * FALSE_ALARMS_PER_HOUR))
