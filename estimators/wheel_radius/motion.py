"""What the car does in one tenth of a second: speed, yaw rate, steering, traction, and whether wheel radii may be read.

From cell averages of wheel speeds, gyro, accelerometer, driven-axle torque and steering-wheel angle; ISO 8855 axes
(left turn: yaw rate positive, right wheels faster). Wheels are in the order fl fr rl rr.

Rolling speeds of the wheels in a curve, yaw rate r, front steering angle d, rear-axle speed v, no side slip at the
rear:
    front  (v -+ r t_f / 2) cos d + L r sin d          rear  v -+ r t_r / 2          (upper sign: left wheel)
What drives and brakes the tyres is in `traction`. Left out: lift, rolling resistance (the same on both axles), and the
radius' own dependence on load and speed, which is why hard driving is not read.

Reversing: speeds that have a sign are below 0 then and not read; without one the wheels turn the other way round than
the gyro says, and a cell in which the two contradict each other is not read. A wheel that is dead is NaN, or stands
while both its neighbours roll; what they tell is still read. While a wheel spins or locks or the car slides, and a
second after, nothing is: setting off on ice both driven wheels spin, unlike by metres a second, beside two that hardly
roll; sliding through a curve at full lock, the wheels' speeds differ by the cosines of their slip angles.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from estimators.car import GRAVITY, Car
from estimators.grid import Channel
from estimators.wheel_radius.curve import curve_shift
from estimators.wheel_radius.sliding import Sliding
from estimators.wheel_radius.traction import axle_pull, drive_force, net_force, traction

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
MAX_YAW_DOUBT = 0.05  # [rad/s] and
MAX_SIDE = 0.01  # [-] of radius by which the rear wheels' yaw rate may differ from the gyro's
DEAD_SHARE = 0.3  # of both its neighbours' speed below which a wheel does not roll
NEIGHBOURS = ((1, 2), (0, 3), (3, 0), (2, 1))  # of each wheel: across the car, along it
STANDSTILL_CELLS = 10  # with every wheel at rest before the car counts as standing
STANDSTILL_OMEGA = 0.02  # [rad/s]


@dataclass(frozen=True)
class Motion:
    """One cell. omega: (4,) [rad/s]; roll: (4,) rolling speed of each wheel over the rear axle's speed [-].

    gyro: measured yaw rate [rad/s], NaN if none; gyro_gain: what an offset of one unit of the gyro (rad/s), or of the
    lateral accelerometer standing in for it (m/s^2, `stand_in`), adds to `gyro`; traction mu [-], NaN while unknown;
    pull: (2,) force over load of the front and rear axle [-], 0 where unknown; force: of the drive, less what spins up
    the wheels and the air drag [N], NaN while braking or without a torque signal; specific: along the car [m/s^2], NaN
    if none; readable: radii may be read from this cell, of the wheels whose omega is a number; standing: all wheels
    have been at rest for a second. curve: what a curve adds to r_left / r_right - 1 of front and rear axle (2,) [-].
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
    pull: NDArray[np.float64]
    force: float
    specific: float
    readable: bool
    standing: bool
    curve: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))


class MotionTracker:
    """Turns cells into motions; remembers the last speed (for the acceleration) and how long the car has stood."""

    def __init__(self, car: Car, step: float) -> None:
        self._car, self._step = car, step
        self._last: tuple[int, float] | None = None
        self._standing_cells = 0
        self._sliding = Sliding()
        self.dead = np.zeros(4, dtype=bool)
        self.torque_seen = False
        self.gyro_seen = False

    def motion(self, index: int, time: float, cell: NDArray[np.float64]) -> Motion:
        """cell: one value per channel of `CHANNELS`, NaN where missing."""
        car = self._car
        omega, (gyro, accel_x, accel_y, torque, wheel_angle) = cell[:4].copy(), cell[4:].tolist()
        omega[np.abs(omega) * car.rolling_radius > MAX_SPEED] = np.nan
        self._without_dead(omega)
        speed = self._speed(omega)
        acceleration = self._acceleration(index, speed)
        self.torque_seen |= not np.isnan(torque)
        self.gyro_seen |= not np.isnan(gyro)
        gain, moving = 1.0, speed > MIN_SPEED
        if not self.gyro_seen:  # lateral acceleration over speed stands in for the yaw rate
            gain = 1.0 / speed if moving else 1.0
            gyro = accel_y * gain
        wheel_yaw = float(omega[3] - omega[2]) * car.rolling_radius / car.rear_track
        yaw_rate = wheel_yaw if np.isnan(gyro) else gyro
        steer, path = wheel_angle / car.steering_ratio, car.wheelbase * yaw_rate / speed if moving else 0.0
        if np.isnan(steer):
            steer = path
        doubt = MAX_YAW_DOUBT + MAX_SIDE * speed / car.rear_track
        lateral = speed * yaw_rate if np.isnan(accel_y) else accel_y
        force = drive_force(car, speed, acceleration, accel_x, torque if self.torque_seen else None)
        pull = axle_pull(car, force, speed, acceleration, accel_x)
        fastest = float(np.nanmax(np.abs(omega), initial=0.0)) * car.rolling_radius
        used = float(np.hypot(np.nanmax(np.abs(pull), initial=0.0), 0.0 if np.isnan(lateral) else lateral / GRAVITY))
        grips = self._sliding.grips(time, omega, steer - path if moving else 0.0, used, fastest > MIN_SPEED)
        readable = bool(
            moving
            and grips
            and abs(speed * yaw_rate) < MAX_LATERAL
            and not abs(wheel_yaw - yaw_rate) > doubt
            and not abs(acceleration) > MAX_LONGITUDINAL
        )
        self._standing_cells = self._standing_cells + 1 if bool((np.abs(cell[:4]) < STANDSTILL_OMEGA).all()) else 0
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
            traction=traction(car, force, acceleration),
            pull=pull,
            force=net_force(car, force, speed, acceleration) if self.torque_seen else float("nan"),
            specific=accel_x,
            readable=readable,
            standing=self._standing_cells >= STANDSTILL_CELLS,
            curve=curve_shift(car, lateral if moving and not np.isnan(lateral) else 0.0, pull),
        )

    def _without_dead(self, omega: NDArray[np.float64]) -> None:
        """Wheels that stand while both their neighbours roll become NaN, and are remembered in `dead`. Beside a wheel
        that spins its neighbours are slow too."""
        slowest = np.array([_slowest(omega[list(wheels)]) for wheels in NEIGHBOURS])
        dead = (slowest * self._car.rolling_radius > MIN_SPEED) & (np.abs(omega) < DEAD_SHARE * slowest)
        self.dead |= dead
        omega[dead] = np.nan

    def _speed(self, omega: NDArray[np.float64]) -> float:
        """Of the wheels that roll freely, of all where none of those is known [m/s]."""
        free = {"front": omega[2:], "rear": omega[:2], "all": omega}[self._car.driven_axle]
        known = free[np.isfinite(free)]
        if not len(known):
            known = omega[np.isfinite(omega)]
        return float(known.mean()) * self._car.rolling_radius if len(known) else float("nan")

    def _acceleration(self, index: int, speed: float) -> float:
        """Of the free wheels [m/s^2], NaN after a gap."""
        last, self._last = self._last, (index, speed)
        if last is None or index - last[0] > 3:
            return float("nan")
        return (speed - last[1]) / ((index - last[0]) * self._step)


def _slowest(omega: NDArray[np.float64]) -> float:
    """Of those wheels that are known [rad/s]; 0 if none is."""
    known = np.abs(omega[np.isfinite(omega)])
    return float(known.min()) if len(known) else 0.0


def rolling_ratios(car: Car, curvature: float, steer: float) -> NDArray[np.float64]:
    """Rolling speed of each wheel over the rear axle's speed, shape (4,); curvature of the rear axle's path [1/m]."""
    side = np.array([-1.0, 1.0])
    front = (1.0 + 0.5 * curvature * car.front_track * side) * np.cos(steer) + car.wheelbase * curvature * np.sin(steer)
    return np.concatenate([front, 1.0 + 0.5 * curvature * car.rear_track * side])
