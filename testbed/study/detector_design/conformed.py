"""Figures 4.13 to 4.21: residuals cut until they look Gaussian, and the thresholds designed for them as if they were.

On simulated residuals (`residuals`), independent and in bursts; the thesis' own data are not available. What is
removed is no sample, as in the thesis' histograms. Beside the designs the threshold that a record of such residuals
gives for RECORD_ARL, and the rate that it then has in another record.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.stats import kurtosis, norm

from estimators.detectors import CusumMean, count_alarms, empirical_threshold, siegmund_threshold
from estimators.detectors.simulate import Noise
from estimators.scores.interval import mean_interval
from testbed.study.detector_design.rates import PER_HOUR, clustered_rate
from testbed.study.detector_design.residuals import HOLD, Array, conform, residuals
from testbed.study.detector_design.thesis import CONFORMED, CONFORMED_ASKED, Conformed
from testbed.study.detector_design.thresholds import exact_threshold
from testbed.study.study import Row, StudyRow, Task, run_seed

PART = "conformed"
PURPOSE = 3  # of the seeds
SAMPLES, SMALL = 1 << 20, 1 << 15  # before the removal; of a repetition, and as many for the record
RECORD_ARL, SMALL_ARL = 1e4, 1e3  # samples
HOLDS = {"independent": 1, "in bursts": HOLD}


def tasks(seed: int, number: int, small: bool) -> list[Task]:
    """One a repetition."""
    return [{
        "part": PART, "samples": SMALL if small else SAMPLES, "record_arl0": SMALL_ARL if small else RECORD_ARL,
        "seed": run_seed(seed, number, PURPOSE),
    }]  # fmt: skip


def simulate(task: Task) -> Row:
    """By figure and kind of residuals, see `_measure`."""
    found = {
        f"{case.figure} {kind}": _measure(case, residuals(hold), task["samples"], task["record_arl0"], task["seed"])
        for case in CONFORMED
        for kind, hold in HOLDS.items()
    }
    return {"part": PART, "record_arl0": task["record_arl0"], "found": found}


def _measure(case: Conformed, noise: Noise, samples: int, record_arl0: float, seed: int) -> dict[str, float]:
    """Of two records: spread, distance from a Gaussian, kurtosis, false alarms of the printed design; the threshold of
    the first, `limit`, and its false alarms in the second, `alarms_of_limit`."""
    generator = np.random.Generator(np.random.SFC64(seed))
    first, second = (conform(noise(generator, samples), case.cut, case.zeros) for _ in range(2))
    limit = empirical_threshold(first, lambda h: CusumMean(case.drift, h), record_arl0).threshold
    return {
        "sigma": float(first.std()),
        "distance": gaussian_distance(first),
        "kurtosis": float(kurtosis(first)),
        "samples": len(first),
        "alarms": count_alarms(CusumMean(case.drift, case.threshold), first),
        "limit": limit,
        "samples_of_limit": len(second),
        "alarms_of_limit": count_alarms(CusumMean(case.drift, limit), second),
    }


def gaussian_distance(r: Array) -> float:
    """Kolmogorov's: the largest difference of the distributions of r and of a Gaussian with its mean and std."""
    values, counts = np.unique(r, return_counts=True)  # zeros are many
    upper = np.cumsum(counts) / len(r)
    ideal = norm.cdf((values - r.mean()) / r.std())
    return float(max(np.abs(upper - ideal).max(), np.abs(upper - counts / len(r) - ideal).max()))


def table(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """By figure: how Gaussian, the design as printed, and that of the record."""
    own = [row for row in rows if row["part"] == PART]
    for case in CONFORMED:
        yield StudyRow(
            f"{case.tested} threshold", "-", case.threshold,
            siegmund_threshold(case.drift, CONFORMED_ASKED, case.sigma),
            limit=exact_threshold(case.drift, CONFORMED_ASKED, case.sigma),
        )  # fmt: skip
        yield StudyRow(
            f"{case.tested} ARL0 if Gaussian", "samples", CONFORMED_ASKED, _if_gaussian(case), limit=CONFORMED_ASKED
        )
        if own:
            yield from _of_residuals(case, own)


def _if_gaussian(case: Conformed) -> float:
    return CusumMean(case.drift / case.sigma, case.threshold / case.sigma).average_run_length().mean


def _of_residuals(case: Conformed, own: Sequence[Row]) -> Iterator[StudyRow]:
    found = {kind: [row["found"][f"{case.figure} {kind}"] for row in own] for kind in HOLDS}
    whole = found["independent"]
    yield StudyRow.of(f"{case.figure} sigma", "-", mean_interval([one["sigma"] for one in whole]), case.sigma)
    yield StudyRow.of(
        f"{case.figure} distance from a Gaussian", "-", mean_interval([one["distance"] for one in whole]), limit=0.0
    )
    yield StudyRow.of(
        f"{case.figure} excess kurtosis", "-", mean_interval([one["kurtosis"] for one in whole]), limit=0.0
    )
    asked = own[0]["record_arl0"]
    for kind, those in found.items():
        rate = clustered_rate([one["alarms"] for one in those], [one["samples"] for one in those])
        yield StudyRow.of(
            f"{case.tested} false alarms, {kind}", "1/h", rate, limit=PER_HOUR / CONFORMED_ASKED, scale=PER_HOUR
        )
        limit = mean_interval([one["limit"] for one in those])
        yield StudyRow.of(f"{case.tested} threshold of a record, {kind}", "-", limit)
        rate = clustered_rate([one["alarms_of_limit"] for one in those], [one["samples_of_limit"] for one in those])
        yield StudyRow.of(
            f"{case.tested} false alarms with it, {kind}", "1/h", rate, limit=PER_HOUR / asked, scale=PER_HOUR
        )
