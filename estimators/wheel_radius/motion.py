"""What the car does in one tenth of a second: speed, yaw rate, steering, traction, and whether wheel radii may be read.

From cell averages of wheel speeds, gyro, accelerometer, driven-axle torque and steering-wheel angle; ISO 8855 axes
(left turn: yaw rate positive, right wheels faster). Wheels are in the order fl fr rl rr.

Rolling speeds of the wheels in a curve, yaw rate r, front steering angle d, rear-axle speed v, no side slip at the
rear:
    front  (v -+ r t_f / 2) cos d + L r sin d          rear  v -+ r t_r / 2          (upper sign: left wheel)
Normalised traction mu of the driven wheel less that of the free one, for axle torque T, wheel inertias J, acceleration
a:
    mu = (T / (2 R) - J_d a / R^2) / F_d + (J_n a / R^2) / F_n,   F: wheel loads with load transfer m a h / (2 L)
Without a torque signal the force is taken from the accelerometer, F = m f_x + drag (f_x: specific force, so a grade
does not matter), only while the car is not slowing down. Left out: lift, rolling resistance (the same on both axles),
and the radius' own dependence on load and speed, which is why hard driving is not read.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.car import AIR_DENSITY, GRAVITY, Car
from estimators.grid import Channel

STUCK = 3.0  # [s]; a moving wheel's speed is never the same for so long, in steps of 0.01 to 0.04 km/h
CHANNELS = (
    *(Channel(f"wheel/{wheel}/speed", frozen_after=STUCK) for wheel in ("fl", "fr", "rl", "rr")),
    Channel("imu/gyro", 2),
    Channel("imu/accel", 0),
    Channel("imu/accel", 1),
    Channel("driveline/torque"),
    Channel("steering/angle"),
)
MIN_SPEED = 4.0  # [m/s]; below, bus quantisation and curvature dominate
MAX_SPEED = 100.0  # [m/s]; above, a wheel-speed sensor is wrong
MAX_LATERAL = 1.0  # [m/s^2]; load transfer then moves a radius by less than 0.05 %
MAX_LONGITUDINAL = 3.0  # [m/s^2]
MAX_SLIP = 0.03  # linear part of the slip curve, and tyres of one car differ by less
MAX_TRACTION = 0.3  # linear part of the slip curve
BRAKING = 0.4  # [m/s^2] that the car is slower than its torque explains, plus a quarter of what the torque gives
STANDSTILL_CELLS = 10  # with every wheel at rest before the car counts as standing
STANDSTILL_OMEGA = 0.02  # [rad/s]


@dataclass(frozen=True)
class Motion:
    """One cell. omega: (4,) [rad/s]; roll: (4,) rolling speed of each wheel over the rear axle's speed [-].

    gyro: measured yaw rate [rad/s], NaN if none; gyro_gain: what an offset of one unit of the gyro (rad/s), or of the
    lateral accelerometer standing in for it (m/s^2, `stand_in`), adds to `gyro`; traction mu [-], NaN while unknown;
    readable: radii may be read from this cell; standing: all wheels have been at rest for a second.
    """

    index: int
    time: float
    omega: NDArray[np.float64]
    speed: float
    roll: NDArray[np.float64]
    cos_steer: float
    gyro: float
    gyro_gain: float
    stand_in: bool
    traction: float
    readable: bool
    standing: bool


class MotionTracker:
    """Turns cells into motions; remembers the last speed (for the acceleration) and how long the car has stood."""

    def __init__(self, car: Car, step: float) -> None:
        self._car, self._step = car, step
        self._last: tuple[int, float] | None = None
        self._standing_cells = 0
        self.torque_seen = False
        self.gyro_seen = False

    def motion(self, index: int, time: float, cell: NDArray[np.float64]) -> Motion:
        """cell: one value per channel of `CHANNELS`, NaN where missing."""
        car = self._car
        omega, (gyro, accel_x, accel_y, torque, wheel_angle) = cell[:4].copy(), cell[4:].tolist()
        omega[np.abs(omega) * car.rolling_radius > MAX_SPEED] = np.nan
        free = omega[2:] if car.driven_axle == "front" else omega[:2]
        speed = float(free.mean()) * car.rolling_radius
        acceleration = self._acceleration(index, speed)
        self.torque_seen |= not np.isnan(torque)
        self.gyro_seen |= not np.isnan(gyro)
        gain, moving = 1.0, speed > MIN_SPEED
        if not self.gyro_seen:  # lateral acceleration over speed stands in for the yaw rate
            gain = 1.0 / speed if moving else 1.0
            gyro = accel_y * gain
        wheel_yaw = float(omega[3] - omega[2]) * car.rolling_radius / car.rear_track
        yaw_rate = wheel_yaw if np.isnan(gyro) else gyro
        steer = wheel_angle / car.steering_ratio
        if np.isnan(steer):
            steer = car.wheelbase * yaw_rate / speed if moving else 0.0
        ratio = float(omega[:2].mean() / omega[2:].mean()) if moving else np.nan
        readable = bool(
            moving
            and abs(ratio - 1.0) < MAX_SLIP
            and abs(speed * yaw_rate) < MAX_LATERAL
            and not abs(acceleration) > MAX_LONGITUDINAL
        )
        self._standing_cells = self._standing_cells + 1 if bool((np.abs(omega) < STANDSTILL_OMEGA).all()) else 0
        return Motion(
            index=index,
            time=time,
            omega=omega,
            speed=speed,
            roll=rolling_ratios(car, yaw_rate / speed if moving else 0.0, steer),
            cos_steer=float(np.cos(steer)),
            gyro=gyro,
            gyro_gain=gain,
            stand_in=not self.gyro_seen,
            traction=self._traction(speed, acceleration, accel_x, torque),
            readable=readable,
            standing=self._standing_cells >= STANDSTILL_CELLS,
        )

    def _acceleration(self, index: int, speed: float) -> float:
        """Of the free wheels [m/s^2], NaN after a gap."""
        last, self._last = self._last, (index, speed)
        if last is None or index - last[0] > 3:
            return float("nan")
        return (speed - last[1]) / ((index - last[0]) * self._step)

    def _traction(self, speed: float, acceleration: float, accel_x: float, torque: float) -> float:
        """Normalised traction of the driven wheel less that of the free one [-]; NaN while braking or unknown."""
        car, radius = self._car, self._car.rolling_radius
        drag = 0.5 * AIR_DENSITY * car.drag_area * speed**2
        felt = acceleration if np.isnan(accel_x) else accel_x
        if self.torque_seen:
            force = torque / radius
            expected = (force - drag) / car.mass
            if not felt > expected - BRAKING - 0.25 * abs(expected):
                return float("nan")
        else:
            force = car.mass * accel_x + drag
            if not accel_x > -BRAKING:
                return float("nan")
        if np.isnan(acceleration):
            return float("nan")
        front_load, rear_load = axle_loads(car, acceleration)
        inertias = (car.front_wheel_inertia, car.rear_wheel_inertia)
        loads = (0.5 * front_load, 0.5 * rear_load)
        driven, free = (0, 1) if car.driven_axle == "front" else (1, 0)
        mu = (0.5 * force - inertias[driven] * acceleration / radius**2) / loads[driven]
        mu += inertias[free] * acceleration / radius**2 / loads[free]
        return mu if abs(mu) < MAX_TRACTION else float("nan")


def axle_loads(car: Car, acceleration: float) -> tuple[float, float]:
    """Front and rear axle load [N] at a longitudinal acceleration [m/s^2]."""
    front_sprung = car.chassis_mass * car.cg_to_rear_axle / car.wheelbase
    front = (front_sprung + 2.0 * car.front_wheel_mass) * GRAVITY
    rear = (car.chassis_mass - front_sprung + 2.0 * car.rear_wheel_mass) * GRAVITY
    shift = car.mass * acceleration * car.cg_height / car.wheelbase
    return front - shift, rear + shift


def rolling_ratios(car: Car, curvature: float, steer: float) -> NDArray[np.float64]:
    """Rolling speed of each wheel over the rear axle's speed, shape (4,); curvature of the rear axle's path [1/m]."""
    side = np.array([-1.0, 1.0])
    front = (1.0 + 0.5 * curvature * car.front_track * side) * np.cos(steer) + car.wheelbase * curvature * np.sin(steer)
    return np.concatenate([front, 1.0 + 0.5 * curvature * car.rear_track * side])
