"""python -m testbed.identify published: quarter cars by road class, as the IMM of unscented filters wants.

Brancati & Tufano, Machines 2022, 10, 1221, 5.2: for each class A to D, nine drives of the multibody car (40, 60, 80
km/h by 130, 180, 230 kPa, straight on) over a known road, and the nonlinear quarter car that follows both accelerations
of a wheel best (`estimators.unscented_imm.identify`). The paper has one quarter car; here front and rear are fitted
apart, each on its left wheel. The road that is given is the height that the tyre's contact feels; stiffness is the
tyre's law at the known pressure. Accelerations are the simulator's own, without the sensors' noise, as in the paper.
Writes, by axle and class, c, c2, k, k3 and the 18 objectives; by default the file in `models/` that the study
`vertical-pressure` takes its modes from. Some ten minutes.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from estimators.car import AXLES, GRAVITY
from estimators.drive_log import WHEELS
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.unscented_imm.identify import SEARCHED, KnownCase, identify
from testbed.notes import known_car
from testbed.scenario import Scenario
from testbed.simulation import Simulation

CLASSES, SPEEDS, PRESSURES = "ABCD", (40.0, 60.0, 80.0), (130e3, 180e3, 230e3)  # km/h, Pa
DURATION, FIRST_SEED = 8.0, 9800  # s; seeds of their own, far from any study's


def known_case(road: str, kmh: float, pressure: float, seed: int, duration: float = DURATION) -> dict[str, KnownCase]:
    """One drive, by axle."""
    scenario = Scenario(
        road=road, speed=kmh / 3.6, duration=duration, seed=seed, pressures=dict.fromkeys(WHEELS, pressure)
    )
    simulation = Simulation(scenario)
    stretches = list(simulation.stretches())
    car = known_car(simulation.vehicle, simulation.tyre, scenario)
    found = {}
    for axle, wheel in zip(AXLES, ("fl", "rl"), strict=True):
        w = WHEELS.index(wheel)
        columns = {
            name: np.concatenate([s[name][:, w] for s in stretches])
            for name in ("road_height", "body_accel_z", "hub_accel_z")
        }
        height = columns["road_height"]
        at = np.arange(2 * len(height) - 1) / 2.0
        load = sum(quarter_masses(car, wheel)) * GRAVITY
        found[axle] = KnownCase(
            road=np.interp(at, np.arange(len(height)), height),
            tyre_stiffness=float(TyreLaw.of(car).stiffness_at(pressure, scenario.speed, load)),
            measured=np.stack([columns["body_accel_z"], columns["hub_accel_z"]], axis=1) - GRAVITY,
            step=scenario.step,
        )
    return found


def fitted(road: str, first_seed: int, duration: float = DURATION) -> dict[str, dict[str, Any]]:
    """JSON values of one class, by axle."""
    cases = [
        known_case(road, kmh, pressure, seed, duration)
        for seed, (kmh, pressure) in enumerate(itertools.product(SPEEDS, PRESSURES), first_seed)
    ]
    simulation = Simulation(Scenario(duration=1.0))
    car = known_car(simulation.vehicle, simulation.tyre, simulation.scenario)
    found = {}
    for axle, wheel in zip(AXLES, ("fl", "rl"), strict=True):
        best = identify(*quarter_masses(car, wheel), [case[axle] for case in cases], first_seed)
        values = best.quarter._asdict()
        found[axle] = {name: values[name] for name in SEARCHED} | {
            "error_body": best.errors[:, 0].tolist(), "error_hub": best.errors[:, 1].tolist(),
        }  # fmt: skip
    return found


def document() -> dict[str, Any]:
    """By axle and class, JSON values."""
    each = len(SPEEDS) * len(PRESSURES)
    by_class = {road: fitted(road, FIRST_SEED + each * i) for i, road in enumerate(CLASSES)}
    return {axle: {road: by_class[road][axle] for road in CLASSES} for axle in AXLES}
