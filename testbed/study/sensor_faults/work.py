"""A repetition: one drive, heard sound to its end, and trials that branch off it.

Row: manoeuvre, road, hours; alarms: time [s] and text, on the sound drive; trials: as of `cases.trial`, with the speed
[m/s] and the share of the watched time in which the engine drives; published: false alarms of the seed's own
thresholds; grade: windows of `grade_limit`; and of repetition 0, on an even road, its Table 1, the rated candidates for
Tables 3 and 4, the curves of Figure 15."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from estimators.car import Car
from estimators.redundancy.redundancy import Redundancy
from testbed.scenario import Scenario
from testbed.study.sensor_faults import paper
from testbed.study.sensor_faults.cases import BAR, OTHERS, WATCH, trial
from testbed.study.sensor_faults.drives import Stretch, driven
from testbed.study.sensor_faults.grade_limit import windows

WARM_UP, EVERY = 30, 12  # s from the start to the first trial, and between two
SMALL_WARM_UP = 14  # s
TURNS = 3  # other faults at each place, which take turns
MOVING = 2.0  # m/s: a standing wheel's speed is not stuck but zero


def run(task: dict[str, Any]) -> dict[str, Any]:
    """See the module. ValueError where the car cannot drive it."""
    asked, small = Scenario.from_notes(task["scenario"]), task["small"]
    drive = driven(asked)
    random = np.random.default_rng(asked.seed + 1)
    estimator, alarms, trials = Redundancy(Car(driven_axle=asked.driven)), [], []
    warm, turn = SMALL_WARM_UP if small else WARM_UP, task["number"]
    for number, stretch in enumerate(drive.stretches):
        due = number >= warm and (number - warm) % EVERY == 0 and number + WATCH < len(drive.stretches)
        if due and _speed(stretch) >= MOVING:
            others = [OTHERS[(turn + k) % len(OTHERS)] for k in range(TURNS)]
            turn += TURNS
            start = number + float(random.random())
            for case in (*BAR, *others):
                found = trial(estimator, drive.stretches, number, start, case, random, asked.seed)
                trials.append(found | {"speed": _speed(stretch), "driving": _driving(stretch)})
        said = estimator.update(stretch, number + 1.0)
        alarms += [{"time": alarm.time, "text": alarm.text} for alarm in said.alarms]
    row = {
        "manoeuvre": asked.manoeuvre, "road": asked.road, "hours": asked.duration / 3600.0, "alarms": alarms,
        "trials": trials, "published": paper.false_alarms(paper.record(drive)),
        "grade": windows(drive.stretches, Car()).round(4).tolist(),
    }  # fmt: skip
    return row | (_paper(asked, small) if task["number"] == 0 else {})


def _speed(stretch: Stretch) -> float:
    return float(stretch["wheel/rl/speed"].value.mean()) * Car().rolling_radius


def _driving(stretch: Stretch) -> float:
    return float((stretch["driveline/torque"].value > 0.0).mean())


def _paper(asked: Scenario, small: bool) -> dict[str, Any]:
    """The seed's own drive: speed changes on an even level road, straight and in curves."""
    even = dataclasses.replace(asked, road="flat", grade=0.0, bank=0.0, manoeuvre="motorway", speed=22.0, payload=0.0)
    of = paper.record(driven(even))
    rated = [dataclasses.asdict(candidate) for candidate in paper.candidates(of)]
    example = {name: getattr(of, name).tolist() for name in ("time", "said", "yaw", "truth")}
    row = {"table_1": paper.table_1(of), "candidates": rated, "example": example}
    return row if small else row | {"roc": paper.roc(of)}
