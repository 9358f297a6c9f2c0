"""Study `steering-actuator`: how small an error of the active front steering's motor is found, and how soon?

The ten driven scenarios of set A and the fifty of set B (`scenarios`), the thesis' monitors tuned by its rule and the
identified servo's innovation, `servo_model`, on the same cells (`trials`). Rows: METHOD.smallest_constant_error_deg:
found in all ten scenarios of every repetition (interval: least and most of a repetition), there from the beginning as
in the thesis, thresholds after set B so that nothing there is a false alarm, those of `servo_model` at the designed
rate; ..._from_5s_deg: there from then on, in the midst of steering; ..._at_designed_rate_deg: thresholds at one false
alarm in 100 h of set B for every method; ..._after_the_thesis_sets_deg: after set A where the thesis has it so.
METHOD.false_alarms and so on: drives of set B with an alarm though nothing is wrong. estimator.false_alarms: of
`steering_actuator` with its pinion. ERROR.METHOD.found and .median_s: tables of 4.2.2 (thesis' sets), scenarios of ten
in which an error is found, and after what time there; the ten times themselves are in the figures. Then `gaussian`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from estimators.detectors import poisson_interval
from estimators.steering_actuator.errors import THESIS
from estimators.steering_actuator.steering_actuator import FALSE_ALARMS_PER_HOUR
from testbed.study.steering_actuator import gaussian, work
from testbed.study.steering_actuator.paper import SCENARIOS, smallest_constant, tables
from testbed.study.steering_actuator.scenarios import CASES, SET_A
from testbed.study.steering_actuator.trials import NAMES, SERVO_MODEL
from testbed.study.study import Row, Study, StudyRow, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SMALL = (0, 6, 12, 30)  # places of scenarios
BAR = 20.0  # deg
# rows by kind of thresholds, see `trials.KINDS`
SIZES_BY = (
    ("on_b", "deg"), ("late", "from_5s_deg"), ("rated", "at_designed_rate_deg"), ("tuned", "after_the_thesis_sets_deg"),
)  # fmt: skip
FALSE_BY = (("on_b", ""), ("rated", "_at_designed_rate"), ("tuned", "_after_the_thesis_sets"))
OF_SERVO_MODEL = ("on_b", "late")  # its thresholds are at the designed rate in any case


class SteeringActuatorStudy(Study):
    name = "steering-actuator"
    about = "How small an error of an active front steering's motor is found, and how soon, without false alarms?"
    paper = "Razavi, Lund 2006 (seed 004), chapters 3 to 5: tables of 4.1.2 and 4.2.2, Figures 4.13 to 4.21."
    runs = 20

    @property
    def work(self) -> Callable[[Task], Row]:
        return work.run

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        places = list(SMALL) if small else list(range(len(CASES)))
        return [{"seed": seed, "number": number, "places": places} for number in range(runs)]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        found = [json.loads(row["found"]) for row in rows]
        cases = [case for row in found for case in row["cases"] if not case["ended"]]
        pooled = [row["gaussian"] for row in found if row["gaussian"]]
        return [*_smallest(found), *_false(cases), *_tables(cases), *(gaussian.rows(pooled) if pooled else ())]

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.steering_actuator.figures import figures  # matplotlib, only where something is drawn

        return figures([json.loads(row["found"]) for row in rows])


def smallest(row: Mapping[str, Any], method: str, kind: str) -> float:
    """Of a repetition: the least constant [deg] that is found in all its scenarios of set A; inf if none, NaN without
    all of them."""
    own = [case["sizes"][method][kind] for case in row["cases"] if case["set_a"] and not case["ended"]]
    if len(own) < len(SET_A):
        return float("nan")
    common = set(own[0]).intersection(*own[1:])
    return min(common, default=float("inf"))


def _smallest(found: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    for kind, suffix in SIZES_BY:
        for method in NAMES:
            if method == SERVO_MODEL and kind not in OF_SERVO_MODEL:
                continue
            each = [smallest(row, method, kind) for row in found]
            each = [size for size in each if not np.isnan(size)]
            if each:
                limit = BAR if method == SERVO_MODEL else None
                paper = smallest_constant(method) if kind == "tuned" else None
                worst = max(each)
                yield StudyRow(
                    f"{method}.smallest_constant_error_{suffix}", "deg", paper, worst, (min(each), worst), limit
                )


def _false(cases: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    hours = sum(case["hours"] for case in cases)
    designed = FALSE_ALARMS_PER_HOUR * hours
    yield StudyRow("hours", "h", here=hours)
    for kind, suffix in FALSE_BY:
        for method in NAMES:
            if method == SERVO_MODEL and kind not in OF_SERVO_MODEL:
                continue
            count = sum(case["sound"][method][kind] for case in cases)
            limit = designed if kind == "rated" or method == SERVO_MODEL else None
            yield StudyRow(f"{method}.false_alarms{suffix}", "-", None, float(count), poisson_interval(count), limit)
    count = sum(len(case["alarms"]) for case in cases)
    yield StudyRow("estimator.false_alarms", "-", None, float(count), poisson_interval(count), designed)
    largest = max(case["evidence"] for case in cases)
    yield StudyRow(f"{SERVO_MODEL}.largest_evidence_over_threshold", "-", None, largest, limit=1.0)


def times(cases: Sequence[Mapping[str, Any]], error: str, method: str, name: str | None = None) -> list[float | None]:
    """Seconds to the alarm of the drives of set A, or of one scenario."""
    return [
        case["table"][error][method][0] for case in cases if case["set_a"] and (name is None or case["name"] == name)
    ]


def _tables(cases: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    for error in THESIS:
        printed = tables()[error.name]
        for method in NAMES:
            told = times(cases, error.name, method)
            if not told:
                continue
            seen = [t for t in told if t is not None]
            own = [entry.time for entry in printed.get(method, ())]
            own_seen = [t for t in own if t is not None]
            yield StudyRow(
                f"{error.name}.{method}.found", f"of {SCENARIOS}", float(len(own_seen)) if own else None,
                SCENARIOS * len(seen) / len(told),
            )  # fmt: skip
            if seen or own_seen:
                yield StudyRow(
                    f"{error.name}.{method}.median_s", "s", float(np.median(own_seen)) if own_seen else None,
                    float(np.median(seen)) if seen else None, (min(seen), max(seen)) if seen else None,
                )  # fmt: skip
