"""Figures 4.1 to 4.12: drift and threshold for a change of the mean, as the thesis finds them and exactly.

The thesis takes the threshold from Siegmund's formula and nu from the least delay that it gives. Its twelve thresholds
follow from that formula with sigma = the number that the figures call sigma^2. So where that is 5, each has two rates:
with standard deviation 5, for which it was computed, and with variance 5, as printed. A threshold below 0 alarms at
every sample, since g >= 0.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from math import sqrt

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import norm

from estimators.detectors import CusumMean, count_alarms, design_cusum_mean, siegmund_run_length, siegmund_threshold
from estimators.scores.interval import Interval
from testbed.study.detector_design.rates import PER_HOUR, pooled_rate
from testbed.study.detector_design.thesis import (
    CHANGE_AT,
    FALSE_ALARMS_4_7,
    MEAN_CURVES,
    RATE,
    THETAS,
    THRESHOLDS,
    Threshold,
)
from testbed.study.study import Row, StudyRow, Task, run_seed

PART = "thresholds"
PURPOSE = 1  # of the seeds
SAMPLES, SMALL = 1 << 26, 1 << 18  # of a repetition
SHARE, RARE = 16, (1e4, 1e8)  # only run lengths between are shown them all, others one in SHARE
BLOCK = 1 << 18  # samples; a block starts from g = 0
FIGURE_DRIFT = 5.0  # nu of Figures 4.4 and 4.5
FLAT = 1e-3  # of a delay: by less, one nu is not better than another


def readings(threshold: Threshold) -> dict[str, float]:
    """Standard deviation of the input by how sigma^2 = 1 or 5 is read."""
    if threshold.variance == 1.0:
        return {"": 1.0}
    return {" (std 5)": threshold.variance, " (variance 5)": sqrt(threshold.variance)}


CASES = [(threshold, reading, std) for threshold in THRESHOLDS for reading, std in readings(threshold).items()]


def tasks(seed: int, number: int, small: bool) -> list[Task]:
    """One a repetition."""
    return [{"part": PART, "samples": SMALL if small else SAMPLES, "seed": run_seed(seed, number, PURPOSE)}]


def simulate(task: Task) -> Row:
    """For each of `CASES` the `samples` it was shown, of the same noise, and false `alarms` in them."""
    generator = np.random.Generator(np.random.SFC64(task["seed"]))
    detectors = [CusumMean(t.drift / std, max(t.printed, 0.0) / std) for t, _, std in CASES]
    rare = [RARE[0] < exact_run_length(threshold, std) < RARE[1] for threshold, _, std in CASES]
    alarms, samples = [0] * len(CASES), [0] * len(CASES)
    for number in range(task["samples"] // BLOCK):
        noise = generator.standard_normal(BLOCK)
        for place, (threshold, _, _) in enumerate(CASES):
            if rare[place] or number % SHARE == 0:
                samples[place] += BLOCK
                alarms[place] += BLOCK if threshold.printed < 0.0 else count_alarms(detectors[place], noise)
    return {"part": PART, "samples": samples, "alarms": alarms}


def alarm_rate(rows: Sequence[Row], place: int) -> Interval:
    """False alarms per sample of a case. ValueError without such rows."""
    own = [row for row in rows if row["part"] == PART]
    return pooled_rate([row["alarms"][place] for row in own], [row["samples"][place] for row in own])


def exact_run_length(threshold: Threshold, std: float) -> float:
    """ARL0 of a printed threshold [samples]."""
    if threshold.printed < 0.0:
        return 1.0
    return CusumMean(threshold.drift / std, threshold.printed / std).average_run_length().mean


def exact_threshold(drift: float, asked: float, std: float) -> float:
    """The right one, at least 0."""
    return std * design_cusum_mean(2.0 * drift / std, asked).detector.level


@cache
def exact_delay(drift: float, theta: float, std: float, asked: float) -> float:
    """MTD(nu) [samples] with the exact threshold of that nu."""
    detector = design_cusum_mean(2.0 * drift / std, asked).detector
    return detector.average_run_length(theta / std).mean


def siegmund_delay(drift: float, theta: float, std: float, asked: float) -> float:
    """MTD(nu) [samples] as the thesis plots it: (2.17) with (2.16)."""
    return siegmund_run_length(siegmund_threshold(drift, asked, std), drift, theta, std)


def best_drift(theta: float, std: float, asked: float) -> float | None:
    """nu of least exact delay; None where delays are all but the same from 0.4 to 0.6 theta."""
    found = minimize_scalar(
        lambda nu: exact_delay(nu, theta, std, asked), bounds=(0.1 * theta, 0.9 * theta), method="bounded",
        options={"xatol": 1e-3 * theta},
    )  # fmt: skip
    around = max(exact_delay(share * theta, theta, std, asked) for share in (0.4, 0.6))
    return float(found.x) if around > (1.0 + FLAT) * found.fun else None


def table(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """Figures 4.1 to 4.6, then the twelve thresholds."""
    yield from _curves()
    own = [row for row in rows if row["part"] == PART]
    for place, (threshold, reading, std) in enumerate(CASES):
        if std == threshold.variance:
            yield StudyRow(
                f"{threshold.name}: threshold", "-", threshold.printed,
                siegmund_threshold(threshold.drift, threshold.asked, std),
                limit=exact_threshold(threshold.drift, threshold.asked, std),
            )  # fmt: skip
        name = f"{threshold.name}{reading}"
        yield StudyRow(f"{name}: ARL0, exact", "samples", here=exact_run_length(threshold, std), limit=threshold.asked)
        if own:
            rate = alarm_rate(own, place)
            yield StudyRow.of(
                f"{name}: false alarms, simulated", "1/h", rate, limit=PER_HOUR / threshold.asked, scale=PER_HOUR
            )
    if own:
        yield _false_alarms_of_4_7(own)


def _false_alarms_of_4_7(own: Sequence[Row]) -> StudyRow:
    rate = alarm_rate(own, 0)
    until = CHANGE_AT * RATE
    return StudyRow.of(
        f"{THRESHOLDS[0].name}: false alarms in {CHANGE_AT:g} s", "-", rate, float(FALSE_ALARMS_4_7),
        until / THRESHOLDS[0].asked, until,
    )  # fmt: skip


def _curves() -> Iterator[StudyRow]:
    for figure, std, asked in MEAN_CURVES:
        for theta in THETAS:
            name = f"{figure} theta {theta:g}"
            yield StudyRow(f"{name}: nu of least MTD", "-", 0.5 * theta, best_drift(theta, std, asked))
            yield StudyRow(
                f"{name}: MTD at theta/2", "samples", siegmund_delay(0.5 * theta, theta, std, asked),
                exact_delay(0.5 * theta, theta, std, asked),
            )  # fmt: skip
    for asked in (200.0, 2e6):
        yield StudyRow(
            f"4.4 1/FAR {asked:g}: sigma up to which h = 0 will do", "-",
            siegmund_needs_none(asked), FIGURE_DRIFT / float(norm.isf(1.0 / asked)),
        )  # fmt: skip
    for std in (5.0, 3.0, 1.0):
        yield StudyRow(
            f"4.5 sigma {std:g}: 1/FAR up to which h = 0 will do", "samples",
            siegmund_run_length(0.0, FIGURE_DRIFT, 0.0, std), 1.0 / float(norm.sf(FIGURE_DRIFT / std)),
        )  # fmt: skip


def siegmund_needs_none(asked: float) -> float:
    """sigma of Figure 4.4 where Siegmund's threshold crosses 0."""
    return float(brentq(lambda std: siegmund_threshold(FIGURE_DRIFT, asked, std), 0.5, 5.0))
