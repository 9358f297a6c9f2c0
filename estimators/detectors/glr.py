"""Generalised likelihood ratio for a shift of unknown size in the last N samples. Basseville & Nikiforov 1993, 2.4.3.

g = max over n = 1 .. N of (sum of the last n x)^2 / (2 n), the log-likelihood ratio maximised over the size of the
shift (its sign too, if one-sided only sums of that sign count) and over its start within the window; alarm if g > h.
Windowed: a shift that needs more than N samples to be seen is not looked for, and after a reset the window fills up
first. Cost: N additions a sample.

Run length: by simulation, without a shift and above `DIRECT` windows by importance sampling (`glr_run_length`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import recursions
from estimators.detectors.detector import Detector, RunLength, check_count, numbers_of
from estimators.detectors.glr_run_length import glr_run_length
from estimators.detectors.simulate import simulated_run_length

LONGEST_WINDOW = 500  # samples
DIRECT = 10.0  # windows: shorter run lengths are simulated directly
ALARMS = 10000


@dataclass(frozen=True)
class Glr(Detector):
    """window N [samples], threshold h [-] >= 0 (a log-likelihood ratio), sides: upper, lower or both."""

    window: int
    threshold: float
    sides: str = "both"
    kind: ClassVar[int] = recursions.GLR

    def _check(self) -> None:
        check_count("window", self.window, 1, LONGEST_WINDOW)

    @property
    def state_size(self) -> int:
        """The window as a ring, how full it is, the place of the next sample."""
        return 2 + self.window

    def numbers(self) -> NDArray[np.float64]:
        """The sides, the window."""
        return numbers_of(self.sides, self.window)

    def average_run_length(self, mean: float = 0.0, std: float = 1.0) -> RunLength:
        """By simulation, with its interval."""
        if mean == 0.0 and self.threshold > 0.0:
            rare = glr_run_length(self.threshold / std**2, self.window, self.sides == "both")
            if rare.mean > DIRECT * self.window:
                return rare
        return simulated_run_length(self, mean, std, ALARMS)
