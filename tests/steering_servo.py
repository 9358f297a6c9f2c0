"""A motor and its cascade control for tests of the monitors: written for itself, at 1 kHz, and the log that it leaves.

    w* = clip(80 (delta_Md - delta_M), +-150 rad/s)    dw/dt = clip(300 (w* - w), +-4000 rad/s^2)    i_S = 1, i_M = 40

The demand is 0.8, -0.2 or 0.3 of the steering wheel's angle at the pinion, by the seed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import DriveLog, Signal
from estimators.grid import Grid
from estimators.steering_actuator.servo_model import ServoModel
from estimators.steering_actuator.steering_actuator import CHANNELS, STEP

GAIN, SPEED_GAIN, FASTEST, HARDEST, MOTOR_RATIO = 80.0, 300.0, 150.0, 4000.0, 40.0
TRUE = ServoModel(GAIN, SPEED_GAIN, 1e-4, 1e-5, FASTEST, HARDEST)
MS = 1e-3

Array = NDArray[np.float64]


def wheel_angle(seconds: float, seed: int, active: float = 0.6) -> Array:
    """The driver's angle [rad] each millisecond: three sines of 0.2 to 1.5 Hz that begin softly
    after 1.5 s."""
    rng = np.random.default_rng(seed)
    time = MS * np.arange(round(seconds / MS))
    waves = [rng.uniform(0.0, 0.6) * np.sin(2.0 * np.pi * rng.uniform(0.2, 1.5) * time) for _ in range(3)]
    return active * np.sum(waves, axis=0) * np.clip(time - 1.5, 0.0, 1.0)


def servo(demand: Array) -> Array:
    """delta_M each millisecond; semi-implicit Euler."""
    x = w = 0.0
    angle = np.empty(len(demand))
    for k, u in enumerate(demand.tolist()):
        wanted = min(max(GAIN * (u - x), -FASTEST), FASTEST)
        w += MS * min(max(SPEED_GAIN * (wanted - w), -HARDEST), HARDEST)
        x += MS * w
        angle[k] = x
    return angle


def log(seconds: float, seed: int, active: float = 0.6, sensed: Array | None = None, loop: float = 0.0) -> DriveLog:
    """sensed: added to what the motor's angle sensor tells [rad], (n,); loop: to what the servo itself works on."""
    rng = np.random.default_rng((seed, 1))
    wheel = wheel_angle(seconds, seed, active)
    time = MS * np.arange(len(wheel))
    demand = MOTOR_RATIO * (0.8, -0.2, 0.3)[seed % 3] * wheel
    angle = servo(demand - loop * (time > 0.5 * seconds))
    told = angle + loop * (time > 0.5 * seconds) + np.radians(0.3) * rng.standard_normal(len(time))
    if sensed is not None:
        told = told + sensed
    pinion = wheel + angle / MOTOR_RATIO + np.radians(0.2) + np.radians(0.05) * rng.standard_normal(len(time))
    slow = Signal(time.reshape(-1, 10).mean(axis=1), pinion.reshape(-1, 10).mean(axis=1), "rad")
    return DriveLog({
        "steering/angle": Signal(time, wheel, "rad"), "steering/motor_demand": Signal(time, demand, "rad"),
        "steering/motor_angle": Signal(time, told, "rad"), "steering/pinion_angle": slow,
    })  # fmt: skip


def cells(of: DriveLog) -> tuple[Array, Array, Array, Array]:
    """demand, angle, pinion, wheel of each 10 ms as the estimator hears them, (n,)."""
    grid = Grid(CHANNELS, STEP)
    grid.add(of)
    values = grid.close(of.span[1] + 1.0)[0].value
    demand, angle, pinion, wheel = (np.ascontiguousarray(column) for column in values.T)
    return demand, angle, pinion, wheel
