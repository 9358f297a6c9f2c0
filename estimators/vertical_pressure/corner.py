"""What is known of each axle's corner: the maker's numbers, or those identified on drives at known pressures.

A document of an identified car has for "front" and "rear" the fields of `Quarter` and `stiffness_std`, the relative
standard deviation that is left of k_t however long one drives. It may have `tyres`: the `pressure` and `pressure_std`
[Pa] that are expected before anything was heard, where more is known than that tyres in use are about nominal.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from estimators.car import AXLES, Car
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.vertical_pressure.chain import Quarter
from estimators.vertical_pressure.hub_spectrum import Beside

SOFTER = 0.6  # contact length over stiffness at one load: MF 6.1, between its square root and its linear term
ROLL_GYRATION = 0.39  # of the track: SUVs in NHTSA's inertia tables lie at 0.38 to 0.42
HUB_ERROR = 0.005  # Declared: the model explains all but half a per cent of what is new in a sample
USUAL_STD = 0.25  # of nominal pressure. Declared: tyres in use, leaks among them
TYRES, EXPECTED = "tyres", ("pressure", "pressure_std")
MAKER_STD = 0.03  # Declared: springs, masses and footprint of a maker's drawing make k_t that uncertain


@dataclass(frozen=True)
class Corner:
    """quarter: see there; stiffness_std: relative, systematic."""

    quarter: Quarter
    stiffness_std: float


def maker_corner(car: Car, axle: str) -> Corner:
    """From the car's drawing; axle `front` or `rear`."""
    sprung, unsprung = quarter_masses(car, "fl" if axle == "front" else "rl")
    rate, damping = (
        (car.front_spring_rate, car.front_damping) if axle == "front" else (car.rear_spring_rate, car.rear_damping)
    )
    quarter = Quarter(
        sprung_mass=sprung,
        unsprung_mass=unsprung - car.tyre_belt_mass,
        belt_mass=car.tyre_belt_mass,
        spring_rate=rate,
        damping=damping,
        footprint=car.tyre_footprint,
        softer=SOFTER,
        hub_error=HUB_ERROR,
    )
    return Corner(quarter, MAKER_STD)


def beside(car: Car, corners: Mapping[str, Corner], axle: str) -> Beside:
    """The other axle as a corner of `axle` feels it: by the car's drawing, the roll inertia M (`ROLL_GYRATION` track)^2
    alone, since pitch and heave of a car with pitch inertia M a b leave the other axle at rest."""
    front = axle == "front"
    track = 0.5 * (car.front_track + car.rear_track)
    coupling = 0.25 / (ROLL_GYRATION**2 * car.chassis_mass)
    other = corners["rear" if front else "front"].quarter
    return Beside(other, coupling, car.wheelbase if front else -car.wheelbase, track)


def from_document(document: Mapping[str, Any]) -> dict[str, Corner]:
    """Corners by axle. ValueError names what is wrong."""
    names = (*Quarter._fields, "stiffness_std")
    if set(document) - {TYRES} != set(AXLES):
        raise ValueError(f"calibration has {sorted(document)}, valid: {', '.join(AXLES)}, both, and {TYRES}")
    corners = {}
    for axle in AXLES:
        entry = document[axle]
        if not isinstance(entry, Mapping) or set(entry) != set(names):
            raise ValueError(f"calibration of {axle} is {entry!r}, valid: {', '.join(names)}, all of them")
        _check_numbers(axle, entry)
        corners[axle] = Corner(Quarter(*(float(entry[n]) for n in Quarter._fields)), float(entry["stiffness_std"]))
    return corners


def expected_pressure(car: Car, document: Mapping[str, Any]) -> tuple[float, float]:
    """Mean and std [Pa] before anything was heard. ValueError names what is wrong."""
    entry = document.get(TYRES)
    if entry is None:
        return car.pressure, USUAL_STD * car.pressure
    if not isinstance(entry, Mapping) or set(entry) != set(EXPECTED):
        raise ValueError(f"calibration of {TYRES} is {entry!r}, valid: {', '.join(EXPECTED)}, both of them")
    _check_numbers(TYRES, entry)
    return float(entry["pressure"]), float(entry["pressure_std"])


def _check_numbers(what: str, entry: Mapping[str, Any]) -> None:
    for name, value in entry.items():
        number = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
        if not number or value <= 0.0:
            raise ValueError(f"calibration of {what}: {name} is {value!r}, valid: a finite number above 0")


def to_document(corners: Mapping[str, Corner]) -> dict[str, Any]:
    """The inverse of `from_document`."""
    return {axle: c.quarter._asdict() | {"stiffness_std": c.stiffness_std} for axle, c in corners.items()}
