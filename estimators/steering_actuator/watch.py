"""One series of errors, watched at a stated false-alarm rate: what is known of it beforehand.

    z_t = error_t / s_t (`spread`)        e_t = (z_t - m - sum a_i z_{t-i}) / s_e     white (`detectors.whitening`)

which makes the innovation of an output-error model with autoregressive noise. A lasting error of TARGET moves e by
d_t = (TARGET / s_t - sum a_i TARGET / s_{t-i}) / s_e, so the log-likelihood ratio for it is a CUSUM of

    up, down   +-d_t e_t - d_t^2 / 2        variance   e_t^2 - theta, for VARIANCE_AFTER times the variance

Tails are not Gaussian, so thresholds come from the tail of the statistics on sound drives, an equal share of the rate
for mean and variance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import CusumMean, CusumVariance, Detector, Monitor, Whitener, fit_whitener
from estimators.detectors import variance_drift as likelihood_drift
from estimators.scores.tail import fit_tail
from estimators.steering_actuator.residuals import STEP
from estimators.steering_actuator.spread import Spread, fitted_spread

ORDER = 6  # of the autoregression
LARGEST = 8.0  # of e: one wild sample is none
VARIANCE_AFTER = 6.0
BLOCK = round(1.0 / STEP)  # cells of a block of the tail
HALVINGS = 8
UP, DOWN, VARIANCE = range(3)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Watch:
    """target [rad], thresholds of up and down [nat], of the variance [-]."""

    spread: Spread
    whitener: Whitener
    target: float
    mean_threshold: float
    variance_threshold: float

    def detectors(self) -> tuple[Detector, Detector, Detector]:
        """UP, DOWN, VARIANCE: each takes its row of `increments`."""
        mean = CusumMean(0.0, self.mean_threshold, "upper")
        return mean, mean, CusumVariance(likelihood_drift(1.0, VARIANCE_AFTER), self.variance_threshold)

    def increments(self, z: Array, s: Array) -> tuple[Array, Array, Array]:
        """(3, n) for `detectors`, d and e, (n,), of z and s, (n,) each, that begin ORDER cells earlier; NaN where
        missing."""
        e = np.clip(self.whitener.whiten(z), -LARGEST, LARGEST)
        d = replace(self.whitener, mean=0.0).whiten(self.target / s)
        moved, half = d * e, 0.5 * d * d
        return np.stack([moved - half, -moved - half, e]), d, e

    def as_json(self) -> dict[str, Any]:
        """JSON values."""
        return {
            "floor": self.spread.floor, "per_first": self.spread.per_first, "per_second": self.spread.per_second,
            "autoregression": list(self.whitener.coefficients),
            "mean": self.whitener.mean, "std": self.whitener.std, "target": self.target,
            "mean_threshold": self.mean_threshold, "variance_threshold": self.variance_threshold,
        }  # fmt: skip

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> Watch:
        """ValueError in one line if it is malformed."""
        try:
            floor, first, second, mean, std, target, *thresholds = (float(document[name]) for name in _NUMBERS)
            coefficients = tuple(float(a) for a in document["autoregression"])
            found = cls(Spread(floor, first, second), Whitener(coefficients, mean, std), target, *thresholds)
            found.detectors()
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"watch of the steering actuator: {type(error).__name__} {error}") from None
        if not (np.isfinite([*coefficients, mean, std, target]).all() and min(std, target) > 0.0):
            raise ValueError(f"watch of the steering actuator: std {std:g}, target {target:g}, valid: above 0")
        return found


_NUMBERS = (
    "floor", "per_first", "per_second", "mean", "std", "target", "mean_threshold", "variance_threshold",
)  # fmt: skip


def statistics(watch: Watch, error: Array, first: Array, second: Array) -> Array:
    """Of a sound drive from its beginning: UP, DOWN, VARIANCE after each cell, (3, n), which no alarm starts anew."""
    s = watch.spread.at(first, second)
    rows = watch.increments(error / s, s)[0]
    return np.stack([Monitor(d).run(row).statistic for d, row in zip(watch.detectors(), rows, strict=True)])


def fitted(
    errors: Sequence[Array], firsts: Sequence[Array], seconds: Sequence[Array], target: float, rate: float
) -> Watch:
    """From sound drives, (n,) each, NaN where missing. target: halved until the tail of its sum can be told (of one far
    above the errors nothing is ever seen). rate: false alarms an hour, of all its detectors together. ValueError where
    there is no tail."""
    spread = fitted_spread(errors, firsts, seconds)
    gap = np.full(ORDER, np.nan)
    series = [np.concatenate([e / spread.at(u, v), gap]) for e, u, v in zip(errors, firsts, seconds, strict=True)]
    whitener = fit_whitener(np.concatenate(series), ORDER)
    complaint = ""
    for halvings in range(HALVINGS):
        watch = Watch(spread, whitener, target * 0.5**halvings, 0.0, 0.0)
        drives = [statistics(watch, *drive) for drive in zip(errors, firsts, seconds, strict=True)]
        try:
            mean = threshold_at([block_maxima(said[:VARIANCE].max(axis=0)) for said in drives], 0.5 * rate)
        except ValueError as error:
            complaint = str(error)
            continue
        variance = threshold_at([block_maxima(said[VARIANCE]) for said in drives], 0.5 * rate)
        return replace(watch, mean_threshold=mean, variance_threshold=variance)
    raise ValueError(complaint)


def block_maxima(statistic: Array) -> Array:
    """Largest of each whole block, of (n,)."""
    blocks = len(statistic) // BLOCK
    return statistic[: blocks * BLOCK].reshape(blocks, BLOCK).max(axis=1)


def threshold_at(maxima_by_drive: Sequence[Array], rate: float) -> float:
    """Of block maxima: the upper end of the tail's 95 % interval at `rate` [1/h], and no less than was ever seen."""
    tail = fit_tail(maxima_by_drive, BLOCK * STEP / 3600.0)
    return max(tail.threshold_at(rate).high, max(float(m.max()) for m in maxima_by_drive if len(m)))
