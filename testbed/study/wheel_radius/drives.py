"""The five test runs of a repetition: one car, one road and one seed of the sensors for all five.

    1 nominal    2, 3 front left low from the start, after 220 s    4, 5 rear left low from the start, after 220 s

The paper says neither how low nor on which roads. Declared here: low is a quarter below nominal (187.5 of 250 kPa),
which its conclusion claims this analysis finds alone; repetitions take turns between town at up to 60 km/h and
motorway at about 110 km/h, and between roads of class A, B and C. The tyres' radii are off nominal by OFF, as different
wear makes them, the same in every repetition: the paper's car too had deltas that are not zero at nominal pressure. A
calibration drive of CALIBRATION at nominal pressures on another road comes before, as the paper asks for one.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from estimators.drive_log import WHEELS
from testbed.campaign.variants import variant_of
from testbed.course import PAIRS, CourseTaker, truth_of
from testbed.scenario import Scenario
from testbed.session import Session
from testbed.study.study import run_seed
from testbed.study.wheel_radius.slopes import drive_slopes, slope_drives
from testbed.tyre.inflation import PressureSet

METHOD = "wheel_radius"
DURATION, ONSET, CALIBRATION = 440.0, 220.0, 400.0  # s
SMALL = 1.0 / 16.0  # of all times, in the small form
WITHIN = 1.0  # s that the change of pressure takes
NOMINAL, LOW = 250e3, 187.5e3  # Pa
OFF = {"fl": 1.0010, "fr": 0.9995, "rl": 1.0, "rr": 1.0015}  # radius over nominal
DRIVING = (("town", 60.0 / 3.6), ("motorway", 110.0 / 3.6))  # m/s
ROADS = ("A", "B", "C")
# name: low wheel (None: none), whether from the start
TEST_RUNS: dict[str, tuple[str | None, bool]] = {
    "nominal": (None, True),
    "front left low": ("fl", True),
    "front left low after 220 s": ("fl", False),
    "rear left low": ("rl", True),
    "rear left low after 220 s": ("rl", False),
}
EVERY = 2  # s between samples that are kept


def task(seed: int, number: int, share: float = 1.0) -> dict[str, Any]:
    """The drives of repetition `number`; share: of all times."""
    manoeuvre, speed = DRIVING[number % len(DRIVING)]
    nominal = Scenario(
        road=ROADS[number % len(ROADS)], speed=speed, duration=share * DURATION, manoeuvre=manoeuvre,
        seed=run_seed(seed, number), radius_factor=OFF,
    )  # fmt: skip
    before = dataclasses.replace(nominal, duration=share * CALIBRATION, seed=run_seed(seed, number, 1))
    return {
        "calibration": before.as_notes(),
        "drives": {
            name: _with_loss(nominal, *how, share * ONSET).as_notes() for name, how in TEST_RUNS.items()
        },
        "slopes": slope_drives(nominal, share),
    }  # fmt: skip


def _with_loss(scenario: Scenario, wheel: str | None, from_start: bool, onset: float) -> Scenario:
    if wheel is None:
        return scenario
    if from_start:
        return dataclasses.replace(scenario, pressures={wheel: LOW})
    return dataclasses.replace(scenario, pressure_sets={wheel: PressureSet(LOW, onset, WITHIN)})


def drive_test_runs(task: dict[str, Any]) -> dict[str, Any]:
    """The row of a repetition: `onset_s`, `duration_s`, `time_s` (n,), and for each test run and delta NAME

    TEST_RUN/NAME/{value,std,truth}    [-], (n,)
    TEST_RUN/alarms, TEST_RUN/wheels   times [s] of alarms, and the wheels that each names, joined by commas

    and what `drive_slopes` gives.
    """
    before = Scenario.from_notes(task["calibration"])
    variant = dataclasses.replace(variant_of(before, {}, {}, {}), only_read=True)
    with Session(before, None, [METHOD], variant) as session:
        for _ in session.run():
            pass
        learnt = session.bank.calibrations()
    row: dict[str, Any] = {}
    for name, notes in task["drives"].items():
        scenario = Scenario.from_notes(notes)
        row |= {f"{name}/{key}": value for key, value in _drive(scenario, learnt).items()}
        row |= {"duration_s": scenario.duration, "onset_s": scenario.duration * ONSET / DURATION}
    return row | drive_slopes(task["slopes"])


def _drive(scenario: Scenario, learnt: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    taker = CourseTaker()
    said: list[dict[str, tuple[float, float]]] = []
    variant = dataclasses.replace(variant_of(scenario, {}, {}, {}, learnt), only_read=True)
    with Session(scenario, None, [METHOD], variant) as session:
        last: dict[str, tuple[float, float]] = {}
        for stretch, words in session.run():
            taker.add(stretch)
            for name in PAIRS:
                value = words.get(f"est/{METHOD}/{name}")
                if value is not None and len(value):
                    last[name] = (float(value.value[-1]), float(words[f"est/{METHOD}/{name}/std"].value[-1]))
            said.append(dict(last))
        alarms = session.bank.alarms.get(METHOD, ())
        p0 = session.simulation.tyre.p0
    course = taker.course()
    kept = np.arange(EVERY - 1, len(course.time), EVERY)
    row: dict[str, Any] = {
        "time_s": (course.time[kept] + scenario.step).tolist(),
        "alarms": [float(alarm.time) for alarm in alarms],
        "wheels": [",".join(alarm.wheels) for alarm in alarms],
    }
    for name in PAIRS:
        truth = truth_of(name, course, p0, np.ones(len(WHEELS)))
        missing = (float("nan"), float("nan"))
        value, std = np.array([said[k].get(name, missing) for k in kept]).T
        row |= {f"{name}/value": value.tolist(), f"{name}/std": std.tolist()}
        row[f"{name}/truth"] = [] if truth is None else truth[kept].tolist()
    return row
