"""Figures 4.13 to 4.21 and the table of variance changes: position residuals of set A, cut until they look Gaussian.

As in the thesis residuals with |eps| > cut, and in 4.17 those that are 0, are removed; sigma is their standard
deviation; (nu, h) follow from Siegmund's formula for 1/FAR = 2e7 samples (2.15 to 2.17) with nu = theta / 2 of the
figure. Whether they hold: alarms, each starting the sum anew, on the residuals from which they come. Variance: theta of
the thesis' rule for a change of sigma by 0.01, and alarms with h = 4, its largest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import kurtosis

from estimators.detectors import (
    CusumMean,
    CusumVariance,
    count_alarms,
    poisson_interval,
    siegmund_threshold,
    thesis_theta,
)
from estimators.scores.interval import mean_interval
from testbed.study.detector_design.conformed import gaussian_distance
from testbed.study.detector_design.residuals import conform
from testbed.study.detector_design.thesis import CONFORMED, CONFORMED_ASKED, SIGMA_STEP
from testbed.study.study import StudyRow

EDGES = np.arange(-1500.5, 1501.5, 1.0)  # deg, of the histogram
VARIANCE_H = 4.0

Array = NDArray[np.float64]


def measured(residual: Array) -> dict[str, Any]:
    """Of set A of a repetition, (n,) [deg]: histogram, and by figure sigma, distance from a Gaussian, excess kurtosis,
    h, alarms of it and of the printed one, theta and alarms of the variance, samples."""
    whole = residual[np.isfinite(residual)]
    found: dict[str, Any] = {"histogram": np.histogram(whole, EDGES)[0].tolist(), "largest": float(np.abs(whole).max())}
    for case in CONFORMED:
        kept = conform(whole, case.cut, case.zeros)
        sigma = float(kept.std())
        h = siegmund_threshold(case.drift, CONFORMED_ASKED, sigma)
        theta = thesis_theta(sigma**2, (sigma + SIGMA_STEP) ** 2)
        found[case.figure] = {
            "sigma": sigma, "distance": gaussian_distance(kept), "kurtosis": float(kurtosis(kept)),
            "samples": len(kept), "h": h, "alarms": count_alarms(CusumMean(case.drift, max(h, 0.0), "both"), kept),
            "printed_alarms": count_alarms(CusumMean(case.drift, case.threshold, "both"), kept), "theta": theta,
            "variance_alarms": count_alarms(CusumVariance(theta, VARIANCE_H), kept),
        }  # fmt: skip
    return found


def rows(found: Sequence[dict[str, Any]]) -> Iterator[StudyRow]:
    """The table; found: `measured` of each repetition."""
    for case in CONFORMED:
        own = [one[case.figure] for one in found]
        samples = sum(one["samples"] for one in own)
        start, tested = f"figure_{case.figure}", f"figure_{case.tested}"

        def mean(key: str, of: Sequence[dict[str, Any]] = own) -> Any:
            return mean_interval([one[key] for one in of])

        yield StudyRow.of(f"{start}.sigma_deg", "deg", mean("sigma"), case.sigma)
        yield StudyRow.of(f"{start}.distance_from_a_gaussian", "-", mean("distance"), limit=0.0)
        yield StudyRow.of(f"{start}.excess_kurtosis", "-", mean("kurtosis"), limit=0.0)
        yield StudyRow.of(f"{tested}.threshold", "-", mean("h"), case.threshold)
        for key, name in (("alarms", "false_alarms"), ("printed_alarms", "false_alarms_of_the_printed_threshold")):
            count = sum(one[key] for one in own)
            yield StudyRow(
                f"{tested}.{name}", "-", None, float(count), poisson_interval(count), samples / CONFORMED_ASKED
            )
        yield StudyRow.of(f"variance_{case.figure}.theta", "-", mean("theta"), case.theta_of_variance)
        count = sum(one["variance_alarms"] for one in own)
        yield StudyRow(f"variance_{case.figure}.false_alarms", "-", None, float(count), poisson_interval(count))
