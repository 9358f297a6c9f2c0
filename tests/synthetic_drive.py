"""Closed-form drives for the estimator tests: a rigid car rolls along a path with chosen radii, slip and noise.

Wheel i turns at w_i = v_i (1 + slip_i) / r_i, with v_i the speed of its contact point along its own plane (Ackermann
angles, no side slip at the rear), slip of the driven wheels mu / k. In a curve load moves: radii and slip of the
lighter wheels grow. Tyres at nominal pressure. No dynamics: the path is
given.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.car import AIR_DENSITY, GRAVITY, Car
from estimators.drive_log import WHEELS, DriveLog, Signal
from estimators.quarter_car.quarter_car import QuarterCar, quarter_masses, ride
from estimators.quarter_car.road_shape import class_spectrum, synthesised
from estimators.wheel_radius.curve import BODY_ROLL, INNER_SLIP, RADIUS_LOAD
from estimators.wheel_radius.traction import axle_loads

RATE = 100.0  # Hz
GEAR = 10.0  # of engine and final drive


@dataclass(frozen=True)
class Noise:
    """Standard deviations of one sample; gyro_offset [rad/s] is constant."""

    omega: float = 0.03
    gyro: float = 0.003
    gyro_offset: float = 0.004
    torque: float = 10.0
    pressure: float = 500.0


QUIET = Noise(0.0, 0.0, 0.0, 0.0, 0.0)


def drive(
    speed: NDArray[np.float64],
    *,
    car: Car | None = None,
    radius_change: ArrayLike = (0.0, 0.0, 0.0, 0.0),
    curvature: NDArray[np.float64] | float = 0.0,
    compliance: NDArray[np.float64] | float = 0.034,
    noise: Noise = QUIET,
    seed: int = 0,
    hubs: bool = False,
) -> DriveLog:
    """A log at 100 Hz. speed: rear axle [m/s], shape (n,); radius_change: relative, (4,) or (n, 4); compliance: 1/k, a
    number or (n,); curvature [1/m]; hubs: hub and body accelerations too, at 1 kHz, of quarter cars on a class B road,
    and the engine's torque.
    """
    car = car or Car()
    rng = np.random.default_rng(seed)
    time = (np.arange(len(speed)) + 0.5) / RATE
    yaw_rate = speed * curvature
    steer = np.arctan(car.wheelbase * np.broadcast_to(curvature, speed.shape))
    acceleration = np.gradient(speed, 1.0 / RATE)
    force = car.mass * acceleration + 0.5 * AIR_DENSITY * car.drag_area * speed**2
    force = np.where(speed > 0.0, force, 0.0)
    slip = _slip(car, force, acceleration, compliance)
    radii = car.rolling_radius * (1.0 + np.broadcast_to(np.asarray(radius_change), (len(speed), 4)))
    lighter = _lighter(car, speed * yaw_rate)
    loads = np.repeat(np.array(axle_loads(car, 0.0)) / 2.0, 2)
    slip += INNER_SLIP / compliance_column(compliance) * slip * lighter / loads
    omega = contact_speeds(car, speed, curvature) * (1.0 + slip) / (radii * np.exp(-RADIUS_LOAD * lighter))
    moving = (speed > 0.0)[:, None]
    omega = omega + noise.omega * rng.standard_normal(omega.shape) * moving
    gyro = np.zeros((len(speed), 3))
    gyro[:, 2] = yaw_rate + noise.gyro_offset + noise.gyro * rng.standard_normal(len(speed))
    accel = np.column_stack([acceleration, speed * yaw_rate / BODY_ROLL, np.full(len(speed), 9.81)])
    driven_inertia = 2.0 * (car.front_wheel_inertia + car.rear_wheel_inertia) * acceleration / car.rolling_radius
    torque = force * car.rolling_radius + driven_inertia + noise.torque * rng.standard_normal(len(speed))
    signals = {f"wheel/{wheel}/speed": Signal(time, omega[:, i], "rad/s") for i, wheel in enumerate(WHEELS)}
    signals |= {f"wheel/{wheel}/edges": tooth_edges(time, omega[:, i], seed + i) for i, wheel in enumerate(WHEELS)}
    signals["imu/gyro"] = Signal(time, gyro, "rad/s", "imu")
    signals["imu/accel"] = Signal(time, accel, "m/s^2", "imu")
    signals["driveline/torque"] = Signal(time, torque, "N m")
    signals["steering/angle"] = Signal(time, steer * car.steering_ratio, "rad")
    motor = 30.0 * signals["steering/angle"].value  # of an active steering: as demanded, i_S = 1, i_M = 40
    signals["steering/motor_demand"] = Signal(time, motor, "rad")
    signals["steering/motor_angle"] = Signal(
        time, motor + 0.01 * np.random.default_rng((seed, 1)).standard_normal(len(motor)), "rad"
    )
    signals["steering/pinion_angle"] = Signal(time, (30.0 / 40.0 + 1.0) * signals["steering/angle"].value, "rad")
    for wheel in WHEELS:
        measured = car.pressure + noise.pressure * rng.standard_normal(len(speed))
        signals[f"tyre/{wheel}/pressure"] = Signal(time, measured, "Pa")
        signals[f"tyre/{wheel}/temperature"] = Signal(time, np.full(len(speed), 293.15), "K")
    if hubs:
        signals |= hub_signals(car, speed, seed)
        signals["engine/torque"] = Signal(time, torque / GEAR, "N m")
    signals["truth/fl/radius"] = Signal(time, radii[:, 0], "m")
    return DriveLog(signals, {"car": asdict(car)})


def tooth_edges(time: NDArray[np.float64], omega: NDArray[np.float64], seed: int, teeth: int = 48) -> Signal:
    """Edges of a wheel that turns at omega [rad/s], linear between samples, and their running count. The ring's pitch
    errors are 0.3 % r.m.s."""
    ring = np.cumsum(0.003 * np.random.default_rng(seed).standard_normal(teeth))
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (omega[1:] + omega[:-1]) * np.diff(time))]) * teeth / (2.0 * np.pi)
    angle += 1e-9 * np.arange(len(angle))  # rises even where the wheel stands, so that it can be inverted
    number = np.arange(1.0, max(np.floor(angle[-1]), 1.0))
    edge = number + ring[number.astype(int) % teeth]
    edge = edge[(edge > angle[0]) & (edge < angle[-1])]
    return Signal(np.sort(np.interp(edge, angle, time)), np.arange(1.0, len(edge) + 1.0))


def hub_signals(car: Car, speed: NDArray[np.float64], seed: int) -> dict[str, Signal]:
    """`hub/WHEEL/accel_z` and `body/WHEEL/accel_z`: linear quarter cars at nominal pressure, each on a class B road of
    its own."""
    spacing, step = 0.01, 1e-3
    instants = np.arange(2 * len(speed) * round(1.0 / (RATE * step)) - 1) * 0.5 * step
    way = np.interp(instants, (np.arange(len(speed) + 1)) / RATE, np.concatenate([[0.0], np.cumsum(speed) / RATE]))
    signals = {}
    for i, wheel in enumerate(WHEELS):
        rng = np.random.default_rng([seed, i])
        road = synthesised(class_spectrum("B"), 1.0, spacing, round(way[-1] / spacing) + 2, rng)
        sprung, unsprung = quarter_masses(car, wheel)
        quarter = QuarterCar(sprung, unsprung, car.front_spring_rate, 0.0, car.front_damping, 0.0)
        heights = np.interp(way, spacing * np.arange(len(road)), road)
        _, felt = ride(quarter, heights, car.tyre_stiffness, step)
        value = felt[:, 1] + GRAVITY + 0.5 * rng.standard_normal(len(felt))
        signals[f"hub/{wheel}/accel_z"] = Signal(step * np.arange(len(felt)), value, "m/s^2")
        noise = 0.5 * np.random.default_rng([seed, i, 1]).standard_normal(len(felt))
        signals[f"body/{wheel}/accel_z"] = Signal(step * np.arange(len(felt)), felt[:, 0] + GRAVITY + noise, "m/s^2")
    return signals


def contact_speeds(car: Car, speed: NDArray[np.float64], curvature: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Exact speed of each contact point along its wheel (n, 4): distance from the turning centre times yaw rate."""
    kappa = np.broadcast_to(curvature, speed.shape)
    sides = {"left": -1.0, "right": 1.0}
    front = [np.hypot(1.0 + s * 0.5 * car.front_track * kappa, car.wheelbase * kappa) for s in sides.values()]
    rear = [1.0 + s * 0.5 * car.rear_track * kappa for s in sides.values()]
    return speed[:, None] * np.column_stack([*front, *rear])


def _slip(car: Car, force: NDArray, acceleration: NDArray, compliance: NDArray | float) -> NDArray[np.float64]:
    """Longitudinal slip of the four wheels (n, 4): ground force over load times compliance."""
    loads = axle_loads(car, acceleration)
    inertias = (car.front_wheel_inertia, car.rear_wheel_inertia)
    slip = np.zeros((len(force), 4))
    for axle in (0, 1):
        inertia_force = inertias[axle] * acceleration / car.rolling_radius**2
        driven = (car.driven_axle == "front") == (axle == 0)
        other = inertias[1 - axle] * acceleration / car.rolling_radius**2
        ground = 0.5 * force + other if driven else -inertia_force
        slip[:, 2 * axle : 2 * axle + 2] = (compliance * ground / (0.5 * loads[axle]))[:, None]
    return slip


def compliance_column(compliance: NDArray | float) -> NDArray[np.float64]:
    """1/k of a drive as a number or (n, 1)."""
    return np.asarray(compliance, float)[..., None] if np.ndim(compliance) else np.asarray(compliance, float)


def _lighter(car: Car, lateral: NDArray) -> NDArray[np.float64]:
    """Load [N] that a lateral acceleration (n,) [m/s^2] takes off each wheel, (n, 4): off the left ones in a left turn,
    on both axles alike."""
    moved = car.mass * lateral * car.cg_height / (car.front_track + car.rear_track)
    return moved[:, None] * np.array([1.0, -1.0, 1.0, -1.0])


def varied_speed(seconds: float, mean: float = 20.0, swing: float = 5.0, period: float = 40.0) -> NDArray[np.float64]:
    """A speed that swings about a mean [m/s], shape (100 * seconds,)."""
    time = (np.arange(int(seconds * RATE)) + 0.5) / RATE
    return mean + swing * np.sin(2.0 * np.pi * time / period)


def last(said: Mapping[str, Signal], name: str) -> tuple[float, float]:
    """Last (value, std) of an estimate of `wheel_radius`."""
    value, std = said[f"est/wheel_radius/{name}"], said[f"est/wheel_radius/{name}/std"]
    return float(value.value[-1]), float(std.value[-1])
