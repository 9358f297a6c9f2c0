"""One drive of a campaign as a row: what was driven, what was true, what each estimator said, on one time axis.

Columns beside those of the engine:

    number, VARIABLE                     as in the campaign file
    scenario                             JSON, as `testbed.drive --scenario FILE` reads it
    duration_s, distance_m, WHEEL/COLUMN of the drive; the last are means over it, as `testbed.drive --json` gives them
    nominal_pressure_kpa                 of the tyre that drives
    time_s                               [s], (n,): the ends of at most SAMPLES equal parts of the drive
    pressure_kpa/WHEEL                   true pressure at these times, (n,)
    METHOD/QUANTITY/{value,std,truth}    of each quantity that has a truth, in its SI unit, (n,); nan before it is given
    alarms                               JSON: [[time_s, method, [wheel, ...]], ...]
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS, Signal
from testbed.campaign.variants import variant_of
from testbed.course import Course, CourseTaker, truth_of
from testbed.scenario import Scenario
from testbed.session import Session
from testbed.summary import Summary

SAMPLES = 120
NAN = float("nan")


class _Said:
    """The estimates of a drive, joined over its stretches."""

    def __init__(self) -> None:
        self._parts: dict[str, list[Signal]] = {}

    def add(self, said: Mapping[str, Signal]) -> None:
        for name, signal in said.items():
            if name.startswith("est/") and signal.value.dtype.kind == "f":
                self._parts.setdefault(name.removeprefix("est/"), []).append(signal)

    @property
    def quantities(self) -> list[str]:
        """METHOD/QUANTITY of each estimate."""
        return sorted(name for name in self._parts if not name.endswith("/std"))

    def at(self, name: str, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """The last word of an estimate (or its std) at each time, nan before the first."""
        time, value = (np.concatenate([getattr(p, what) for p in self._parts[name]]) for what in ("time", "value"))
        last = np.searchsorted(time, times + 1e-9, side="right") - 1
        return np.where(last >= 0, value[last], NAN)


def _calibrate(task: Mapping[str, Any]) -> tuple[dict[str, Any] | None, NDArray[np.float64] | None]:
    """What the estimators learn on the drive before, and the mean radii there [m]; None without such a drive."""
    if not task["calibration"]:
        return None, None
    scenario = Scenario.from_notes(task["calibration"])
    variant = variant_of(scenario, task["vehicle"], task["tyre"], task["believed"])
    course = CourseTaker()
    with Session(scenario, None, task["estimators"], variant) as session:
        for stretch, _ in session.run():
            course.add(stretch)
        return session.bank.calibrations(), course.course().rolling_radius.mean(axis=0)


def drive_row(task: dict[str, Any]) -> dict[str, Any]:
    """The row of a task of `testbed.campaign.plan`. ValueError where the drive cannot be driven to its end."""
    return recorded_drive(task, None)


def recorded_drive(task: Mapping[str, Any], recording: Path | None) -> dict[str, Any]:
    """The same, and the drive's recording (not that of its calibration) where a path is given."""
    calibrations, radii = _calibrate(task)
    scenario = Scenario.from_notes(task["scenario"])
    variant = variant_of(scenario, task["vehicle"], task["tyre"], task["believed"], calibrations)
    taker, said = CourseTaker(), _Said()
    with Session(scenario, recording, task["estimators"], variant) as session:
        simulation = session.simulation
        summary = Summary(simulation.element.law)
        for stretch, words in session.run():
            taker.add(stretch)
            said.add(words)
            summary.add(stretch)
    alarms = [[a.time, name, list(a.wheels)] for name, given in session.bank.alarms.items() for a in given]
    figures = summary.as_json()
    row: dict[str, Any] = {"number": task["number"], **task["variables"], "scenario": json.dumps(task["scenario"])}
    row |= {"duration_s": scenario.duration, "distance_m": figures["distance_m"]}
    row |= {f"{wheel}/{name}": value for wheel, entry in figures["wheels"].items() for name, value in entry.items()}
    row["nominal_pressure_kpa"] = 1e-3 * simulation.tyre.p0
    reference = np.full(4, simulation.nominal_radius) if radii is None else radii
    row |= _series(said, taker.course(), scenario.step, simulation.tyre.p0, reference)
    return row | {"alarms": json.dumps(sorted(alarms))}


def _series(
    said: _Said, course: Course, step: float, nominal_pressure: float, reference: NDArray[np.float64]
) -> dict[str, list[float]]:
    """The columns over time. step: of the drive's clock [s]; a stretch ends so much after its last row."""
    every = -(-len(course.time) // SAMPLES)
    picked = np.arange(every - 1, len(course.time), every)
    times = course.time[picked] + step
    columns = {"time_s": times.tolist()}
    columns |= {f"pressure_kpa/{w}": (1e-3 * course.pressure[picked, i]).tolist() for i, w in enumerate(WHEELS)}
    for name in said.quantities:
        truth = truth_of(name.split("/", 1)[1], course, nominal_pressure, reference)
        if truth is not None:
            columns[f"{name}/value"] = said.at(name, times).tolist()
            columns[f"{name}/std"] = said.at(f"{name}/std", times).tolist()
            columns[f"{name}/truth"] = truth[picked].tolist()
    return columns
