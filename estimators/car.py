"""The car as its maker knows it: geometry, masses and constants that an estimator may use.

Defaults: the Segment-D SUV of Brancati & Tufano, Machines 2022, 10, 1221, Table 1; where that table is silent the value
is declared beside the field. A drive log carries its own car in `notes["car"]`, with the field names below.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

GRAVITY = 9.81  # m/s^2
AIR_DENSITY = 1.2  # kg/m^3
DRIVEN = ("front", "rear", "all")
AXLES = ("front", "rear")
_MAY_BE_ZERO = (
    "drag_area", "front_wheel_inertia", "rear_wheel_inertia", "radius_sensitivity_relative_std",
    "tyre_stiffness_per_speed", "tyre_stiffness_per_load", "motor_gear_ratio",
)  # fmt: skip


@dataclass(frozen=True)
class Car:
    """Lengths [m], masses [kg], inertias [kg m^2]; front means both front wheels are alike."""

    cg_to_front_axle: float = 1.347
    cg_to_rear_axle: float = 1.471
    cg_height: float = 0.6
    front_track: float = 1.606
    rear_track: float = 1.6364
    chassis_mass: float = 1788.0
    front_wheel_mass: float = 61.14  # one wheel assembly
    rear_wheel_mass: float = 52.75
    rolling_radius: float = 0.36  # nominal effective radius, declared: 235/60R18
    front_wheel_inertia: float = 1.6  # about the hub: rim, disc, tyre; declared
    rear_wheel_inertia: float = 1.8  # declared
    ring_teeth: float = 48.0  # of each wheel's speed sensor
    steering_ratio: float = 16.0  # steering-wheel angle per road-wheel angle, declared
    wheel_gear_ratio: float = 1.0  # steering-wheel angle per pinion angle while an active steering's motor stands
    motor_gear_ratio: float = 0.0  # that motor's angle per pinion angle; 0: no active steering
    driven_axle: str = "front"
    drag_area: float = 0.9625  # drag coefficient 0.35 (declared) times frontal area 2.75 m^2
    pressure: float = 250e3  # nominal, gauge [Pa]
    radius_sensitivity: float = 4e-8  # d ln(effective radius) / d pressure [1/Pa], mean of real cars
    radius_sensitivity_relative_std: float = 0.4  # real cars spread by that much
    front_spring_rate: float = 38e3  # at the wheel, design load [N/m], declared
    rear_spring_rate: float = 40e3
    front_damping: float = 3e3  # at the wheel, mean of compression and rebound [N s/m], declared
    rear_damping: float = 3e3
    tyre_belt_mass: float = 9.13  # what moves with the belt [kg], declared: a published tyre, scaled
    tyre_footprint: float = 0.116  # distance of the two cams that feel the road [m], declared, same source
    tyre_stiffness: float = 264.7e3  # vertical, at nominal pressure and rest, mean static load [N/m]
    tyre_stiffness_per_pressure: float = 0.654  # relative, per relative change of gauge pressure
    tyre_stiffness_per_speed: float = 2.57e-3  # relative, per m/s
    tyre_stiffness_per_load: float = 0.083  # relative, per relative change of load; these three: declared, MF 6.1

    def __post_init__(self) -> None:
        if self.driven_axle not in DRIVEN:
            raise ValueError(f"car driven_axle is {self.driven_axle!r}, valid: {', '.join(DRIVEN)}")
        for field in fields(self):
            if field.name == "driven_axle":
                continue
            value = getattr(self, field.name)
            number = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
            if not number or value < 0.0 or (value == 0.0 and field.name not in _MAY_BE_ZERO):
                raise ValueError(f"car {field.name} is {value!r}, valid: a finite number above 0, SI units")

    @property
    def wheelbase(self) -> float:
        """Front to rear axle [m]."""
        return self.cg_to_front_axle + self.cg_to_rear_axle

    @property
    def mass(self) -> float:
        """Chassis and four wheels [kg]."""
        return self.chassis_mass + 2.0 * (self.front_wheel_mass + self.rear_wheel_mass)

    @classmethod
    def from_notes(cls, notes: Mapping[str, Any]) -> Car:
        """The car that `notes["car"]` describes, defaults where it is silent. ValueError in one line if it makes no
        sense.
        """
        given = notes.get("car", {})
        if not isinstance(given, Mapping):
            raise ValueError(f"notes['car'] is {given!r}, valid: a mapping of {', '.join(f.name for f in fields(cls))}")
        known = {f.name for f in fields(cls)}
        for name in given:
            if name not in known:
                raise ValueError(f"car has no field {name!r}, valid: {', '.join(sorted(known))}")
        return cls(**given)
