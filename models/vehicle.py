"""The vehicle's numbers: chassis, two axles, driveline, active steering, from a TOML file in which each has a source.

All SI, in the car's axes (ISO 8855: x forward, y left, z up; origin at the chassis' centre of gravity).
"""

from __future__ import annotations

import dataclasses
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

GRAVITY = 9.81  # m/s^2
AIR_DENSITY = 1.204  # kg/m^3 at 20 C and 101.3 kPa
RIM_RADIUS = 0.2286  # m, 18 inch: the car's rims
SUV = Path(__file__).with_name("suv.toml")


@dataclass(frozen=True)
class Chassis:
    """Body: kg, m, kg m^2, m^2; side_force_slope [1/rad] of the wind's side force, pressure_point [m] ahead of the
    centre of gravity where it acts."""

    mass: float
    cg_to_front_axle: float
    cg_to_rear_axle: float
    cg_height: float
    roll_inertia: float
    pitch_inertia: float
    yaw_inertia: float
    frontal_area: float
    drag_coefficient: float
    side_force_slope: float
    pressure_point: float


@dataclass(frozen=True)
class Axle:
    """One axle, its suspension rates at the wheel and its wheels; meanings and units in the TOML file."""

    track: float
    wheel_assembly_mass: float
    rotating_mass: float
    spin_inertia: float
    spring_rate: float
    spring_progression: float
    damping_rebound: float
    damping_compression: float
    bump_clearance: float
    rebound_clearance: float
    stop_rate: float
    anti_roll_rate: float
    axis_lateral: float
    axis_forward: float
    camber_static: float
    camber_gain: float
    toe_static: float
    toe_gain: float
    hub_stiffness: float
    hub_damping_ratio: float
    steer_stiffness: float
    steer_damping_ratio: float
    brake_share: float


@dataclass(frozen=True)
class Driveline:
    """Engine, gearbox, brakes and steering ratio."""

    steering_ratio: float
    gear_ratios: tuple[float, ...]
    upshift_speeds: tuple[float, ...]
    max_engine_torque: float
    max_engine_power: float
    efficiency: float
    overrun_torque: float
    max_brake_torque: float


@dataclass(frozen=True)
class ActiveSteering:
    """Superposition gear, motor and control of an active front steering; meanings and units in the TOML file."""

    rack_ratio: float
    rack_stop: float
    wheel_ratio: float
    motor_ratio: float
    ratio_speeds: tuple[float, ...]
    ratios: tuple[float, ...]
    motor_inertia: float
    motor_friction: float
    motor_damping: float
    torque_constant: float
    resistance: float
    supply_voltage: float
    largest_current: float
    current_lag: float
    position_gain: float
    velocity_gain: float
    velocity_integral: float
    largest_speed: float
    demand_lag: float
    speed_lag: float
    assist_share: float
    lock_delay: float


@dataclass(frozen=True)
class Payload:
    """A mass fixed to the body. kg; position [m] of its centre from the chassis' centre of gravity; box edges [m]."""

    mass: float = 0.0
    position: tuple[float, float, float] = (-0.6, 0.0, 0.0)
    size: tuple[float, float, float] = (1.0, 1.0, 0.4)


@dataclass(frozen=True)
class Vehicle:
    """The whole car. Axles are ordered front, rear; wheels fl fr rl rr."""

    chassis: Chassis
    front: Axle
    rear: Axle
    driveline: Driveline
    active_steering: ActiveSteering  # of the cars that have it

    @property
    def wheelbase(self) -> float:
        return self.chassis.cg_to_front_axle + self.chassis.cg_to_rear_axle

    @property
    def axles(self) -> tuple[Axle, Axle, Axle, Axle]:
        """The axle of each wheel, fl fr rl rr."""
        return (self.front, self.front, self.rear, self.rear)

    @property
    def mass(self) -> float:
        """Whole car without payload [kg]."""
        return self.chassis.mass + 2.0 * (self.front.wheel_assembly_mass + self.rear.wheel_assembly_mass)

    def static_sprung_load(self) -> tuple[float, float]:
        """Weight that the body lays on one front and one rear suspension, without payload [N]."""
        weight = self.chassis.mass * GRAVITY / (2.0 * self.wheelbase)
        return weight * self.chassis.cg_to_rear_axle, weight * self.chassis.cg_to_front_axle

    def static_wheel_load(self) -> tuple[float, float]:
        """Load of one front and one rear wheel at rest, without payload [N]."""
        front, rear = self.static_sprung_load()
        return front + self.front.wheel_assembly_mass * GRAVITY, rear + self.rear.wheel_assembly_mass * GRAVITY


def joint_damping(axle: Axle) -> float:
    """Damping of the travel joint [N s/m]: half of the damper's mean, see `testbed.suspension`."""
    return 0.25 * (axle.damping_compression + axle.damping_rebound)


Part = TypeVar("Part", Chassis, Axle, Driveline, ActiveSteering)


def _part(kind: type[Part], table: dict[str, Any], where: str) -> Part:
    names = {f.name for f in dataclasses.fields(kind)}
    if set(table) != names:
        odd = ", ".join(sorted(set(table) ^ names))
        raise ValueError(f"{where}: missing or unknown {odd}; want exactly {', '.join(sorted(names))}")
    values: dict[str, Any] = {}
    for name, entry in table.items():
        if not isinstance(entry, dict) or set(entry) != {"value", "unit", "source"}:
            raise ValueError(f"{where}: {name} needs value, unit and source, has {entry}")
        values[name] = tuple(entry["value"]) if isinstance(entry["value"], list) else entry["value"]
    return kind(**values)


def load_vehicle(path: Path = SUV) -> Vehicle:
    """The vehicle of a TOML file like `suv.toml`. ValueError names a missing, unknown or sourceless number."""
    with path.open("rb") as file:
        data = tomllib.load(file)
    kinds: dict[str, Any] = {
        "chassis": Chassis, "front": Axle, "rear": Axle, "driveline": Driveline, "active_steering": ActiveSteering,
    }  # fmt: skip
    missing = set(kinds) - set(data)
    if missing:
        raise ValueError(f"{path}: no section {', '.join(sorted(missing))}")
    vehicle = Vehicle(**{name: _part(kind, data[name], f"{path.name} [{name}]") for name, kind in kinds.items()})
    _check_inertia(vehicle, path.name)
    return vehicle


def _check_inertia(vehicle: Vehicle, where: str) -> None:
    """ValueError for inertias that no body can have."""
    body = vehicle.chassis
    roll, pitch, yaw = body.roll_inertia, body.pitch_inertia, body.yaw_inertia
    if not (roll <= pitch + yaw and pitch <= roll + yaw and yaw <= roll + pitch):
        raise ValueError(
            f"{where}: inertias {roll:g}, {pitch:g}, {yaw:g} kg m^2: none may exceed the sum of the others"
        )
    for axle in (vehicle.front, vehicle.rear):
        if axle.spin_inertia > axle.rotating_mass * RIM_RADIUS**2:
            raise ValueError(
                f"{where}: spin_inertia {axle.spin_inertia:g} kg m^2 is more than {axle.rotating_mass:g} kg within "
                f"{RIM_RADIUS:g} m can have"
            )
