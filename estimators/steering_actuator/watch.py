"""One series of errors, watched at a stated false-alarm rate: what is known of it beforehand.

    z_t = error_t / s_t (`spread`)        e_t = (z_t - m - sum a_i z_{t-i}) / s_e     white (`detectors.whitening`)

which makes the innovation of an output-error model with autoregressive noise. A lasting error of TARGET moves e by
d_t = (TARGET / s_t - sum a_i TARGET / s_{t-i}) / s_e. With e within +-LARGEST, so that a wild sample is one sample, and
w_t = d_t within +-HEAVIEST, what is summed is the log-likelihood ratio for a shift by w_t:

    up, down   +-w_t e_t - w_t^2 / 2        variance   e_t^2 - theta, for VARIANCE_AFTER times the variance

Tails are not Gaussian, so thresholds come from the tail of the statistics on sound drives (`exponential_tail`), an
equal share of the rate for mean and variance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import CusumMean, CusumVariance, Detector, Monitor, Whitener, fit_whitener
from estimators.detectors import variance_drift as likelihood_drift
from estimators.steering_actuator.exponential_tail import threshold_at
from estimators.steering_actuator.residuals import STEP
from estimators.steering_actuator.spread import Spread, fitted_spread

ORDER = 6  # of the autoregression
LARGEST, HEAVIEST = 6.0, 4.0  # of e, of w
VARIANCE_AFTER = 20.0
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

    def increments(self, z: Array, s: Array) -> tuple[Array, Array]:
        """(3, n) for `detectors`, and w e, w d, w^2, (3, n), of z and s, (n,) each, that begin ORDER cells earlier; NaN
        where missing."""
        white = self.whitener.whiten(z)
        e = np.clip(white, -LARGEST, LARGEST)
        d = replace(self.whitener, mean=0.0).whiten(self.target / s)
        w = np.clip(d, -HEAVIEST, HEAVIEST)
        moved, half = w * e, 0.5 * w * w
        return np.stack([moved - half, -moved - half, e]), np.stack([w * white, w * d, w * w])

    def as_json(self) -> dict[str, Any]:
        """JSON values."""
        return {
            "floor": self.spread.floor, "per_cause": list(self.spread.per_cause),
            "autoregression": list(self.whitener.coefficients),
            "mean": self.whitener.mean, "std": self.whitener.std, "target": self.target,
            "mean_threshold": self.mean_threshold, "variance_threshold": self.variance_threshold,
        }  # fmt: skip

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> Watch:
        """ValueError in one line if it is malformed."""
        try:
            floor, mean, std, target, *thresholds = (float(document[name]) for name in _NUMBERS)
            coefficients = tuple(float(a) for a in document["autoregression"])
            found = cls(
                Spread(floor, tuple(float(c) for c in document["per_cause"])),
                Whitener(coefficients, mean, std),
                target,
                *thresholds,
            )
            found.detectors()
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"watch of the steering actuator: {type(error).__name__} {error}") from None
        if not (np.isfinite([*coefficients, mean, std, target]).all() and min(std, target) > 0.0):
            raise ValueError(f"watch of the steering actuator: std {std:g}, target {target:g}, valid: above 0")
        return found


_NUMBERS = ("floor", "mean", "std", "target", "mean_threshold", "variance_threshold")  # fmt: skip


def statistics(watch: Watch, error: Array, causes: Array) -> Array:
    """Of a sound drive from its beginning: UP, DOWN, VARIANCE after each cell, (3, n), which no alarm starts anew."""
    s = watch.spread.at(causes)
    rows = watch.increments(error / s, s)[0]
    return np.stack([Monitor(d).run(row).statistic for d, row in zip(watch.detectors(), rows, strict=True)])


def fitted(errors: Sequence[Array], causes: Sequence[Array], target: float, rate: float) -> Watch:
    """From sound drives: errors (n,), their causes (n, m), NaN where missing. target: halved until the tail of its sum
    can be told (of one far above the errors nothing is ever seen). rate: false alarms an hour, of all its detectors
    together. ValueError where there is no tail."""
    spread = fitted_spread(errors, causes)
    gap = np.full(ORDER, np.nan)
    series = [np.concatenate([e / spread.at(u), gap]) for e, u in zip(errors, causes, strict=True)]
    whitener = fit_whitener(np.concatenate(series), ORDER)
    hours = sum(len(e) for e in errors) * STEP / 3600.0
    complaint = ""
    for halvings in range(HALVINGS):
        watch = Watch(spread, whitener, target * 0.5**halvings, 0.0, 0.0)
        drives = [statistics(watch, *drive) for drive in zip(errors, causes, strict=True)]
        try:
            mean = threshold_at([float(said[:VARIANCE].max()) for said in drives], hours, 0.5 * rate)
        except ValueError as error:
            complaint = str(error)
            continue
        variance = threshold_at([float(said[VARIANCE].max()) for said in drives], hours, 0.5 * rate)
        return replace(watch, mean_threshold=mean, variance_threshold=variance)
    raise ValueError(complaint)
