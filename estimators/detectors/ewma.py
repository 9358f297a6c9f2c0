"""GMA, the geometric (exponentially weighted) moving average of the residual. Thesis 2.29, 2.30; Roberts 1959.

g = phi g + (1 - phi) x from g = 0; alarm if g > h (upper), -g > h (lower), |g| > h (both). phi in [0, 1) is the
forgetting factor: 0 forgets at once, near 1 averages over about 1 / (1 - phi) samples. The thesis' alpha is 1 - phi in
its equation (2.29) and phi in its text and figures. The statistic of a one-sided GMA below zero is given as 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import recursions
from estimators.detectors.detector import Detector, RunLength, check_number, numbers_of
from estimators.detectors.ewma_run_length import ewma_run_length

LONGEST_MEMORY = 0.999  # of phi: the integral equation is resolved up to here


@dataclass(frozen=True)
class Ewma(Detector):
    """forgetting phi [-], threshold h [std] >= 0, sides: upper, lower or both."""

    forgetting: float
    threshold: float
    sides: str = "upper"
    kind: ClassVar[int] = recursions.EWMA

    def _check(self) -> None:
        check_number("forgetting", self.forgetting, 0.0, LONGEST_MEMORY)

    @property
    def state_size(self) -> int:
        """The average."""
        return 1

    def numbers(self) -> NDArray[np.float64]:
        """The sides, the forgetting factor."""
        return numbers_of(self.sides, self.forgetting)

    def average_run_length(self, mean: float = 0.0, std: float = 1.0) -> RunLength:
        """Exact."""
        towards = -mean if self.sides == "lower" else mean
        return RunLength.exact(ewma_run_length(self.threshold, self.forgetting, self.sides == "both", towards, std))
