"""Figures 4.22 to 4.32 and the table of variance changes: theta and threshold for a change of the variance.

Right: statistic on n^2 = y^2 / S0, theta = sigma*^2 / S0. The thesis' (2.19) gives sigma*^4 / S0. Printed thetas are
larger than that by 0.07 %: E(y^2) was that of a sample. As the equations stand, theta is compared with n^2, whose mean
after the change is S1 / S0; where theta is above it nothing is found but by chance. Compared with y^2 it always lies
between S0 and S1, and the figures, where changes are found, agree with that reading. Both are given. "ARL" in the
thesis is neither run length: 0.5 and 1 are below the least possible one, 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from math import exp, log, log1p, sqrt

from scipy.optimize import brentq

from estimators.detectors import (
    CusumVariance,
    Design,
    design_cusum_variance,
    gaussian,
    run_lengths,
    thesis_theta,
    variance_drift,
)
from estimators.detectors.cusum import variance_run_length
from estimators.scores.interval import mean_interval
from testbed.study.detector_design.thesis import (
    CONFORMED,
    CONFORMED_ASKED,
    SIGMA_STEP,
    TABLE_ARLS,
    VARIANCE_ARLS,
    VARIANCE_CHANGES,
    VarianceChange,
)
from testbed.study.study import Row, StudyRow, Task, run_seed

PART = "variance"
PURPOSE = 2  # of the seeds
ALARMS, SMALL = 1000, 100  # of a repetition
RIGHT_ARL = 2e4  # samples, of the right designs beside the figures
REFERENCE = ("4.27", (200.0, 2e6))  # more of them, for the first figure
RESOLVED = 14.0  # of the exponent: beyond, run lengths are extrapolated
LONGEST = 1e6  # samples: beyond, no right design is set beside
SHARED_SIGMA = 15.67  # the thesis prints 15.7: all four thetas of its table follow with E(y^2) = 15.67^2


def growth(theta: float) -> float:
    """r > 0 with E exp(r (n^2 - theta)) = 1 for standard Gaussian n: run lengths grow as exp(r h)."""
    return float(brentq(lambda r: -0.5 * log1p(-2.0 * r) - r * theta, 0.5 * (1.0 - 1.0 / theta), 0.5 * (1.0 - 1e-15)))


@cache
def run_length(threshold: float, theta: float, variance: float = 1.0) -> float:
    """Samples to an alarm with n^2 of that mean: exact; beyond exp(RESOLVED) extrapolated by its growth, to 10 %."""
    h, drift = threshold / variance, theta / variance
    if drift > 1.0 and growth(drift) * h > RESOLVED:
        nearer = RESOLVED / growth(drift)
        return exp(min(growth(drift) * (h - nearer), 600.0)) * variance_run_length(nearer, drift, "increase")
    return variance_run_length(h, drift, "increase")


@cache
def right(before: float, after: float, arl0: float) -> Design:
    """The right design."""
    return design_cusum_variance(before, after, arl0)


def scales(change: VarianceChange) -> dict[str, float]:
    """By what the thesis' theta and h are divided to compare them with n^2, under each reading."""
    return {"on n^2": 1.0} if change.before == 1.0 else {"on n^2": 1.0, "on y^2": change.before}


def tasks(seed: int, number: int, small: bool) -> list[Task]:
    """One a repetition."""
    return [{"part": PART, "alarms": SMALL if small else ALARMS, "seed": run_seed(seed, number, PURPOSE)}]


def simulate(task: Task) -> Row:
    """By figure mean delays [samples] after a change at the reset: `right` theta at ARL0 RIGHT_ARL, and `thesis`,
    its first threshold on y^2 (None: below 0)."""
    row: Row = {"part": PART, "right": {}, "thesis": {}}
    for place, change in enumerate(VARIANCE_CHANGES):
        noise, s0 = gaussian(0.0, sqrt(change.after / change.before)), change.before
        designs = {"right": right(s0, change.after, RIGHT_ARL).detector}
        if (h := change.thresholds[0]) is not None:
            designs["thesis"] = CusumVariance(change.theta / s0, h / s0)
        for name, detector in designs.items():
            lengths = run_lengths(detector, noise, task["alarms"], seed=task["seed"] + place)
            row[name][change.figure] = float(lengths.mean())
    return row


def table(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """Per figure theta, what the printed thresholds do, and the right design; then the thesis' table."""
    own = [row for row in rows if row["part"] == PART]
    for change in VARIANCE_CHANGES:
        yield from _figure(change, own)
    yield from _residual_table()


def _figure(change: VarianceChange, own: Sequence[Row]) -> Iterator[StudyRow]:
    s0, s1, figure = change.before, change.after, change.figure
    yield StudyRow(f"{figure} theta", "-", change.theta, thesis_theta(s0, s1), limit=variance_drift(s0, s1))
    for arl, h in zip(VARIANCE_ARLS, change.thresholds, strict=True):
        if h is None:
            yield StudyRow(f"{figure} h < 0, ARL {arl:g}: ARL0", "samples", arl, 1.0)
            continue
        for reading, scale in scales(change).items():
            name, theta, level = f"{figure} h {h:g} {reading}", change.theta / scale, h / scale
            arl0 = run_length(level, theta)
            yield StudyRow(f"{name}: ARL0", "samples", arl, arl0)
            least = right(s0, s1, arl0).delay.mean if arl0 <= LONGEST else None
            yield StudyRow(f"{name}: delay", "samples", None, run_length(level, theta, s1 / s0), limit=least)
    for arl0 in (RIGHT_ARL, *(REFERENCE[1] if figure == REFERENCE[0] else ())):
        design = right(s0, s1, arl0)
        name = f"{figure} right theta, ARL0 {arl0:g}"
        yield StudyRow(f"{name}: h", "-", here=design.detector.level)
        yield StudyRow(f"{name}: delay", "samples", here=design.delay.mean)
    for name, what, limit in (
        ("right", f"right theta, ARL0 {RIGHT_ARL:g}", right(s0, s1, RIGHT_ARL).delay.mean),
        ("thesis", "thesis' theta, first h on y^2", _delay_on_square(change)),
    ):
        if seen := [row[name][figure] for row in own if figure in row[name]]:
            yield StudyRow.of(f"{figure} {what}: delay, simulated", "samples", mean_interval(seen), limit=limit)


def _delay_on_square(change: VarianceChange) -> float | None:
    h = change.thresholds[0]
    return (
        None if h is None else run_length(h / change.before, change.theta / change.before, change.after / change.before)
    )


def _residual_table() -> Iterator[StudyRow]:
    """Its sigma_1 is sigma_0 + 0.01. `least delay`: Lorden's bound ln(1/FAR) / information, what no detector beats."""
    for case in CONFORMED:
        s0, s1 = case.sigma**2, (case.sigma + SIGMA_STEP) ** 2
        theta = (variance_drift(s0, s1) * s0) ** 2 / SHARED_SIGMA**2
        yield StudyRow(
            f"variance table {case.figure}: theta", "-", case.theta_of_variance, theta, limit=variance_drift(s0, s1)
        )
        information = 0.5 * (s1 / s0 - 1.0 - log(s1 / s0))
        yield StudyRow(f"variance table {case.figure}: least delay", "samples", here=log(CONFORMED_ASKED) / information)
    for h, arl in TABLE_ARLS:
        here = variance_run_length(h, CONFORMED[0].theta_of_variance, "increase")
        yield StudyRow(f"variance table 4.14 h {h:g}: ARL0", "samples", arl, here)
