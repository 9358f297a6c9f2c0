"""The thesis' threshold and integrators: AC, ACF and ACS (4.2.1), with a stated false-alarm rate.

S = sum of the residuals since it was last zeroed, zeroed every N samples; alarm if S > h (upper), -S > h (lower) or
|S| > h (both, as in the thesis). N = 1 is AC, "adyn compare", a plain threshold on |x|; a short period ACF (fast), a
long one ACS (slow). The thesis gives neither periods nor thresholds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import recursions
from estimators.detectors.detector import Detector, RunLength, check_count, numbers_of
from estimators.detectors.integrator_run_length import LONGEST_PERIOD, integrator_run_length


@dataclass(frozen=True)
class Integrator(Detector):
    """period N [samples], threshold h [std] >= 0, sides: upper, lower or both."""

    period: int
    threshold: float
    sides: str = "both"
    kind: ClassVar[int] = recursions.INTEGRATOR

    def _check(self) -> None:
        check_count("period", self.period, 1, LONGEST_PERIOD)

    def numbers(self) -> NDArray[np.float64]:
        """The sides, the period."""
        return numbers_of(self.sides, self.period)

    def average_run_length(self, mean: float = 0.0, std: float = 1.0) -> RunLength:
        """Exact."""
        towards = -mean if self.sides == "lower" else mean
        return RunLength.exact(integrator_run_length(self.threshold, self.period, self.sides == "both", towards, std))
