"""Rows on what changes during a drive: the road's class, the pressure; and on load and the measured road.

METHOD.mode_switch_delay_s     from the first metre of class D until the probability of D (mean of the wheels, over
                               the last half second) passes 0.5; median of the drives
METHOD.drop_follow_s           from the beginning of the fall until a wheel's estimate has fallen by half of it (25
                               kPa) below its own mean of the 5 s before, mean of a drive's wheels; median of the
                               drives. A drive in which a wheel's never does counts as not reached
METHOD.mass_24pct_shift_pct    how far the load moves the estimate at 30 s, less what it moves the truth, in % of
                               the pressure; the wheel whose mean over the drives is largest
METHOD.measured_road_*         error at the end of the measured road, 30 s
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.scores.interval import Interval, mean_interval, positive_mean_interval
from estimators.scores.survival import EventTimes, event_curve
from testbed.study.study import StudyRow
from testbed.study.vertical_pressure.errors import METHODS, error_and_std, of_kind, rmse
from testbed.study.vertical_pressure.tasks import AFTER_DROP, BEFORE_DROP, SMALL, SWITCH_AT, SWITCH_LONG
from testbed.study.vertical_pressure.work import FINE

HALF = 0.5e-3 * (BEFORE_DROP - AFTER_DROP)  # kPa
BEFORE, RECENT = 5.0, 0.5  # s
PAPER_SHIFT = 5.0  # %: "the mean estimation error is lower than 5 %"


def table(drives: Sequence[dict[str, Any]]) -> Iterator[StudyRow]:
    """See the module."""
    for drive in of_kind(drives, "measured")[:1]:
        yield StudyRow("measured_road.waviness", "-", None, drive["waviness"], None, 2.0)
    for method in METHODS:
        switches = [s for d in of_kind(drives, "switch") if (s := switch_delay(d, method))]
        if switches:
            yield StudyRow.of(f"{method}.mode_switch_delay_s", "s", _median(switches))
        drops = [s for d in of_kind(drives, "drop") if (s := drop_delay(d, method))]
        if drops:
            yield StudyRow.of(f"{method}.drop_follow_s", "s", _median(drops))
        for percent in ("8", "24"):
            shift = mass_shift(drives, method, percent)
            if shift is not None:
                yield StudyRow.of(
                    f"{method}.mass_{percent}pct_shift_pct", "%", shift, paper=PAPER_SHIFT, limit=PAPER_SHIFT
                )  # fmt: skip
        measured = of_kind(drives, "measured")
        if measured:
            error, std = error_and_std(measured, method, measured[0]["time_s"][-1])
            if len(error):
                yield StudyRow.of(f"{method}.measured_road_rmse_kpa", "kPa", rmse(error))
                yield StudyRow.of(f"{method}.measured_road_bias_kpa", "kPa", mean_interval(error.mean(axis=1)))
                nees = positive_mean_interval(np.mean((error / std) ** 2, axis=1))
                yield StudyRow.of(f"{method}.measured_road_nees", "-", nees, limit=1.0)


def _median(events: Sequence[tuple[float, bool]]) -> Interval:
    return event_curve(EventTimes([t for t, _ in events], [seen for _, seen in events])).quantile(0.5)


def _onset(drive: dict[str, Any], full: float, whole: float) -> float:
    """Of the change [s], in the small form too."""
    return full if drive["task"]["scenario"]["duration"] > 0.5 * whole else SMALL * full


def switch_delay(drive: dict[str, Any], method: str) -> tuple[float, bool] | None:
    """(seconds, reached); None where the method does not tell classes."""
    course = drive["classes"].get(method)
    if course is None:
        return None
    time, onset = np.array(drive["time_s"]), _onset(drive, SWITCH_AT, SWITCH_LONG)
    probability = np.nan_to_num(np.array(course, float))
    wide = round(RECENT / FINE)
    smooth = np.convolve(probability, np.ones(wide) / wide)[: len(probability)]
    found = np.flatnonzero((time > onset) & (smooth > 0.5))
    return (float(time[found[0]] - onset), True) if len(found) else (float(time[-1] - onset), False)


def drop_delay(drive: dict[str, Any], method: str) -> tuple[float, bool] | None:
    """(seconds, whether all wheels' did); None before the first word."""
    entry = drive["by"]["right"].get(method)
    if entry is None:
        return None
    time, said = np.array(drive["time_s"]), np.array(entry["kpa"], float)
    onset = next(iter(drive["task"]["scenario"]["pressure_sets"].values()))["start"]
    before = (time <= onset + 1e-9) & (time > onset - BEFORE)
    if not np.isfinite(said[before]).any():
        return None
    own = np.nanmean(said[before], axis=0)
    passed: list[float] = []
    for w in range(said.shape[1]):
        found = np.flatnonzero((time > onset) & (said[:, w] < own[w] - HALF))
        if not len(found):
            return float(time[-1] - onset), False
        passed.append(float(time[found[0]] - onset))
    return float(np.mean(passed)), True


def mass_shift(drives: Sequence[dict[str, Any]], method: str, percent: str) -> Interval | None:
    """[%], see the module."""
    by = {(d["task"]["number"], d["task"]["percent"]): d for d in of_kind(drives, "mass")}
    shifts: list[NDArray[np.float64]] = []
    for number, load in by:
        light = by.get((number, "0"))
        if load != percent or light is None:
            continue
        heavy = by[number, load]
        values = [_relative_error(d, method) for d in (light, heavy)]
        if values[0] is not None and values[1] is not None:
            shifts.append(100.0 * (values[1] - values[0]))
    if not shifts:
        return None
    every = [mean_interval(column) for column in np.array(shifts).T]
    return max(every, key=lambda shift: abs(shift.value) if math.isfinite(shift.value) else 0.0)


def _relative_error(drive: dict[str, Any], method: str) -> NDArray[np.float64] | None:
    entry = drive["by"]["right"].get(method)
    if entry is None or None in entry["kpa"][-1]:
        return None
    return np.array(entry["kpa"][-1], float) / np.array(drive["truth"][-1], float) - 1.0
