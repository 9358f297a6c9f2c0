"""Drives of sound cars, on which the alarm's threshold is set and its false alarms are counted: not the study's own.

A car: driven axle, tyres unequal by up to 0.6 % in radius, `estimators.car.Car` told to the estimators with masses,
lengths, inertias and drag wrong by up to TOLD_ERROR, a calibration drive of CALIBRATION on country road or motorway
with up to PAYLOAD_BEFORE on board. Then drives of DURATION on other days: road level log-uniform from the centre of
class A to that of D, all manoeuvres that are ordinary driving, 40 to 130 km/h, friction 1.0 to 0.2, payload to 400 kg
anywhere from the front seats to behind the rear axle, grade, bank, gusting wind, 0 to 40 C with the pressures
following.

Not in it: radii that move by 0.25 % from one day to the next, as one car's did. That is what a loss of 25 % does, and
nothing in the radii tells the two apart; `estimators.itpms` has them in its model, this alarm does not.

A drive is kept as the cells of a tenth of a second that the estimator makes of its signals, which is all that it reads.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from estimators.car import Car
from estimators.drive_log import WHEELS
from estimators.grid import Cells, Grid
from estimators.runner import FLUSH
from estimators.wheel_radius.motion import CHANNELS
from estimators.wheel_radius.wheel_radius import STEP
from testbed.campaign.variants import believed_car
from testbed.scenario import Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of, needed
from testbed.simulation import Simulation, Stretch
from testbed.study.study import run_seed

CALIBRATION, DURATION = 400.0, 600.0  # s
UNEQUAL, TOLD_ERROR = 3e-3, 0.1
TOLD = (
    "chassis_mass", "front_wheel_mass", "rear_wheel_mass", "cg_to_front_axle", "cg_to_rear_axle", "cg_height",
    "front_track", "rear_track", "front_wheel_inertia", "rear_wheel_inertia", "drag_area",
)  # fmt: skip
LEVELS = (16e-6, 1024e-6)  # m^3 at 0.1 cycle/m: centres of ISO 8608 classes A and D
SPEEDS = (40.0 / 3.6, 130.0 / 3.6)  # m/s
DRIVING = ("town", "country", "motorway", "constant", "slalom", "stops")
FRICTIONS, OFTEN = ("1.0", "0.8", "0.6", "0.4", "0.2"), (0.6, 0.1, 0.1, 0.1, 0.1)
PAYLOAD_BEFORE, PAYLOAD, PAYLOAD_X, PAYLOAD_Y = 200.0, 400.0, (-1.8, 0.2), 0.3  # kg, kg, m, m
GRADE, BANK, WIND = 0.03, 0.03, 12.0  # -, -, m/s
AMBIENT, DAY_WARMTH = (273.15, 313.15), 5.0  # K
NOMINAL, ATMOSPHERE = 250e3, 101325.0  # Pa


class SoundCar:
    """Car `number` of a seed."""

    def __init__(self, seed: int, number: int) -> None:
        self._seed, self._number = seed, number
        rng = np.random.default_rng(run_seed(seed, number))
        self.driven = ("front", "rear", "all")[int(rng.choice(3, p=(0.6, 0.2, 0.2)))]
        self.seed = int(rng.integers(2**31))
        self.radii = dict(zip(WHEELS, (1.0 + rng.uniform(-UNEQUAL, UNEQUAL, 4)).tolist(), strict=True))
        self.filled_at = float(rng.uniform(*AMBIENT))
        errors = rng.uniform(1.0 - TOLD_ERROR, 1.0 + TOLD_ERROR, len(TOLD))
        self.believed: dict[str, Any] = dict(zip(TOLD, errors.tolist(), strict=True))

    def calibration(self) -> Scenario:
        """The drive on which the estimator learns the car."""
        fields = self._drawn(0, PAYLOAD_BEFORE)
        rng = np.random.default_rng(run_seed(self._seed, self._number, 1000))
        fields["manoeuvre"] = ("country", "motorway")[int(rng.integers(2))]
        fields["speed"] = float(rng.uniform(70.0 / 3.6, 110.0 / 3.6))
        return Scenario(**(fields | {"friction": "1.0", "duration": CALIBRATION}))

    def day(self, number: int, **fields: Any) -> Scenario:
        """Drive `number`, from 0. fields: of the scenario, instead of those drawn."""
        return Scenario(**(self._drawn(1 + number, PAYLOAD) | {"duration": DURATION} | fields))

    def _drawn(self, purpose: int, payload: float) -> dict[str, Any]:
        seed = run_seed(self._seed, self._number, 1 + purpose)
        rng = np.random.default_rng(seed)
        ambient = float(np.clip(self.filled_at + rng.uniform(-DAY_WARMTH, DAY_WARMTH), *AMBIENT))
        pressure = (NOMINAL + ATMOSPHERE) * ambient / self.filled_at - ATMOSPHERE
        return {
            "road": f"gd={float(np.exp(rng.uniform(*np.log(LEVELS)))):.6g}",
            "manoeuvre": DRIVING[int(rng.integers(len(DRIVING)))],
            "speed": float(rng.uniform(*SPEEDS)),
            "friction": str(rng.choice(FRICTIONS, p=OFTEN)),
            "driven": self.driven,
            "payload": float(rng.uniform(0.0, payload)),
            "payload_position": (float(rng.uniform(*PAYLOAD_X)), float(rng.uniform(-PAYLOAD_Y, PAYLOAD_Y)), 0.0),
            "grade": float(rng.uniform(-GRADE, GRADE)),
            "bank": float(rng.uniform(-BANK, BANK)),
            "wind": float(rng.uniform(0.0, WIND)),
            "wind_from": float(rng.uniform(-np.pi, np.pi)),
            "gusts": float(rng.uniform(0.1, 0.3)),
            "ambient": ambient,
            "radius_factor": self.radii,
            "pressures": dict.fromkeys(WHEELS, pressure),
            "seed": seed,
            "car_seed": self.seed,
        }  # fmt: skip


def driven_cells(scenario: Scenario) -> Cells:
    """The cells of a drive. A car that leaves the road or tips ends it early."""
    simulation = Simulation(scenario)
    reads = {channel.signal for channel in CHANNELS}
    settings = needed(sensor_settings(scenario.sensors), reads)
    suite = SensorSuite(settings, scenario.seed, simulation, car_seed=scenario.car_seed)
    grid, parts, end = Grid(CHANNELS, STEP), [], 0.0
    stretches: Iterator[Stretch] = simulation.stretches()
    while True:
        try:
            stretch = next(stretches, None)
        except ValueError:  # it says that the drive diverged
            stretch = None
        if stretch is None:
            break
        end = float(stretch["time"][-1]) + scenario.step
        grid.add(suite.advance(motion_of(stretch, scenario.step)))
        parts.append(grid.close(end)[0])
    parts.append(grid.close(end + FLUSH)[0])
    return Cells(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in dataclasses.fields(Cells)))


def told(scenario: Scenario, car: SoundCar) -> Car:
    """What the estimators are told of it."""
    return believed_car(scenario, car.believed)
