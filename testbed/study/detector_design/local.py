"""Local detectors side by side: CUSUM, GMA, local CUSUM, local GMA, local + global CUSUM, single- and double-sided.

The thesis finds local + global best, recommends its single-sided form, and would have liked to see a local GMA. Two
comparisons, each at one false-alarm rate for all:
    Gaussian   unit residuals, limit 2, designed for a shift of 1; local GMA's threshold from a record
    bursts     the simulated residuals of `residuals`, limit 50, constant errors in their unit; all from a record
In bursts trials start at any time and last TRIAL samples; a trial without an alarm counts as such.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf

import numpy as np

from estimators.detectors import (
    CusumMean,
    Detector,
    Ewma,
    LocalCusum,
    Monitor,
    count_alarms,
    design_cusum_mean,
    design_ewma,
    design_local_cusum,
    empirical_threshold,
    gaussian,
)
from estimators.detectors.simulate import Noise
from estimators.scores.interval import Interval, quantile_interval
from testbed.study.detector_design.rates import clustered_rate, inverse, pooled_rate
from testbed.study.detector_design.residuals import HOLD, residuals, seen_locally
from testbed.study.study import Row, StudyRow, Task, run_seed

PART = "local"
PURPOSE = 4  # of the seeds
ARL0, SMALL_ARL0 = 1e4, 100.0  # samples
RECORD, SMALL_RECORD = 1 << 20, 1 << 15  # samples
SHIFTS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)  # std
LIMIT = 2.0  # std
FORGETTING = 0.95  # both GMAs, near the best for a shift of 1
DELAYS, SMALL_DELAYS = 1 << 18, 1 << 14  # samples shown for each shift
ERRORS = (20.0, 50.0, 100.0, 200.0, 1000.0)  # of the thesis' tests
NARROW, NARROW_DRIFT, WIDE_DRIFT = 50.0, 20.0, 200.0  # limit and drifts in bursts: 4.18's and Table 5.1's
TRIAL, TRIALS, SMALL_TRIALS = 2000, 60, 4  # samples; trials of each error in a repetition
GAUSSIAN = ("CUSUM", "GMA", "local CUSUM", "local GMA", "local + global CUSUM", "double local + global CUSUM")
BURSTS = (*GAUSSIAN[:1], "CUSUM, wide drift", *GAUSSIAN[1:])


def tasks(seed: int, number: int, small: bool) -> list[Task]:
    """One a repetition."""
    return [{"part": PART, "small": small, "seed": run_seed(seed, number, PURPOSE)}]


def simulate(task: Task) -> Row:
    """`gaussian`: detector -> false alarms in `record` samples, and alarms in `shown` samples under each shift;
    `bursts`: detector -> false alarms, and times of first alarms [samples, None: none] under each error."""
    small = task["small"]
    generator = np.random.Generator(np.random.SFC64(task["seed"]))
    record, arl0 = (SMALL_RECORD, SMALL_ARL0) if small else (RECORD, ARL0)
    shown = SMALL_DELAYS if small else DELAYS
    in_gaussian = {}
    for name, (detector, local) in _gaussian_detectors(arl0, record, generator).items():
        shifted = [_shown(gaussian(shift), local) for shift in SHIFTS]
        in_gaussian[name] = {
            "false": count_alarms(detector, _shown(gaussian(), local)(generator, record)),
            "found": [count_alarms(detector, noise(generator, shown)) for noise in shifted],
        }
    bursts = {}
    for name, (detector, local) in _burst_detectors(arl0, record, generator).items():
        noise = _shown(residuals(HOLD), local)
        trials = SMALL_TRIALS if small else TRIALS
        bursts[name] = {
            "false": count_alarms(detector, noise(generator, record)),
            "first": [[_first(detector, error, local, generator) for _ in range(trials)] for error in ERRORS],
        }
    return {"part": PART, "arl0": arl0, "record": record, "shown": shown, "gaussian": in_gaussian, "bursts": bursts}


Shown = dict[str, tuple[Detector, float]]
"""Detector, and the limit beyond which its residuals are zeroed before it sees them (inf: none)."""


def _shown(noise: Noise, limit: float) -> Noise:
    return noise if limit == inf else seen_locally(noise, limit)


def _gaussian_detectors(arl0: float, record: int, generator: np.random.Generator) -> Shown:
    filtered = seen_locally(gaussian(), LIMIT)(generator, record)
    local_gma = empirical_threshold(filtered, lambda h: Ewma(FORGETTING, h), arl0).threshold
    return {
        "CUSUM": (design_cusum_mean(1.0, arl0).detector, inf),
        "GMA": (design_ewma(1.0, arl0, forgetting=FORGETTING).detector, inf),
        "local CUSUM": (design_local_cusum(1.0, arl0, (LIMIT,)).detector, inf),
        "local GMA": (Ewma(FORGETTING, local_gma), LIMIT),
        "local + global CUSUM": (design_local_cusum(1.0, arl0, (LIMIT, inf)).detector, inf),
        "double local + global CUSUM": (design_local_cusum(1.0, arl0, (LIMIT, inf), "both").detector, inf),
    }


def _burst_detectors(arl0: float, record: int, generator: np.random.Generator) -> Shown:
    """Local + global: each channel alone alarms once in 2 arl0, so both together about once in arl0 or less often."""
    r = residuals(HOLD)(generator, record)
    near = np.where(np.abs(r) > NARROW, 0.0, r)

    def cusum(x: np.ndarray, drift: float, length: float, sides: str = "upper") -> float:
        return empirical_threshold(x, lambda h: CusumMean(drift, h, sides), length).threshold

    def both(sides: str) -> LocalCusum:
        thresholds = cusum(near, NARROW_DRIFT, 2.0 * arl0, sides), cusum(r, WIDE_DRIFT, 2.0 * arl0, sides)
        return LocalCusum((NARROW, inf), (NARROW_DRIFT, WIDE_DRIFT), thresholds, sides)

    def gma(x: np.ndarray) -> Ewma:
        return Ewma(FORGETTING, empirical_threshold(x, lambda h: Ewma(FORGETTING, h), arl0).threshold)

    return {
        "CUSUM": (CusumMean(NARROW_DRIFT, cusum(r, NARROW_DRIFT, arl0)), inf),
        "CUSUM, wide drift": (CusumMean(WIDE_DRIFT, cusum(r, WIDE_DRIFT, arl0)), inf),
        "GMA": (gma(r), inf),
        "local CUSUM": (LocalCusum((NARROW,), (NARROW_DRIFT,), (cusum(near, NARROW_DRIFT, arl0),)), inf),
        "local GMA": (gma(near), NARROW),
        "local + global CUSUM": (both("upper"), inf),
        "double local + global CUSUM": (both("both"), inf),
    }


def _first(detector: Detector, error: float, local: float, generator: np.random.Generator) -> int | None:
    """Samples to the first alarm of a trial."""
    x = residuals(HOLD)(generator, TRIAL) + error
    alarm = Monitor(detector, "latch").run(np.where(np.abs(x) > local, 0.0, x)).alarm
    return int(alarm.argmax()) + 1 if alarm[-1] else None


def table(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """False-alarm rates reached, and delays: the mean in Gaussian residuals, the median in bursts."""
    own = [row for row in rows if row["part"] == PART]
    if not own:
        return
    record = [row["record"] for row in own]
    for where, names, rate_of in (("gaussian", GAUSSIAN, pooled_rate), ("bursts", BURSTS, clustered_rate)):
        for name in names:
            rate = rate_of([row[where][name]["false"] for row in own], record)
            yield StudyRow.of(f"{where}, {name}: ARL0", "samples", inverse(rate), limit=own[0]["arl0"])
    for name in GAUSSIAN:
        for place, shift in enumerate(SHIFTS):
            yield StudyRow.of(f"gaussian, {name}: delay, shift {shift:g}", "samples", delay(own, name, place))
    for name in BURSTS:
        for place, error in enumerate(ERRORS):
            yield StudyRow.of(
                f"bursts, {name}: median delay, error {error:g}", "samples", median_delay(own, name, place)
            )


def delay(own: Sequence[Row], name: str, place: int) -> Interval:
    """Mean samples to an alarm under a shift in Gaussian residuals."""
    found = [row["gaussian"][name]["found"][place] for row in own]
    return inverse(pooled_rate(found, [row["shown"] for row in own]))


def median_delay(own: Sequence[Row], name: str, place: int) -> Interval:
    """Of all trials, infinite where half of them had no alarm."""
    first = [inf if t is None else float(t) for row in own for t in row["bursts"][name]["first"][place]]
    found = np.minimum(first, 10.0 * TRIAL)  # a finite place beyond all trials, for the ranks
    median = quantile_interval(found, 0.5)
    return median.mapped(lambda t: inf if t > TRIAL else t)
