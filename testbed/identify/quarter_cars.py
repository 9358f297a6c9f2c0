"""python -m testbed.identify quarter-cars: the quarter cars that `vertical_pressure` starts from.

Straight drives of a minute on roads of their own, each with a level between half of class A's centre and one and a half
of class D's, 35 to 110 km/h, every tyre at its own pressure between 120 and 260 kPa: roads lie between classes, and a
car drives at other speeds than the paper's 40, 60 and 80 km/h (Brancati & Tufano, Machines 2022, 10, 1221, 5.2). Fits
one quarter car an axle (`estimators.vertical_pressure.identify`), sets its scale (`calibrate`) and writes the
estimator's calibration, by default the file in `models/` that every drive of this car starts from. Stiffness at a known
pressure is the tyre's law, as for a real car, not the simulator's truth. A quarter of an hour.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import AXLES, GRAVITY, Car
from estimators.drive_log import WHEELS
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.vertical_pressure.calibrate import calibrated
from estimators.vertical_pressure.corner import Corner, beside, maker_corner, to_document
from estimators.vertical_pressure.identify import KnownDrive, identify
from estimators.vertical_pressure.intake import BLOCK, HubIntake
from testbed.notes import known_car
from testbed.scenario import Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of, needed
from testbed.simulation import Simulation

LEVELS, SPEEDS, PRESSURES = (0.6e-6, 100e-6), (35.0 / 3.6, 110.0 / 3.6), (120e3, 260e3)  # m^3/rad at 1 rad/m, m/s, Pa
DRIVES, DURATION, FIRST_SEED = 90, 62.0, 9100  # s; seeds of their own, far from any study's


def decimated(hub: NDArray[np.float64]) -> NDArray[np.float64]:
    """As the estimator hears it: hub accelerations at 1 kHz, (n,) -> (n // 16,)."""
    intake = HubIntake()
    blocks = (intake.block(hub[k : k + BLOCK]) for k in range(0, len(hub) - BLOCK + 1, BLOCK))
    return np.concatenate([block for block in blocks if block is not None])


def drawn(seed: int, duration: float = DURATION) -> Scenario:
    """A tuning drive."""
    rng = np.random.default_rng(seed)
    level = float(np.exp(rng.uniform(*np.log(LEVELS)))) / (2.0 * np.pi * 0.01)
    speed = float(rng.uniform(*SPEEDS))
    pressures = dict(zip(WHEELS, rng.uniform(*PRESSURES, len(WHEELS)).tolist(), strict=True))
    return Scenario(road=f"gd={level:.6g}", speed=speed, duration=duration, seed=seed, pressures=pressures)


def known_drives(count: int = DRIVES, duration: float = DURATION) -> Iterator[tuple[str, KnownDrive]]:
    """(axle, drive of one wheel) of every drive; pressures are the means of the drive, which warms the tyres."""
    names = [f"hub/{wheel}/accel_z" for wheel in WHEELS]
    for seed in range(FIRST_SEED, FIRST_SEED + count):
        scenario = drawn(seed, duration)
        simulation = Simulation(scenario)
        suite = SensorSuite(needed(sensor_settings(scenario.sensors), names), seed, simulation)
        heard, pressure = [], []
        for stretch in simulation.stretches():
            heard.append(suite.advance(motion_of(stretch, scenario.step)))
            pressure.append(stretch["pressure"].mean(axis=0))
        car = known_car(simulation.vehicle, simulation.tyre, scenario)
        mean = np.mean(pressure, axis=0)
        for i, wheel in enumerate(WHEELS):
            hub = np.concatenate([signals[names[i]].value for signals in heard])
            load = sum(quarter_masses(car, wheel)) * GRAVITY
            stiffness = float(TyreLaw.of(car).stiffness_at(mean[i], scenario.speed, load))
            yield AXLES[i // 2], KnownDrive(decimated(np.asarray(hub, float)), stiffness, scenario.speed)


def corners(car: Car, drives: Sequence[tuple[str, KnownDrive]]) -> dict[str, Corner]:
    """One an axle."""
    maker = {axle: maker_corner(car, axle) for axle in AXLES}
    own = {axle: [drive for name, drive in drives if name == axle] for axle in AXLES}
    found = {
        axle: dataclasses.replace(corner, quarter=identify(corner.quarter, own[axle]).quarter)
        for axle, corner in maker.items()
    }
    return {axle: calibrated(found[axle].quarter, beside(car, found, axle), own[axle]) for axle in AXLES}


def document() -> dict[str, Any]:
    """The calibration of `vertical_pressure`, JSON values."""
    simulation = Simulation(Scenario(duration=1.0))
    car = known_car(simulation.vehicle, simulation.tyre, simulation.scenario)
    return to_document(corners(car, list(known_drives())))
