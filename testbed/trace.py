"""The trace: what the loop writes down at every step, one row a step, as named columns of one array."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from testbed.tyre.contact import OUTPUT

# name, number of columns, unit; wheels in the order fl fr rl rr
LAYOUT: tuple[tuple[str, int, str], ...] = (
    ("time", 1, "s"),
    ("position", 3, "m"),  # chassis centre of gravity, world
    ("quaternion", 4, ""),  # chassis, w x y z
    ("velocity", 3, "m/s"),  # chassis centre of gravity, world
    ("accel", 3, "m/s^2"),  # specific force at the centre of gravity, body axes
    ("gyro", 3, "rad/s"),  # body axes
    ("body_accel_z", 4, "m/s^2"),
    ("hub_accel_z", 4, "m/s^2"),
    ("rim_angle", 4, "rad"),  # against the knuckle, unbounded
    ("rim_speed", 4, "rad/s"),
    ("belt_speed", 4, "rad/s"),  # absolute, about the spin axis
    ("travel", 4, "m"),
    ("steering_wheel", 1, "rad"),
    ("engine_torque", 1, "N m"),
    ("driveline_torque", 1, "N m"),
    ("path_error", 1, "m"),
    ("pressure", 4, "Pa"),  # gauge
    ("temperature", 4, "K"),
    *((name, 4, unit) for name, unit in zip(
        OUTPUT, ("N", "m", "N/m", "", "rad", "N", "N", "N m", "N m", "m", "m", "W", "W"), strict=True)),
    ("motor_angle", 1, "rad"),  # active steering, zero without; the motor's, by which the pinion is superposed
    ("motor_speed", 1, "rad/s"),
    ("motor_torque", 1, "N m"),
    ("motor_demand", 1, "rad"),
    ("pinion_angle", 1, "rad"),
    ("road_wheel_angle", 1, "rad"),  # F_SG of the pinion's
    ("motor_locked", 1, ""),
    ("work", 6, "J"),  # since the start, see WORK
)  # fmt: skip
WORK = ("air", "slip", "rolling", "brake", "drive", "strut")  # energy taken from the car (drive: given to it)

COLUMNS: dict[str, slice] = {}
_at = 0
for _name, _width, _unit in LAYOUT:
    COLUMNS[_name] = slice(_at, _at + _width)
    _at += _width
WIDTH = _at

UNITS = {name: unit for name, _, unit in LAYOUT}


def column(rows: NDArray[np.float64], name: str) -> NDArray[np.float64]:
    """A named quantity of a trace, shape (n,) when it is one column, else (n, k)."""
    block = rows[:, COLUMNS[name]]
    return block[:, 0] if block.shape[1] == 1 else block
