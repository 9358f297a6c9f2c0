"""Study `wheel-radius`: Persson, Gustafsson, Drevo, SAE 2002-01-1250, Figures 6 and 7: relative rolling radii of front
against rear (delta13, delta24) and left against right wheels (delta12, delta34) in five test runs.

The paper's deltas are 1 - r1/r3 and r3/r4 - 1; here r3/r1 - 1 and so on, the same to first order. Its one figure for
both kinds: "about 60 seconds to track the right level"; its conclusion: 25 % lost is detected within one minute by
either analysis alone. Its levels are pictures without numbers. The table's `limit`: for a level the truth, for NEES 1,
for an error the std that was reported.

The right level, from which errors count, is the mean of the true radii's delta over the time before a loss and over the
time after it: rolling radii also move with every transfer of load, which no estimate of a level can or should follow.
Reached: within NEAR of the level for the first time; settled: from then on to the end. NEAR is a third of what the lost
pressure does. A drive that gets nowhere counts as such (Kaplan-Meier), so a median may have no upper limit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from estimators.scores.accuracy import rmse, settling_times
from estimators.scores.consistency import nees_consistency, nees_of_std
from estimators.scores.detection import detection_times
from estimators.scores.false_alarms import false_alarms
from estimators.scores.interval import mean_interval, proportion_interval
from estimators.scores.survival import EventTimes, event_curve, share_by
from testbed.course import PAIRS
from testbed.study.study import Row, Study, StudyRow, Task
from testbed.study.wheel_radius.drives import SMALL, TEST_RUNS, drive_test_runs, task
from testbed.study.wheel_radius.slopes import slope_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER_TIME = 60.0  # s
NEAR = 8e-4
FINAL = 20.0  # s at the end over which a level is averaged, and least time to have stayed near for it to count
WARM_UP = 60.0  # s from the start, and from a loss on, that errors and NEES leave out: the paper's own time to follow
GAP = 60.0  # s between alarms that count as two
AFFECTED = {"fl": ("delta12", "delta13"), "rl": ("delta34", "delta13")}


def curves(rows: Sequence[Row], test_run: str, name: str, what: str) -> NDArray[np.float64]:
    """value, std or truth of a delta over time [-], shape (drives, time)."""
    return np.array([row[f"{test_run}/{name}/{what}"] for row in rows], float)


def levels(rows: Sequence[Row], test_run: str, name: str) -> NDArray[np.float64]:
    """The right level of a delta over time [-], shape (drives, time)."""
    truth, (wheel, from_start) = curves(rows, test_run, name, "truth"), TEST_RUNS[test_run]
    later = clock(rows) > (0.0 if wheel is None or from_start else rows[0]["onset_s"])
    level = np.empty_like(truth)
    for part in (later, ~later):
        if part.any():
            level[:, part] = truth[:, part].mean(axis=1, keepdims=True)
    return level


def _error(rows: Sequence[Row], test_run: str, name: str) -> NDArray[np.float64]:
    """Estimate less the right level [-], shape (drives, time)."""
    return curves(rows, test_run, name, "value") - levels(rows, test_run, name)


def clock(rows: Sequence[Row]) -> NDArray[np.float64]:
    """Time [s], shape (time,)."""
    return np.array(rows[0]["nominal/time_s"], float)


class WheelRadiusStudy(Study):
    name = "wheel-radius"
    about = "How well do wheel speeds tell relative tyre radii and a lost quarter of pressure, and how soon?"
    paper = "Persson, Gustafsson, Drevo, SAE 2002-01-1250, Figures 6 and 7."
    runs = 12

    @property
    def work(self) -> Callable[[Task], Row]:
        return drive_test_runs

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        return [task(seed, number, SMALL if small else 1.0) for number in range(runs)]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        return [
            *_levels(rows), *_errors(rows), *_settling(rows), *_detection(rows), _false_alarms(rows), *slope_rows(rows),
        ]  # fmt: skip

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.wheel_radius.figures import figures  # matplotlib, only where something is drawn

        return figures(rows)


def _levels(rows: Sequence[Row]) -> Iterator[StudyRow]:
    last = clock(rows) > clock(rows)[-1] - FINAL
    for test_run in TEST_RUNS:
        for name in PAIRS:
            level = np.nanmean(curves(rows, test_run, name, "value")[:, last], axis=1)
            right = float(levels(rows, test_run, name)[:, last].mean())
            yield StudyRow.of(f"final {name}, {test_run}", "1e-3", mean_interval(level), limit=1e3 * right, scale=1e3)


def _judged(rows: Sequence[Row], name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Errors and stds of a delta in all five test runs one after another, nan while a filter follows a change."""
    time, onset = clock(rows), rows[0]["onset_s"]
    errors, stds = [], []
    for test_run, (wheel, from_start) in TEST_RUNS.items():
        following = time <= WARM_UP
        if wheel and not from_start:
            following |= (time > onset) & (time <= onset + WARM_UP)
        errors.append(np.where(following, np.nan, _error(rows, test_run, name)))
        stds.append(curves(rows, test_run, name, "std"))
    return np.concatenate(errors, axis=1), np.concatenate(stds, axis=1)


def _errors(rows: Sequence[Row]) -> Iterator[StudyRow]:
    for name in PAIRS:
        error, std = _judged(rows, name)
        if not np.isfinite(error).any():
            continue  # the small form ends before a filter has settled
        reported = float(np.sqrt(np.nanmean(np.where(np.isfinite(error), std, np.nan) ** 2)))
        yield StudyRow.of(f"r.m.s. error of {name}", "1e-3", rmse(error), limit=1e3 * reported, scale=1e3)
        yield StudyRow.of(f"mean NEES of {name}", "-", nees_consistency(nees_of_std(error, std)).mean, limit=1.0)


def _settling(rows: Sequence[Row]) -> Iterator[StudyRow]:
    time = clock(rows)
    for test_run, (wheel, from_start) in TEST_RUNS.items():
        if wheel is None:
            continue
        since = 0.0 if from_start else rows[0]["onset_s"]
        later = time > since
        for name in AFFECTED[wheel]:
            error, passed = _error(rows, test_run, name)[:, later], time[later] - since
            if not np.isfinite(error).any():
                continue
            reached = event_curve(_first_within(error, passed)).quantile(0.5)
            settled = event_curve(settling_times(error, passed, NEAR, hold=FINAL)).quantile(0.5)
            yield StudyRow.of(f"median time to reach, {name}, {test_run}", "s", reached, paper=PAPER_TIME)
            yield StudyRow.of(f"median time to settle, {name}, {test_run}", "s", settled)


def _first_within(error: NDArray[np.float64], time: NDArray[np.float64]) -> EventTimes:
    """First time of each drive within NEAR of the level, censored at its end."""
    near = np.abs(error) <= NEAR  # nan is not near
    return EventTimes(np.where(near.any(axis=1), time[near.argmax(axis=1)], time[-1]), near.any(axis=1))


def _detected(rows: Sequence[Row], test_run: str, wheel: str, from_start: bool) -> tuple[EventTimes, int]:
    """Times to the first alarm, and how many first alarms name the low wheel and no other."""
    onset = 0.0 if from_start else rows[0]["onset_s"]
    events = detection_times(
        [row[f"{test_run}/alarms"] for row in rows], np.full(len(rows), onset), [row["duration_s"] for row in rows]
    )
    right = 0
    for row in rows:
        first = [w for t, w in zip(row[f"{test_run}/alarms"], row[f"{test_run}/wheels"], strict=True) if t >= onset][:1]
        right += first == [wheel]
    return events, right


def _detection(rows: Sequence[Row]) -> Iterator[StudyRow]:
    for test_run, (wheel, from_start) in TEST_RUNS.items():
        if wheel is None:
            continue
        events, right = _detected(rows, test_run, wheel, from_start)
        median = event_curve(events).quantile(0.5)
        yield StudyRow.of(f"median time to an alarm, {test_run}", "s", median, paper=PAPER_TIME)
        if events.time.min() > PAPER_TIME or rows[0]["duration_s"] > PAPER_TIME:
            share = share_by(events, PAPER_TIME)
            yield StudyRow.of(f"share with an alarm within {PAPER_TIME:g} s, {test_run}", "-", share, paper=1.0)
        yield StudyRow.of(
            f"share with any alarm, {test_run}", "-", proportion_interval(int(events.observed.sum()), len(events))
        )
        if events.observed.any():
            named = proportion_interval(right, int(events.observed.sum()))
            yield StudyRow.of(f"share of alarms that name the wheel, {test_run}", "-", named, limit=1.0)


def _false_alarms(rows: Sequence[Row]) -> StudyRow:
    """On nominal drives, and before a loss."""
    given, spans = [], []
    for test_run, (wheel, from_start) in TEST_RUNS.items():
        if wheel is not None and from_start:
            continue
        for row in rows:
            end = row["duration_s"] if wheel is None else row["onset_s"]
            given.append([t for t in row[f"{test_run}/alarms"] if t < end])
            spans.append(end)
    counted = false_alarms(given, np.array(spans), GAP)
    return StudyRow.of(f"false alarms ({counted.count} in {counted.hours:.1f} h)", "1/h", counted.rate)
