"""What a fault can sit on: a signal, one axis of a vector (`imu/accel/x`), or a wheel's sensor (`wheel/rr`: its tooth
edges and the speed computed from them). Numbers are typed in the unit shown here and are SI inside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from estimators.drive_log import WHEELS

AXES = ("x", "y", "z")
_DEGREE = math.pi / 180.0
# name with {} for a wheel -> unit as typed, its size in SI
UNITS: dict[str, tuple[str, float]] = {
    "imu/accel": ("m/s^2", 1.0),
    "imu/gyro": ("deg/s", _DEGREE),
    "steering/angle": ("deg", _DEGREE),
    "steering/motor_angle": ("deg", _DEGREE),
    "steering/motor_demand": ("deg", _DEGREE),
    "steering/pinion_angle": ("deg", _DEGREE),
    "engine/torque": ("N m", 1.0),
    "driveline/torque": ("N m", 1.0),
    "body/{}/accel_z": ("m/s^2", 1.0),
    "hub/{}/accel_z": ("m/s^2", 1.0),
    "wheel/{}": ("rad/s", 1.0),
    "wheel/{}/edges": ("rad/s", 1.0),
    "wheel/{}/speed": ("rad/s", 1.0),
    "tyre/{}/pressure": ("kPa", 1e3),
    "tyre/{}/temperature": ("K", 1.0),
}
_VECTORS = ("imu/accel", "imu/gyro")


@dataclass(frozen=True)
class Target:
    """name: as typed. signals: those that change. column: of a vector, None for all of it. wheel: "" for none. unit: as
    typed, scale: its size in SI."""

    name: str
    signals: tuple[str, ...]
    column: int | None
    wheel: str
    unit: str
    scale: float

    @property
    def turns(self) -> bool:
        """Whether it is a wheel's speed sensor."""
        return self.name.startswith("wheel/")


def known_targets() -> list[str]:
    """Every name, with WHEEL for fl fr rl rr and [/x|y|z] where an axis may follow."""
    return [f"{name.format('WHEEL')}{'[/x|y|z]' if name in _VECTORS else ''}" for name in UNITS]


def find_target(name: str) -> Target:
    """The target of that name. ValueError lists the valid ones."""
    column, base = None, name
    if base.rpartition("/")[0] in _VECTORS and base.rpartition("/")[2] in AXES:
        base, _, axis = base.rpartition("/")
        column = AXES.index(axis)
    wheel = next((part for part in base.split("/") if part in WHEELS), "")
    pattern = "/".join("{}" if part == wheel and wheel else part for part in base.split("/"))
    if pattern not in UNITS or (("{}" in pattern) != bool(wheel)):
        raise ValueError(f"no sensor is named {name!r}; valid: {', '.join(known_targets())}")
    signals = (f"{base}/edges", f"{base}/speed") if pattern == "wheel/{}" else (base,)
    return Target(name, signals, column, wheel, *UNITS[pattern])
