"""Errors of finished drives as arrays, and the accuracy rows: RMSE, bias, NEES of every method beside the bound.

A drive's four wheels roll over the same two tracks, so they are no independent samples: every interval takes the drive
as its unit (a mean of wheels a drive), Student t of means, on the logarithm of mean squares.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.scores.interval import Interval, mean_interval, positive_mean_interval
from testbed.study.study import Row, StudyRow
from testbed.study.vertical_pressure.published import METHODS as PUBLISHED
from testbed.study.vertical_pressure.tasks import nearest_class
from testbed.study.vertical_pressure.told import CLASSES

METHODS = (*PUBLISHED, "bank", "axles")
BEST, BOUNDS = ("bank", "axles"), {"axles": "axles_bound"}
MOMENTS = (2.0, 10.0, 60.0)
MOST_BIAS, MOST_OVER_BOUND = 3.0, 1.3  # kPa, -
MOST_DIFFERENCE = {2.0: 2.5, 10.0: 1.2}  # % of ln k_front / k_rear
# ending of the rows, kinds of drives, knowledge
TABLES = (("", ("classes",), "right"), ("_levels", ("levels",), "right"), ("_wrong", ("levels",), "wrong"))


def decoded(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Rows with their task and what was found as values; those of the alarm are not among them."""
    return [{"task": json.loads(row["task"]), **json.loads(row["found"])} for row in rows if row.get("found")]


def of_kind(drives: Sequence[dict[str, Any]], *kinds: str) -> list[dict[str, Any]]:
    """Drives of these kinds."""
    return [drive for drive in drives if drive["task"]["kind"] in kinds]


def at(drive: dict[str, Any], seconds: float) -> int | None:
    """Place of a moment among a drive's, None if it is not scored."""
    place = np.flatnonzero(np.abs(np.array(drive["time_s"]) - seconds) < 1e-6)
    return int(place[0]) if len(place) else None


def error_and_std(
    drives: Sequence[dict[str, Any]], method: str, seconds: float, knowledge: str = "right"
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Estimate less truth and reported std [kPa], each (drives, wheels), of the drives that have it."""
    error, std = [], []
    for drive in drives:
        entry, place = drive["by"].get(knowledge, {}).get(method), at(drive, seconds)
        if entry is None or place is None:
            continue
        said, true = np.array(entry["kpa"][place], float), np.array(drive["truth"][place], float)
        if np.isfinite(said).all():
            error.append(said - true)
            std.append(np.array(entry["std"][place], float))
    return np.array(error).reshape(-1, 4), np.array(std).reshape(-1, 4)


def bound_of(drives: Sequence[dict[str, Any]], seconds: float, name: str = "bound") -> Interval | None:
    """Root mean square of the drives' bounds of that name."""
    found = [np.mean(np.square(d[name][place])) for d in drives if name in d and (place := at(d, seconds)) is not None]
    return positive_mean_interval(np.array(found)).mapped(math.sqrt) if found else None


def rmse(error: NDArray[np.float64]) -> Interval:
    """Of errors (drives, wheels)."""
    return positive_mean_interval(np.mean(error**2, axis=1)).mapped(math.sqrt)


def _over(interval: Interval, by: float) -> Interval:
    return Interval(interval.value / by, interval.low / by, interval.high / by)


def class_biases(drives: Sequence[dict[str, Any]], method: str, seconds: float) -> dict[str, Interval]:
    """Mean error in each class [kPa]; levels count to the nearest."""
    found = {}
    for name in CLASSES:
        own = [d for d in drives if d["task"]["spectrum"] and nearest_class(d["task"]["spectrum"]) == name]
        error, _ = error_and_std(own, method, seconds)
        if len(error):
            found[name] = mean_interval(error.mean(axis=1))
    return found


def table(drives: Sequence[dict[str, Any]]) -> Iterator[StudyRow]:
    """See `vertical_pressure`."""
    for method in METHODS:
        yield from _accuracy(drives, method)
        yield from _bias(drives, method)
    yield from _bounds(drives)
    yield from _difference(drives)
    yield from _ratios(drives)


def _accuracy(drives: Sequence[dict[str, Any]], method: str) -> Iterator[StudyRow]:
    for ending, kinds, knowledge in TABLES:
        own = of_kind(drives, *kinds)
        for seconds in MOMENTS:
            error, std = error_and_std(own, method, seconds, knowledge)
            if not len(error):
                continue
            bound = bound_of(own, seconds, BOUNDS.get(method, "bound"))
            name = f"{method}.rmse_kpa_{seconds:g}s{ending}"
            yield StudyRow.of(name, "kPa", rmse(error), limit=None if bound is None else bound.value)
            yield StudyRow.of(
                f"{method}.nees_{seconds:g}s{ending}", "-",
                positive_mean_interval(np.mean((error / std) ** 2, axis=1)), limit=1.0,
            )  # fmt: skip


def _bias(drives: Sequence[dict[str, Any]], method: str) -> Iterator[StudyRow]:
    own = of_kind(drives, "classes", "levels", "short")
    for seconds in MOMENTS:
        found = class_biases(own, method, seconds)
        if not found:
            continue
        worst = max(found.values(), key=lambda bias: abs(bias.value))
        limit = MOST_BIAS if method == "bank" and seconds == 10.0 else None
        yield StudyRow.of(f"{method}.bias_kpa_{seconds:g}s", "kPa", worst, limit=limit)
        for name, bias in found.items():
            yield StudyRow.of(f"{method}.bias_kpa_{seconds:g}s_class_{name}", "kPa", bias, limit=limit)
    wrong, _ = error_and_std(of_kind(drives, "levels"), method, 10.0, "wrong")
    if len(wrong):
        yield StudyRow.of(f"{method}.bias_kpa_10s_wrong", "kPa", mean_interval(wrong.mean(axis=1)))


def _bounds(drives: Sequence[dict[str, Any]]) -> Iterator[StudyRow]:
    for name in ("bound", "axles_bound"):
        for ending, kinds, _ in TABLES[:2]:
            for seconds in MOMENTS:
                bound = bound_of(of_kind(drives, *kinds), seconds, name)
                if bound is not None:
                    yield StudyRow.of(f"{name}.rmse_kpa_{seconds:g}s{ending}", "kPa", bound)


def difference_error(drives: Sequence[dict[str, Any]], seconds: float) -> NDArray[np.float64]:
    """Of ln k_front / k_rear, (drives, sides), of the drives in which `axles` says it."""
    found = []
    for drive in drives:
        place, entry = at(drive, seconds), drive.get("difference", {}).get("right")
        if entry is not None and place is not None and None not in entry["value"][place]:
            found.append(np.subtract(entry["value"][place], entry["truth"][place]))
    return np.array(found).reshape(-1, 2)


def _difference(drives: Sequence[dict[str, Any]]) -> Iterator[StudyRow]:
    own = of_kind(drives, "classes", "levels", "short")
    for seconds in MOMENTS:
        error = 100.0 * difference_error(own, seconds)
        if len(error):
            limit = MOST_DIFFERENCE.get(seconds)
            yield StudyRow.of(f"axles.difference_rmse_pct_{seconds:g}s", "%", rmse(error), limit=limit)
            bound = bound_of(own, seconds, "difference_bound")
            if bound is not None:
                yield StudyRow.of(f"axles_bound.difference_rmse_pct_{seconds:g}s", "%", bound, scale=100.0)
            yield StudyRow.of(f"axles.difference_bias_pct_{seconds:g}s", "%", mean_interval(error.mean(axis=1)))


def _ratios(drives: Sequence[dict[str, Any]]) -> Iterator[StudyRow]:
    """RMSE over bound and NEES of all drives that know rightly."""
    own = of_kind(drives, "classes", "levels", "short")
    for method in BEST:
        for seconds in MOMENTS:
            error, std = error_and_std(own, method, seconds)
            bound = bound_of([d for d in own if at(d, seconds) is not None], seconds, BOUNDS.get(method, "bound"))
            if not len(error) or bound is None:
                continue
            limit = MOST_OVER_BOUND if seconds == 10.0 else None
            yield StudyRow.of(
                f"{method}.rmse_over_bound_{seconds:g}s", "-", _over(rmse(error), bound.value), limit=limit
            )
            nees = positive_mean_interval(np.mean((error / std) ** 2, axis=1))
            yield StudyRow.of(f"{method}.nees_{seconds:g}s_all", "-", nees, limit=1.0)
