"""Table 5.1: a CUSUM tuned by hand for an active scenario and one for a normal one.

Its definition: the largest and smallest residual, a drift, a threshold, and that there is no false alarm in scenarios
of unstated length. So from the table itself follow how many samples the largest residual takes to the threshold, and
that no constant error below the drift is found. The rest is on simulated residuals in bursts within the two ranges
(normal: calm ones only), and depends on how long those are taken to hold. abs: of |r|, as in (2.25), which the thesis'
single-sided tests use to see both signs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from estimators.detectors import CusumMean, count_alarms, empirical_threshold
from estimators.scores.interval import mean_interval
from testbed.study.detector_design.rates import PER_HOUR, clustered_rate, inverse
from testbed.study.detector_design.residuals import HOLD, residuals
from testbed.study.detector_design.thesis import TABLE_5_1
from testbed.study.study import Row, StudyRow, Task, run_seed

PART = "scenarios"
PURPOSE = 5  # of the seeds
SAMPLES, SMALL = 1 << 20, 1 << 15  # of a repetition
ARL0, SMALL_ARL0 = 1e4, 1e3  # samples, for the threshold of a record
SIDES = {"r": np.positive, "abs r": np.abs}
ERROR = 50.0  # constant, the smallest that the thesis' conclusion claims
STATES = {"scenario_01": 4, "scenario_02": 2}


def tasks(seed: int, number: int, small: bool) -> list[Task]:
    """One a repetition."""
    samples, arl0 = (SMALL, SMALL_ARL0) if small else (SAMPLES, ARL0)
    return [{"part": PART, "samples": samples, "arl0": arl0, "seed": run_seed(seed, number, PURPOSE)}]


def simulate(task: Task) -> Row:
    """By scenario and side: false alarms of the printed tuning, the threshold of the record, alarms under ERROR."""
    generator = np.random.Generator(np.random.SFC64(task["seed"]))
    found = {}
    for tuning in TABLE_5_1:
        noise = residuals(HOLD, tuning.low, tuning.high, STATES[tuning.name])
        r = noise(generator, task["samples"])
        detector = CusumMean(tuning.drift, tuning.threshold)
        for side, of in SIDES.items():
            found[f"{tuning.name}, {side}"] = {
                "alarms": count_alarms(detector, of(r)),
                "limit": empirical_threshold(of(r), partial(CusumMean, tuning.drift), task["arl0"]).threshold,
                "found": count_alarms(detector, of(r + ERROR)),
            }
    return {"part": PART, "samples": task["samples"], "arl0": task["arl0"], "found": found}


def table(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """What the table defines, then what simulated residuals say."""
    own = [row for row in rows if row["part"] == PART]
    samples = [row["samples"] for row in own]
    for tuning in TABLE_5_1:
        for side, largest in (("r", tuning.high), ("abs r", max(tuning.high, -tuning.low))):
            name = f"Table 5.1 {tuning.name}, {side}"
            yield StudyRow(
                f"{name}: samples of the largest residual to an alarm", "samples",
                here=tuning.threshold / (largest - tuning.drift),
            )  # fmt: skip
            if not own:
                continue
            those = [row["found"][f"{tuning.name}, {side}"] for row in own]
            rate = clustered_rate([one["alarms"] for one in those], samples)
            yield StudyRow.of(f"{name}: false alarms", "1/h", rate, paper=0.0, scale=PER_HOUR)
            limit = mean_interval([one["limit"] for one in those])
            yield StudyRow.of(f"{name}: threshold for ARL0 {own[0]['arl0']:g}", "-", limit, tuning.threshold)
            found = inverse(clustered_rate([one["found"] for one in those], samples))
            yield StudyRow.of(f"{name}: delay, error {ERROR:g}", "samples", found)
