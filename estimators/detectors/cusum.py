"""CUSUM for a change of the mean (one- or two-sided) and of the variance. Thesis 2.13, 2.18, 2.26.

Mean: g+ = max(g+ + x - k, 0), g- = max(g- - x - k, 0), alarm if max(g+, g-) > h. k = half the shift to find is the
log-likelihood ratio's own drift, and the quickest for that shift. The thesis' abs() of the residual (2.25) is left out:
it makes the noise itself a drift of 0.8.

Variance: g = max(g + x^2 - theta, 0) for an increase S0 -> S1, max(g - x^2 + theta, 0) for a decrease, with x = y /
sqrt(S0) and theta = sigma*^2 / S0 where sigma*^2 = ln(S1 / S0) / (1 / S0 - 1 / S1), the zero of the log-likelihood
ratio. The thesis' (2.19) squares sigma*^2 a second time; `thesis_theta` gives its numbers for comparison.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import recursions
from estimators.detectors.cusum_run_length import AGREE, gaussian_run_length, run_length
from estimators.detectors.detector import Detector, RunLength, both_sides, check_number, numbers_of
from estimators.detectors.increments import NegativeSquared, Squared

CHANGES = {"increase": "upper", "decrease": "lower"}


@dataclass(frozen=True)
class CusumMean(Detector):
    """drift k [std] >= 0, threshold h [std] >= 0, sides: upper, lower or both."""

    drift: float
    threshold: float
    sides: str = "upper"
    kind: ClassVar[int] = recursions.CUSUM

    def _check(self) -> None:
        check_number("drift", self.drift, 0.0)

    def numbers(self) -> NDArray[np.float64]:
        """The sides, the drift up and down."""
        return numbers_of(self.sides, self.drift, self.drift)

    def average_run_length(self, mean: float = 0.0, std: float = 1.0) -> RunLength:
        """Exact."""
        lengths = {
            side: gaussian_run_length(self.threshold, self.drift, mean if side == "upper" else -mean, std)
            for side in ("upper", "lower")
            if self.sides in (side, "both")
        }
        return RunLength.exact(both_sides(**lengths) if self.sides == "both" else lengths[self.sides])


@dataclass(frozen=True)
class CusumVariance(Detector):
    """drift theta [S0] > 0, threshold h [S0] >= 0, change: increase or decrease."""

    drift: float
    threshold: float
    change: str = "increase"
    kind: ClassVar[int] = recursions.CUSUM_SQUARE

    def _check(self) -> None:
        check_number("drift", self.drift, 0.0, above=True)
        if self.change not in CHANGES:
            raise ValueError(f"change is {self.change!r}, valid: {', '.join(CHANGES)}")

    @property
    def sides(self) -> str:  # type: ignore[override]
        """Upper for an increase."""
        return CHANGES[self.change]

    def numbers(self) -> NDArray[np.float64]:
        """The direction, the drift up and down."""
        return numbers_of(self.sides, self.drift, -self.drift)

    def average_run_length(self, mean: float = 0.0, std: float = 1.0) -> RunLength:
        """Exact. std: sqrt(S1 / S0) after the change."""
        return RunLength.exact(variance_run_length(self.threshold, self.drift, self.change, mean, std))


def variance_run_length(
    threshold: float, drift: float, change: str, mean: float = 0.0, std: float = 1.0, agree: float = AGREE
) -> float:
    """Exact run length of a CUSUM for variance, to a relative accuracy of about `agree`."""
    if change == "increase":
        return run_length(threshold, drift, Squared(mean, std), agree)
    return run_length(threshold, -drift, NegativeSquared(mean, std), agree)


def variance_drift(before: float, after: float) -> float:
    """theta = sigma*^2 / S0 for the variances before S0 and after S1. ValueError if they are equal or not above 0."""
    check_number("variance before", before, 0.0, above=True)
    check_number("variance after", after, 0.0, above=True)
    if before == after:
        raise ValueError(f"variance after is {after:g}, valid: any above 0 but that before")
    return log(after / before) / (1.0 - before / after)


def thesis_theta(before: float, after: float) -> float:
    """What (2.19) gives as it is used in the thesis: sigma*^4 / S0."""
    return variance_drift(before, after) ** 2 * before
