"""True motion of the car, as the simulation hands it to the sensors: one row a millisecond.

Rows lie on the grid time = k / 1000 s, k a whole number; consecutive chunks continue that grid without gap or overlap.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

STEPS_PER_SECOND = 1000.0
_OFF_GRID = 1e-7  # s; a sum of a million steps of 1 ms is off by less, a wrong step by more

# columns of each field, 0: a scalar of shape (n,)
WIDTHS = {
    "time": 0, "accel_cg": 3, "gyro": 3, "body_accel_z": 4, "hub_accel_z": 4, "rim_angle": 4, "rim_speed": 4,
    "steering_wheel_angle": 0, "engine_torque": 0, "driveline_torque": 0, "tyre_pressure": 4, "tyre_temperature": 4,
    "motor_angle": 0, "motor_demand": 0, "pinion_angle": 0,
}  # fmt: skip

_ACTIVE_STEERING = ("motor_angle", "motor_demand", "pinion_angle")

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Motion:
    """A chunk of n steps. Wheels in the order fl fr rl rr. ValueError on a wrong shape, a NaN or a time off the grid.

    time: [s], shape (n,). accel_cg: specific force at the centre of gravity, gravity's reaction included (+9.81 up at
    rest), body axes [m/s^2], shape (n, 3). gyro: angular velocity, body axes [rad/s], shape (n, 3).
    body_accel_z, hub_accel_z: specific force along the vertical axis of the body corner, the hub [m/s^2], shape (n, 4).
    rim_angle: of the rim against its knuckle, unbounded [rad], shape (n, 4). rim_speed: its derivative [rad/s], (n, 4).
    steering_wheel_angle [rad], engine_torque, driveline_torque (of the driven axle) [N m], shape (n,).
    tyre_pressure: gauge [Pa], shape (n, 4). tyre_temperature: of the gas [K], shape (n, 4).
    motor_angle, motor_demand, pinion_angle: of the active steering [rad], shape (n,), None in a car without it.
    """

    time: FloatArray
    accel_cg: FloatArray
    gyro: FloatArray
    body_accel_z: FloatArray
    hub_accel_z: FloatArray
    rim_angle: FloatArray
    rim_speed: FloatArray
    steering_wheel_angle: FloatArray
    engine_torque: FloatArray
    driveline_torque: FloatArray
    tyre_pressure: FloatArray
    tyre_temperature: FloatArray
    motor_angle: FloatArray | None = None
    motor_demand: FloatArray | None = None
    pinion_angle: FloatArray | None = None

    def __post_init__(self) -> None:
        n = len(self.time)
        if n == 0:
            raise ValueError("motion: no rows, want at least one")
        for part in fields(self):
            value, width = getattr(self, part.name), WIDTHS[part.name]
            if value is None and part.name in _ACTIVE_STEERING:
                continue
            want = (n, width) if width else (n,)
            if value.shape != want:
                raise ValueError(f"motion: {part.name} has shape {value.shape}, want {want}")
            if not np.isfinite(value).all():
                bad = np.argwhere(~np.isfinite(value))[0]
                raise ValueError(f"motion: {part.name} is {value[tuple(bad)]} in row {bad[0]}, want finite values")
        grid = (np.arange(n) + self.first_step) / STEPS_PER_SECOND
        if np.abs(self.time - grid).max() > _OFF_GRID:
            span = f"{self.time[0]:.9g} to {self.time[-1]:.9g} s"
            raise ValueError(f"motion: time {span} in {n} rows is off the sensors' grid of 1 ms")

    @property
    def first_step(self) -> int:
        """Index k of the first row on the grid."""
        return round(float(self.time[0]) * STEPS_PER_SECOND)

    @property
    def end(self) -> float:
        """Time of the last row [s], exactly on the grid."""
        return (self.first_step + len(self.time) - 1) / STEPS_PER_SECOND
