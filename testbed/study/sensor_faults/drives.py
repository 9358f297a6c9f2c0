"""The study's drives: ordinary driving over classes A to D with grade and bank, and what its sensors say.

Of ten drives four are on a motorway, two in town, two stop and go, one keeps its speed, one swerves; class A, B and C
are three times as frequent as D, on which nobody goes faster than 72 km/h. Grade within 6 %, bank within 4 %, payload
up to 400 kg, either axle driven, radii off nominal by a standard deviation of 0.2 %."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS
from estimators.redundancy.redundancy import Redundancy
from testbed.scenario import Scenario
from testbed.study.sensed import Stretch, sensed
from testbed.study.study import run_seed

DURATION, SMALL_DURATION = 150.0, 24.0  # s
CYCLE = ("motorway", "town", "motorway", "stops", "constant", "motorway", "town", "motorway", "stops", "slalom")
SPEEDS = {"town": 14.0, "stops": 18.0, "slalom": 14.0}  # m/s; others are drawn
ROADS = ("A", "B", "C", "A", "B", "C", "A", "B", "C", "D")
SLOW = 20.0  # m/s, at the most on class D


@dataclass(frozen=True)
class Drive:
    """stretches: what the sensors said, a second each, with the signals that the estimator reads; of the truth at
    20 Hz: time [s], acceleration [m/s^2], yaw rate [rad/s], (n,)."""

    stretches: list[Stretch]
    time: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    yaw_rate: NDArray[np.float64]


def scenario(seed: int, number: int, duration: float) -> Scenario:
    """Of repetition `number`."""
    own = run_seed(seed, number)
    rng = np.random.default_rng(own)
    manoeuvre, road = CYCLE[number % len(CYCLE)], str(rng.choice(ROADS))
    speed = SPEEDS.get(manoeuvre, float(rng.uniform(15.0, 35.0)))
    return Scenario(
        road=road, manoeuvre=manoeuvre, speed=min(speed, SLOW) if road == "D" else speed, duration=duration, seed=own,
        grade=float(rng.uniform(-0.06, 0.06)), bank=float(rng.uniform(-0.04, 0.04)),
        payload=float(rng.choice([0.0, 200.0, 400.0])), driven=str(rng.choice(["front", "rear"])),
        radius_factor={wheel: 1.0 + 0.002 * float(rng.standard_normal()) for wheel in WHEELS},
    )  # fmt: skip


def driven(asked: Scenario) -> Drive:
    """The whole drive. ValueError where it cannot be driven to its end."""
    heard = sensed(asked, Redundancy.reads)
    return Drive(heard.stretches, heard.time, np.gradient(heard.speed, heard.time), heard.yaw_rate)
