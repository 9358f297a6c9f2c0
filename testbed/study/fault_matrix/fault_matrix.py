"""Study `fault-matrix`: each sensor of the car, each kind of fault, all monitors of the project together.

In a cell: of the trials in which the fault begins on an ordinary drive, how many nobody tells within the watched time
(`missed_rate`), how long it takes until somebody accuses that sensor (`detect_p50_s`, `detect_p95_s`; an alarm, or a
flag that names its signal), how many times the first accusation of all is that sensor's (`isolation_rate`, of those in
which any sensor is accused), and how often an alarm accuses something else: another sensor, or a sound tyre
(`false_accusation_rate`). Physical events that look like faults: rows `event.*`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from estimators.redundancy.numbers import HOURS
from estimators.scores.interval import Interval, poisson_rate_interval, proportion_interval
from testbed.study.fault_matrix import events, work
from testbed.study.fault_matrix.faults import Cell, cells
from testbed.study.fault_matrix.matrix import Entry, matrix
from testbed.study.sensor_faults.drives import scenario
from testbed.study.study import Row, Study, StudyRow, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DURATION, SMALL_DURATION = 64.0, 20.0  # s
OVERALL = ("missed_rate", "isolation_rate", "false_accusation_rate")


class FaultMatrixStudy(Study):
    name = "fault-matrix"
    about = "Each sensor, each kind of fault: who notices, how soon, and is the right sensor accused?"
    paper = "Own; the faults of seed 003 and those that cars have, all monitors of the project together."
    runs = 10

    @property
    def work(self) -> Callable[[Task], Row]:
        return work.run

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        found: list[Task] = []
        for number in range(runs):
            drive = replace(scenario(seed, number, SMALL_DURATION if small else DURATION), active_steering=True)
            found.append({"event": "", "small": small, "scenario": drive.as_notes()})
            found += [
                {"event": e.name, "small": small, "scenario": events.scenario(e, seed, number, small).as_notes()}
                for e in events.EVENTS[: 1 if small else None]
            ]
        return found

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        return [*_overall(rows), *_events(rows), *_cells(rows)]

    def printed(self, table: Sequence[StudyRow]) -> list[StudyRow]:
        return [row for row in table if "=" not in row.name]

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.fault_matrix.figures import figures  # matplotlib, only where something is drawn

        return figures(rows)

    def pages(self, rows: Sequence[Row]) -> Mapping[str, str]:
        from testbed.study.fault_matrix.page import page

        return {"report": page(self.about, rows, self.table(rows))}


def share(count: int, of: int) -> Interval | None:
    """With its interval; None of nothing."""
    return proportion_interval(count, of) if of else None


def _overall(rows: Sequence[Row]) -> Iterator[StudyRow]:
    drives = [row for row in rows if "trials" in row]
    hours, false = sum(row["hours"] for row in drives), sum(len(row["false"]) for row in drives)
    entries = matrix(rows)
    guarded = sum(entry.guarded for entry in entries.values())
    yield StudyRow("cells", "-", here=float(len(list(cells()))))
    yield StudyRow.of("guarded_cells", "%", share(guarded, len(entries)), scale=100.0)
    trials = sum(entry.trials for entry in entries.values())
    told = sum(entry.accused for entry in entries.values())
    counts = (
        (sum(e.missed for e in entries.values()), trials),
        (sum(e.isolated for e in entries.values()), told),
        (sum(e.falsely for e in entries.values()), trials),
    )
    for name, (count, of) in zip(OVERALL, counts, strict=True):
        yield StudyRow.of(name, "%", share(count, of), scale=100.0)
    rate = poisson_rate_interval(false, hours) if hours else None
    yield StudyRow("hours", "h", here=hours)
    yield StudyRow.of("false_alarms_per_100h", "1/100 h", rate, limit=100.0 / HOURS, scale=100.0)


def _events(rows: Sequence[Row]) -> Iterator[StudyRow]:
    for event in events.EVENTS:
        of = [row for row in rows if row.get("event") == event.name]
        told = sum(any(right for *_, right in row["accused"]) for row in of)
        false = sum(any(not right for *_, right in row["accused"]) for row in of)
        name = event.name.replace(" ", "_").replace(",", "")
        yield StudyRow.of(f"event.{name}.told", "%", share(told, len(of)), scale=100.0)
        yield StudyRow.of(f"event.{name}.falsely_accused", "%", share(false, len(of)), scale=100.0)


def _cells(rows: Sequence[Row]) -> Iterator[StudyRow]:
    entries: Mapping[str, Entry] = matrix(rows)
    cell: Cell
    for cell in cells():
        entry: Any = entries.get(cell.name)
        if entry is None:
            continue
        yield StudyRow.of(f"{cell.name}.missed_rate", "%", share(entry.missed, entry.trials), scale=100.0)
        yield StudyRow.of(f"{cell.name}.detect_p50_s", "s", entry.delay(0.5))
        yield StudyRow.of(f"{cell.name}.detect_p95_s", "s", entry.delay(0.95))
        yield StudyRow.of(f"{cell.name}.isolation_rate", "%", share(entry.isolated, entry.accused), scale=100.0)
        yield StudyRow.of(f"{cell.name}.false_accusation_rate", "%", share(entry.falsely, entry.trials), scale=100.0)
