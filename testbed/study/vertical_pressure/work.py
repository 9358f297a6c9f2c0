"""What a task gives: for every method its words at a few moments beside the truth, and the courses of the first drives.

A row's `found` is JSON text: `time_s`; `truth` [kPa], (times, wheels); `by`: for "right" and "wrong" knowledge, method
by method, `kpa` and `std`, (times, wheels), null before the first word; `bound` [kPa], (times, wheels); where there is
an estimator of both axles, `difference`: ln k_front / k_rear of the left and the right side with its std, beside the
true one, `axles_bound` [kPa] and `difference_bound`; `classes`: probability of class D at the times, mean of the
wheels; `course` for a figure.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import GRAVITY
from estimators.drive_log import WHEELS
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.tyre_law import TyreLaw
from testbed.scenario import SENSOR_STEP, Scenario
from testbed.study.study import Row, Task, run_seed
from testbed.study.vertical_pressure.axle_alarm import alarm_row
from testbed.study.vertical_pressure.fit import fit
from testbed.study.vertical_pressure.limits import bounds
from testbed.study.vertical_pressure.limits_of_axles import bounds_of_axles
from testbed.study.vertical_pressure.listening import ESTIMATORS, Heard, drive, last_said
from testbed.study.vertical_pressure.published import METHODS as PUBLISHED
from testbed.study.vertical_pressure.published import Words, words_of
from testbed.study.vertical_pressure.waviness import waviness_of

NAMES = {"vertical_pressure": "bank", "axles": "axles"}
SCORED = (*np.arange(0.5, 10.1, 0.5).tolist(), *np.arange(12.0, 60.1, 4.0).tolist())  # s
FINE = 0.1  # s of a course
WITH_COURSE = ("show", "switch", "drop", "mass", "measured")
KPA = 1e-3


def work(task: Task) -> Row:
    """The row of a task."""
    if "axle_alarm" in task:
        return alarm_row(task)
    if task["kind"] == "fit":
        return {"task": json.dumps(task), "found": json.dumps(fit(task["seed"]))}
    scenario = Scenario.from_notes(task["scenario"])
    heard = drive(scenario, run_seed(task["seed"], 0, 1) if task["kind"] == "levels" else None)
    return {"task": json.dumps(task), "found": json.dumps(_found(task, heard))}


def moments_of(task: Task) -> list[float]:
    """Times at which a drive is scored [s]."""
    duration = task["scenario"]["duration"]
    if task["kind"] in ("switch", "drop"):
        return [FINE * k for k in range(1, int(duration / FINE) + 1)]
    if task["kind"] in ("mass", "measured", "waviness"):
        return [duration]
    return [t for t in SCORED if t <= duration + 1e-9]


def _rows(heard: Heard, times: Sequence[float]) -> NDArray[np.int64]:
    """Places of moments [s] on the sensors' grid."""
    at = np.rint(np.array(times) / SENSOR_STEP).astype(np.int64)
    return np.minimum(at, len(heard.pressure)) - 1


def _found(task: Task, heard: Heard) -> dict[str, Any]:
    times = moments_of(task)
    row = _rows(heard, times)
    found: dict[str, Any] = {"time_s": times, "truth": _listed(KPA * heard.pressure[row]), "by": {}, "classes": {}}
    for place, told in zip(("right", "wrong"), range(len(heard.told)), strict=False):
        by, classes = _words(task, heard, told, times)
        found["by"][place] = by
        if place == "right":
            found["classes"] = classes
        if "axles" in ESTIMATORS:
            found.setdefault("difference", {})[place] = _difference(heard, told, times)
    if task["spectrum"] is not None and task["kind"] in ("classes", "levels", "short"):
        found["bound"] = _listed(KPA * bounds(heard, task["spectrum"], times))
        of_axles = bounds_of_axles(heard, task["spectrum"], times) if "axles" in ESTIMATORS else None
        if of_axles is not None:
            found["axles_bound"], found["difference_bound"] = _listed(KPA * of_axles[0]), _listed(of_axles[1])
    if task["kind"] == "measured":
        found["waviness"] = waviness_of(task["scenario"]["road"])
    if task["number"] == 0 and task["kind"] in WITH_COURSE:
        found["course"] = _course(task, heard)
    return found


def _words(task: Task, heard: Heard, told: int, times: list[float]) -> tuple[dict[str, Any], dict[str, list[Any]]]:
    """By method `kpa` and `std`, and the probability of class D."""
    by, classes = {}, {}
    for name in ESTIMATORS:
        value, std = said(heard, told, name, "pressure")
        by[NAMES[name]] = _entry(value(times), std(times))
        signal = heard.said[told].get(f"est/{name}/road/D")
        if signal is not None:
            classes[NAMES[name]] = _listed(last_said(signal.time, signal.value, times))
    if task["kind"] not in ("short", "waviness"):
        for i, method in enumerate(PUBLISHED):
            words = words_of(method, heard, heard.told[told], run_seed(task["seed"], i, 2))
            by[method] = _entry(last_said(words.time, words.pressure, times), last_said(words.time, words.std, times))
            if words.probability.shape[2] > 1:
                classes[method] = _listed(last_said(words.time, words.probability[:, :, -1].mean(axis=1), times))
    return by, classes


def said(heard: Heard, told: int, estimator: str, quantity: str):
    """Two functions of moments: the value and its std, each (times, 4)."""

    def at(ending: str):
        signals = [heard.said[told].get(f"est/{estimator}/{wheel}/{quantity}{ending}") for wheel in WHEELS]

        def of(times: list[float]) -> NDArray[np.float64]:
            columns = [np.full(len(times), np.nan) if s is None else last_said(s.time, s.value, times) for s in signals]
            return np.stack(columns, axis=1)

        return of

    return at(""), at("/std")


def _difference(heard: Heard, told: int, times: list[float]) -> dict[str, Any]:
    """ln k_front / k_rear of the left and right side as `axles` says it, and by the maker's law at the true
    pressures."""
    car, row = heard.told[0].car, _rows(heard, times)
    loads = [sum(quarter_masses(car, wheel)) * GRAVITY for wheel in WHEELS]
    true = [
        np.log(TyreLaw.of(car).stiffness_at(heard.pressure[row, w], heard.scenario.speed, load))
        for w, load in enumerate(loads)
    ]
    found = {"truth": _listed(np.stack([true[0] - true[2], true[1] - true[3]], axis=1))}
    for ending in ("", "/std"):
        signals = [heard.said[told].get(f"est/axles/{side}/difference{ending}") for side in ("left", "right")]
        columns = [np.full(len(times), np.nan) if s is None else last_said(s.time, s.value, times) for s in signals]
        found["std" if ending else "value"] = _listed(np.stack(columns, axis=1))
    return found


def _entry(value: NDArray[np.float64], std: NDArray[np.float64]) -> dict[str, Any]:
    return {"kpa": _listed(KPA * value), "std": _listed(KPA * std)}


def _listed(table: NDArray[np.float64]) -> Any:
    """Nested lists, null for what is not finite."""
    values = np.round(table, 4).astype(object)
    values[~np.isfinite(table)] = None
    return values.tolist()


def _course(task: Task, heard: Heard) -> dict[str, Any]:
    """Of the front left wheel, every FINE seconds, for a figure."""
    times = [FINE * k for k in range(1, int(heard.scenario.duration / FINE) + 1)]
    row = _rows(heard, times)
    course: dict[str, Any] = {"time_s": times, "truth": _listed(KPA * heard.pressure[row, 0]), "methods": {}}
    for name in ESTIMATORS:
        value, std = said(heard, 0, name, "pressure")
        course["methods"][NAMES[name]] = {
            "kpa": _listed(KPA * value(times)[:, 0]), "std": _listed(KPA * std(times)[:, 0])
        }  # fmt: skip
    for i, method in enumerate(PUBLISHED):
        words: Words = words_of(method, heard, heard.told[0], run_seed(task["seed"], i, 2))
        course["methods"][method] = {
            "kpa": _listed(KPA * last_said(words.time, words.pressure, times)[:, 0]),
            "std": _listed(KPA * last_said(words.time, words.std, times)[:, 0]),
            "modes": _listed(KPA * last_said(words.time, words.modes, times)[:, 0]),
            "probability": _listed(last_said(words.time, words.probability, times)[:, 0]),
        }
    return course
