"""What the estimators are told of the car: rightly, or with every number off.

Right: the maker's car, the identified quarter cars of `models/` (by axle for the bank, by axle and road class for the
published filters), and that pressures lie between 130 and 230 kPa, which the published filters' P0 says in its own way.
Wrong, for the second table: each of these off by its own factor, uniform within

    masses, suspension stiffness and damping, footprint, lengths     TOLD_ERROR
    slope of the tyre's pressure law                                 LAW_ERROR

The unsprung mass is the one that matters: with the road unknown a hop frequency tells k_t / m_us, so m_us 10 % off is
k_t 10 % off. Identified at known pressures, on the same law, it is not off by that much; a drawing's may be. `axles` is
told how wrong its numbers may be, as a user knows it who has them from a data sheet.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimators.car import AXLES, Car
from estimators.quarter_car.quarter_car import QuarterCar, quarter_masses
from models.identified import identified, identified_by_class

CLASSES = "ABCD"
LOWEST, HIGHEST = 130e3, 230e3  # Pa, Table 4
EXPECTED, EXPECTED_STD = 0.5 * (LOWEST + HIGHEST), (HIGHEST - LOWEST) / math.sqrt(12.0)  # of that uniform distribution
TOLD_ERROR, LAW_ERROR = 0.1, 0.2
CAR_FIELDS = (
    "cg_to_front_axle", "cg_to_rear_axle", "cg_height", "front_track", "rear_track", "chassis_mass",
    "front_wheel_mass", "rear_wheel_mass", "front_spring_rate", "rear_spring_rate", "front_damping", "rear_damping",
    "tyre_belt_mass", "tyre_footprint",
)  # fmt: skip
CORNER_FIELDS = ("sprung_mass", "unsprung_mass", "belt_mass", "spring_rate", "damping", "footprint")
QUARTER_FIELDS = ("damping", "quadratic_damping", "spring_rate", "spring_progression")


@dataclass(frozen=True)
class Told:
    """calibrations: by estimator; quarters: by axle and class."""

    car: Car
    calibrations: Mapping[str, Mapping[str, Any]]
    quarters: Mapping[str, Mapping[str, QuarterCar]]


def right(car: Car) -> Told:
    """car: as its maker knows it."""
    tyres = {"pressure": EXPECTED, "pressure_std": EXPECTED_STD}
    calibrations = {name: dict(document) | {"tyres": tyres} for name, document in identified().items()}
    return Told(car, calibrations, _quarters(car, {}))


def wrong(car: Car, seed: int) -> Told:
    """The same with factors drawn from the seed."""
    rng = np.random.default_rng(seed)

    def factors(names: tuple[str, ...]) -> dict[str, float]:
        drawn = rng.uniform(1.0 - TOLD_ERROR, 1.0 + TOLD_ERROR, len(names))
        return dict(zip(names, drawn.tolist(), strict=True))

    by_car = factors(CAR_FIELDS)
    by_car["tyre_stiffness_per_pressure"] = float(rng.uniform(1.0 - LAW_ERROR, 1.0 + LAW_ERROR))
    told_car = dataclasses.replace(car, **{name: getattr(car, name) * by for name, by in by_car.items()})
    by_axle = {axle: factors(CORNER_FIELDS) for axle in AXLES}
    sound = right(car)
    wheelbase = float(rng.uniform(1.0 - TOLD_ERROR, 1.0 + TOLD_ERROR))
    calibrations = {name: _off(document, by_axle, wheelbase) for name, document in sound.calibrations.items()}
    calibrations["axles"] |= {"told_std": TOLD_ERROR / math.sqrt(3.0), "law_std": LAW_ERROR / math.sqrt(3.0)}
    by_quarter = {axle: factors(("sprung_mass", "unsprung_mass", *QUARTER_FIELDS)) for axle in AXLES}
    return Told(told_car, calibrations, _quarters(car, by_quarter))


def _off(document: Mapping[str, Any], by_axle: Mapping[str, Mapping[str, float]], wheelbase: float) -> dict[str, Any]:
    """A calibration whose axles' numbers and wheelbase, if it has one, are multiplied."""
    found = {name: value * wheelbase if name == "wheelbase" else value for name, value in document.items()}
    for axle, by in by_axle.items():
        if isinstance(document.get(axle), Mapping):
            found[axle] = {name: value * by.get(name, 1.0) for name, value in document[axle].items()}
    return found


def _quarters(car: Car, by_axle: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, QuarterCar]]:
    learnt, found = identified_by_class(), {}
    for axle, wheel in zip(AXLES, ("fl", "rl"), strict=True):
        by = by_axle.get(axle, {})
        sprung, unsprung = quarter_masses(car, wheel)
        masses = {
            "sprung_mass": sprung * by.get("sprung_mass", 1.0), "unsprung_mass": unsprung * by.get("unsprung_mass", 1.0)
        }  # fmt: skip
        found[axle] = {
            road: QuarterCar(
                **masses, **{name: learnt[axle][road][name] * by.get(name, 1.0) for name in QUARTER_FIELDS}
            )
            for road in CLASSES
        }
    return found
