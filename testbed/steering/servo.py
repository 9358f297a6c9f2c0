"""The motor's control: position over velocity over current, every millisecond, on the motor's own angle sensor.

    w*  = clip(K_p (delta_Md - delta_M), +-w_max)
    i*  = J / k [K_v (w* - w) + K_v K_i integral(w* - w) dt],  within +-i_max; the integral waits at that bound

Without feed-forward of the demand's speed, as the published residuals show it: delta_M runs behind a steady demand by
its speed over K_p. Beyond w_max and the motor's own limits it falls back further, and catches up afterwards.
w is the difference quotient of the sensed angle, smoothed by a first-order lag of SMOOTHING. The sensor tells the angle
in steps of ENCODER.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from estimators.compiled import inlined

PERIOD = 1e-3  # s of the control's task
ENCODER = 2.0 * math.pi / 1024.0  # rad: a digital motor position sensor of 10 bit a turn, declared
SMOOTHING = 1e-3  # s
# columns of the control's state
SENSED, SPEED, INTEGRAL, ASKED, STARTED = range(5)  # rad, rad/s, rad/s * s, A, whether it has sensed before


class Servo(NamedTuple):
    """position_gain K_p, velocity_gain K_v, velocity_integral K_i [1/s]; largest_speed w_max [rad/s]; largest_current
    i_max [A]; current_per_acceleration J / k [A s^2/rad]."""

    position_gain: float
    velocity_gain: float
    velocity_integral: float
    largest_speed: float
    largest_current: float
    current_per_acceleration: float


@inlined
def encoded(angle):
    """An angle [rad] in the sensor's steps."""
    return ENCODER * math.floor(angle / ENCODER + 0.5)


@inlined
def control(servo, state, demand, sensed):
    """Current asked for [A] until the next call. demand, sensed: angles of the motor [rad]; state written."""
    if state[STARTED] == 0.0:
        state[SENSED], state[STARTED] = sensed, 1.0
    quotient = (sensed - state[SENSED]) / PERIOD
    state[SPEED] += (quotient - state[SPEED]) * -math.expm1(-PERIOD / SMOOTHING)
    state[SENSED] = sensed
    wanted = servo.position_gain * (demand - sensed)
    wanted = min(max(wanted, -servo.largest_speed), servo.largest_speed)
    error = wanted - state[SPEED]
    gain = servo.current_per_acceleration * servo.velocity_gain
    asked = gain * (error + servo.velocity_integral * state[INTEGRAL])
    if abs(asked) < servo.largest_current or asked * error < 0.0:
        state[INTEGRAL] += error * PERIOD
    state[ASKED] = min(max(asked, -servo.largest_current), servo.largest_current)
    return state[ASKED]
