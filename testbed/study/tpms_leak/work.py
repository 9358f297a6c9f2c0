"""One repetition of the study: simulations of the paper, leaks, and hours without one. JSON values."""

from __future__ import annotations

from typing import Any

import numpy as np

from testbed.study.study import run_seed
from testbed.study.tpms_leak.paper import example, repetitions
from testbed.study.tpms_leak.plant import DAYS, MISMATCHES, PSI, SEED_SENSOR, SLOW_SENSORS, TESTBED_SENSOR
from testbed.study.tpms_leak.trials import leak, sound_hours

LEAKS = {  # by what a row's name ends in: rate [Pa/s], and for how long it is watched at 20 Hz [s]
    "0p1_psi_s": (0.1 * PSI, 60.0),
    "0p2_psi_s": (0.2 * PSI, 60.0),
    "1_psi_s": (PSI, 60.0),
    "10_kpa_h": (10e3 / 3600.0, 5400.0),
}
LONGEST_SLOW = (1800.0, 7200.0)  # s that a leak is watched by a slow sensor, if faster than 100 Pa/s or slower
SENSORS = {"": SEED_SENSOR, "_1_s": TESTBED_SENSOR} | {f"_{name}": sensor for name, sensor in SLOW_SENSORS.items()}
PAPER_RUNS, TRIALS = 50, 40  # of each kind, a repetition
HOURS = {"": 50.0, "_1_s": 200.0, "_30_s": 400.0, "_60_s": 400.0}
OFF_HOURS = {"_1_s": 50.0, "_60_s": 100.0}  # with each of the mismatches, by sensor
OFF = {name: (plan, True) for name, plan in MISMATCHES.items()} | {
    "without_speed": (DAYS, False),
    "load_steps_150_kg_without_speed": (MISMATCHES["load_steps_150_kg"], False),
}  # by what a row's name ends in: tyre and days, and whether the monitor knows the speed
SMALL_PAPER_RUNS, SMALL_TRIALS, SMALL_SHARE = 5, 2, 0.01


def task(seed: int, number: int, small: bool) -> dict[str, Any]:
    """Of repetition `number`."""
    return {"seed": run_seed(seed, number), "number": number, "small": small}


def repeat(task: dict[str, Any]) -> dict[str, Any]:
    """The row of a task. paper: see `paper`; leaks: by sensor and leak a list of trials; sound: by sensor; off: by
    sensor and mismatch."""
    seed, small = task["seed"], task["small"]
    rng = np.random.default_rng(seed)
    row: dict[str, Any] = {"paper": repetitions(SMALL_PAPER_RUNS if small else PAPER_RUNS, rng)}
    if task["number"] == 0:
        row["example"] = example(rng)
    row["leaks"], row["sound"], row["off"] = {}, {}, {}
    share = SMALL_SHARE if small else 1.0
    for ending, sensor in SENSORS.items():
        row["sound"][ending] = sound_hours(sensor, share * HOURS[ending], seed, 1)
        for name, (rate, at_20_hz) in LEAKS.items():
            watched = at_20_hz if sensor is SEED_SENSOR else LONGEST_SLOW[int(rate < 100.0)]
            row["leaks"][name + ending] = [
                leak(sensor, rate, watched, run_seed(seed, i, 2)) for i in range(SMALL_TRIALS if small else TRIALS)
            ]
    for ending, hours in OFF_HOURS.items():
        for place, (name, (plan, speed)) in enumerate(OFF.items()):
            found = sound_hours(SENSORS[ending], share * hours, seed, 2 + place, plan, speed)
            row["off"][f"{ending}_{name}"] = {"alarms": found["alarms"], "hours": found["hours"]}
    return row
