"""A repetition's car: what it is, what the estimators are told of it, and the days on which it is driven.

Drawn for each car
    tyres       radii unequal by up to 0.6 % (each within +-UNEQUAL of nominal)
    law         the tyre's pressure law off what the estimators believe: radius and torsional stiffness against pressure
                each by up to LAW_ERROR
    told        masses, lengths, inertias, drag of `estimators.car.Car`, each wrong by up to TOLD_ERROR
    filled      250 kPa at an ambient temperature of 0 to 40 C
and for each day
    road        level log-uniform from the centre of class A to that of class D
    driving     town (up to 60 km/h), country or motorway, 40 to 130 km/h
    radii       each tyre moved by up to DAY_DRIFT either way, so two against each other by up to 0.25 %
    ambient     within DAY_WARMTH of the day on which the tyres were filled; the pressure follows (ideal gas)
    payload     0 to 400 kg anywhere behind the front seats; grade, bank, wind with gusts
"""

from __future__ import annotations

from typing import Any

import numpy as np

from estimators.drive_log import WHEELS
from models.tyre_properties import load_tyre
from testbed.scenario import Scenario
from testbed.study.study import run_seed
from testbed.tyre.inflation import ATMOSPHERE

NOMINAL = 250e3  # Pa
UNEQUAL, DAY_DRIFT = 3e-3, 1.25e-3  # of a tyre's radius
LAW_ERROR, TOLD_ERROR = 0.2, 0.1
LEVELS = (16e-6, 1024e-6)  # m^3 at 0.1 cycle/m: centres of ISO 8608 classes A and D
SPEEDS = (40.0 / 3.6, 130.0 / 3.6)  # m/s
DRIVING = ("town", "country", "motorway")
AMBIENT = (273.15, 313.15)  # K
DAY_WARMTH = 5.0  # K
PAYLOAD, PAYLOAD_X, PAYLOAD_Y = 400.0, (-1.4, 0.2), 0.3  # kg, m
GRADE, BANK, WIND, GUSTS = 0.03, 0.03, 12.0, (0.1, 0.3)  # -, -, m/s, of the wind
TOLD = (
    "chassis_mass", "front_wheel_mass", "rear_wheel_mass", "cg_to_front_axle", "cg_to_rear_axle", "cg_height",
    "front_track", "rear_track", "front_wheel_inertia", "rear_wheel_inertia", "drag_area",
)  # fmt: skip


SERIES = 30_000  # added to a study's seed; cars of the study's default seed were never driven while anything was tuned


def own_seed(seed: int, number: int, purpose: int = 0) -> int:
    """`run_seed` of this study."""
    return run_seed(SERIES + seed, number, purpose)


class RepetitionCar:
    """Car `number` of a study's seed."""

    def __init__(self, seed: int, number: int) -> None:
        self._seed, self._number = seed, number
        rng = np.random.default_rng(own_seed(seed, number))
        self.seed = int(rng.integers(2**31))
        self.radii = 1.0 + rng.uniform(-UNEQUAL, UNEQUAL, 4)
        self.filled_at = float(rng.uniform(*AMBIENT))
        radius_law, torsion_law = rng.uniform(1.0 - LAW_ERROR, 1.0 + LAW_ERROR, 2)
        base = load_tyre().torsion_base
        self.tyre: dict[str, float] = {
            "re_pressure_share": float(radius_law),
            "torsion_base": float((1.0 - (1.0 - base) * torsion_law) / base),
        }
        errors = rng.uniform(1.0 - TOLD_ERROR, 1.0 + TOLD_ERROR, len(TOLD))
        self.believed: dict[str, Any] = dict(zip(TOLD, errors.tolist(), strict=True))

    def day(self, purpose: int, duration: float, **fields: Any) -> Scenario:
        """A drive of this car on a day of its own; purpose: number of the day. fields: of the scenario, instead."""
        seed = own_seed(self._seed, self._number, 1 + purpose)
        rng = np.random.default_rng(seed)
        drift = rng.uniform(-DAY_DRIFT, DAY_DRIFT, 4)
        ambient = float(np.clip(self.filled_at + rng.uniform(-DAY_WARMTH, DAY_WARMTH), *AMBIENT))
        level = float(np.exp(rng.uniform(*np.log(LEVELS))))
        drawn: dict[str, Any] = {
            "road": f"gd={level:.6g}",
            "manoeuvre": DRIVING[int(rng.integers(len(DRIVING)))],
            "speed": float(rng.uniform(*SPEEDS)),
            "payload": float(rng.uniform(0.0, PAYLOAD)),
            "payload_position": (float(rng.uniform(*PAYLOAD_X)), float(rng.uniform(-PAYLOAD_Y, PAYLOAD_Y)), 0.0),
            "grade": float(rng.uniform(-GRADE, GRADE)),
            "bank": float(rng.uniform(-BANK, BANK)),
            "wind": float(rng.uniform(0.0, WIND)),
            "wind_from": float(rng.uniform(-np.pi, np.pi)),
            "gusts": float(rng.uniform(*GUSTS)),
            "ambient": ambient,
            "radius_factor": dict(zip(WHEELS, (self.radii + drift).tolist(), strict=True)),
            "pressures": dict.fromkeys(WHEELS, self.pressure_at(ambient)),
        }  # fmt: skip
        return Scenario(**(drawn | {"duration": duration, "seed": seed, "car_seed": self.seed} | fields))

    def pressure_at(self, ambient: float) -> float:
        """Gauge pressure of a cold tyre [Pa] that was filled to nominal, at an ambient temperature [K]."""
        return (NOMINAL + ATMOSPHERE) * ambient / self.filled_at - ATMOSPHERE
