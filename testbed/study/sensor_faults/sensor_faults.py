"""Study `sensor-faults`: can a car find and name its faulty accelerometer, gyro and wheel-speed sensors? Seed 003 and
what became of it in `estimators.redundancy`.

Ordinary driving with grade and bank (`drives`), faults that begin on it (`cases`), the seed's own method on the same
drives and on an even road (`paper`). Rows: false alarms of the whole estimator on sound drives, each alarm counted;
missed_rate: faults that no alarm tells within 3 s; delays as the driver sees them; isolation_rate: of the bar's faults
that are told, those told with the right sensor's name. The seed's `paper` figures are of its own simulation, without
roads."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from estimators.redundancy.numbers import HOURS, SOURCES
from estimators.redundancy.published import Parameters
from estimators.redundancy.tuning import ERROR, FALSE_ALARM, Candidate
from estimators.scores.detection import detection_times
from estimators.scores.interval import Interval, poisson_rate_interval, proportion_interval
from estimators.scores.survival import event_curve
from testbed.study.sensor_faults import paper, work
from testbed.study.sensor_faults.cases import BAR, OTHERS, WATCH
from testbed.study.sensor_faults.drives import DURATION, SMALL_DURATION, scenario
from testbed.study.sensor_faults.grade_limit import NOW, PAST, limit
from testbed.study.study import Row, Study, StudyRow, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WITHIN = 1.0  # s, the bar
SHARE = 0.95  # of the cases, the bar
# first criterion, its limit, second one; threshold, sigma, false alarms, missed, error of the seed's Tables 3 and 4
STRATEGIES = {
    "table_3": (FALSE_ALARM, 0.05, ERROR, (0.47, 0.06, 0.0496, 0.551, 0.0928)),
    "table_4": (ERROR, 0.05, FALSE_ALARM, (0.78, 0.02, 0.169, 0.5121, 0.0494)),
}


class SensorFaultsStudy(Study):
    name = "sensor-faults"
    about = "Are faulty accelerometers, gyros and wheel-speed sensors found and named within a second?"
    paper = "Seed 003: analytical redundancy with a nonlinear residual, Tables 1, 3, 4, Figures 6 to 15."
    runs = 60

    @property
    def work(self) -> Callable[[Task], Row]:
        return work.run

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        duration = SMALL_DURATION if small else DURATION
        return [
            {"number": number, "small": small, "scenario": scenario(seed, number, duration).as_notes()}
            for number in range(runs)
        ]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        return [*_false_alarms(rows), *_bar(rows), *_grade(rows), *_missed(rows), *_published(rows), *_paper(rows)]

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.sensor_faults.figures import figures  # matplotlib, only where something is drawn

        return figures(rows)


def trials(rows: Sequence[Row], name: str) -> list[dict[str, Any]]:
    """All trials of a case."""
    return [trial for row in rows for trial in row["trials"] if trial["case"] == name]


def share(found: Sequence[bool]) -> Interval | None:
    """With its interval; None of nothing."""
    return proportion_interval(sum(found), len(found)) if found else None


def _false_alarms(rows: Sequence[Row]) -> Iterator[StudyRow]:
    count, hours = sum(len(row["alarms"]) for row in rows), sum(row["hours"] for row in rows)
    rate = poisson_rate_interval(count, hours)
    yield StudyRow(
        "false_alarms", "-", here=float(count), ci95=(rate.low * hours, rate.high * hours), limit=hours / HOURS
    )
    yield StudyRow("hours", "h", here=hours)
    yield StudyRow("designed_false_alarms_per_100h", "1/100 h", here=100.0 / HOURS)
    yield StudyRow.of("false_alarms_per_100h", "1/100 h", rate, limit=100.0 / HOURS, scale=100.0)


def quantile(of: Sequence[Mapping[str, Any]], probability: float) -> Interval:
    """Delay [s] by which that share is told, infinite where it is not within the watched time."""
    given = [[trial["delay"]] if trial["delay"] is not None else [] for trial in of]
    events = detection_times(given, np.zeros(len(of)), np.full(len(of), float(WATCH)))
    return event_curve(events).quantile(probability)


def _bar(rows: Sequence[Row]) -> Iterator[StudyRow]:
    every = {case.name: trials(rows, case.name) for case in BAR}
    for name, found in every.items():
        in_time = [t["right"] and t["delay"] <= WITHIN for t in found]
        yield StudyRow.of(f"isolated_within_1s_{name}", "%", share(in_time), limit=100.0 * SHARE, scale=100.0)
        if found:
            yield StudyRow.of(f"detect_p50_s_{name}", "s", quantile(found, 0.5))
            yield StudyRow.of(f"detect_p95_s_{name}", "s", quantile(found, 0.95), limit=WITHIN)
    known = [quantile(found, 0.95) for found in every.values() if found]
    worst = max(known, key=lambda q: q.value, default=None)
    yield StudyRow.of("detect_p95_s", "s", worst, limit=WITHIN)
    told = [t["right"] for found in every.values() for t in found if t["delay"] is not None]
    yield StudyRow.of("isolation_rate", "%", share(told), scale=100.0)
    driving = [t["right"] and t["delay"] <= WITHIN for t in every[BAR[0].name] if t["driving"] > SHARE]
    yield StudyRow.of(f"isolated_within_1s_{BAR[0].name}_engine_drives", "%", share(driving), limit=95.0, scale=100.0)
    errors = [t["error"] for row in rows for t in row["trials"] if t["delay"] is None]
    yield StudyRow("max_undetected_error_mps2", "m/s^2", here=max(errors, default=0.0))


def _grade(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """What any detector could find of the accelerometer's bias within the second, and in what is left of it once late
    samples have been waited for."""
    by_class: dict[str, list[list[float]]] = {}
    for row in rows:
        by_class.setdefault(row["road"], []).extend(row.get("grade", ()))
    found = {road: np.array(w).reshape(-1, PAST + NOW) for road, w in by_class.items()}
    for name, cells in (("limit", NOW), ("limit_less_latency", NOW - 1)):
        share_found = limit(found, 0.3, HOURS * SOURCES, cells)
        here = None if share_found is None else 100.0 * share_found
        yield StudyRow(f"{name}_accelerometer_bias_0p3", "%", here=here)


def _missed(rows: Sequence[Row]) -> Iterator[StudyRow]:
    for case in (*BAR, *OTHERS):
        found = [t["delay"] is None for t in trials(rows, case.name)]
        yield StudyRow.of(f"missed_rate_{case.name}", "%", share(found), scale=100.0)


def _published(rows: Sequence[Row]) -> Iterator[StudyRow]:
    hours = sum(row["published"]["hours"] for row in rows)
    count = sum(row["published"]["episodes"] for row in rows)
    yield StudyRow.of("seed_method_false_alarms_per_h", "1/h", poisson_rate_interval(count, hours), limit=1.0 / HOURS)
    accused = sum(row["published"]["share"] * row["published"]["hours"] for row in rows) / hours
    yield StudyRow("seed_method_false_alarm_share", "%", 4.96, 100.0 * accused)


def _paper(rows: Sequence[Row]) -> Iterator[StudyRow]:
    first = next((row for row in rows if "table_1" in row), None)
    if first is None:
        return
    for fault, errors in first["table_1"].items():
        for method, (value, theirs) in enumerate(zip(errors, paper.TABLE_1[fault], strict=True), 1):
            yield StudyRow(f"table_1, {fault}, method {method}", "m^2/s^4", theirs, value)
    rated = [Candidate(Parameters(**c.pop("parameters")), **c) for c in map(dict, first["candidates"])]
    for name, (criterion, bound, second, printed) in STRATEGIES.items():
        best = paper.chosen(rated, criterion, second, bound)
        here: list[float | None] = [None] * 5
        if best:
            p = best.parameters
            here = [p.threshold, p.sigma, best.false_alarm, best.missed, best.error]
        names = ("threshold", "sigma", FALSE_ALARM, "missed", ERROR)
        for what, value, theirs in zip(names, here, printed, strict=True):
            yield StudyRow(f"{name}, {what}", "m/s^2" if what in ("sigma", ERROR) else "-", theirs, value)
