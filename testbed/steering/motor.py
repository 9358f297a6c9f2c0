"""The motor: a synchronous machine with its current control, inertia and friction.

    di/dt     = (clip(i*, low, high) - i) / tau             i*: current asked for
    J dw/dt   = k i - d w - T_load - T_c sign(w)            standing still while |k i - T_load| <= T_c
    d theta/dt = w

    high = min( i_max, (U - k w) / R),  low = max(-i_max, (-U - k w) / R)

so the torque is bounded by the current at low speed and by what the voltage leaves over the induced one at high speed;
unloaded the motor runs at U / k at the most. Electric power is R i^2 + k i w. A step is SUBSTEPS times: the current
exactly for its bounds at the begin, then speed and angle, friction implicitly (it can stop the motor and not turn it
round).
Left out: field weakening, cogging, warmth.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from estimators.compiled import inlined

SUBSTEPS = 4  # of the mechanical equation in a step of the drive
# columns of the motor's state
ANGLE, SPEED, CURRENT = range(3)  # rad, rad/s, A


class Motor(NamedTuple):
    """inertia J [kg m^2], friction T_c [N m], damping d [N m s/rad], torque_constant k [N m/A], resistance R [ohm],
    voltage U [V], largest_current i_max [A], current_lag tau [s]."""

    inertia: float
    friction: float
    damping: float
    torque_constant: float
    resistance: float
    voltage: float
    largest_current: float
    current_lag: float


@inlined
def current_within(motor, speed, asked):
    """The current [A] that can flow at a speed [rad/s] where `asked` is wanted."""
    induced = motor.torque_constant * speed
    high = min(motor.largest_current, (motor.voltage - induced) / motor.resistance)
    low = max(-motor.largest_current, (-motor.voltage - induced) / motor.resistance)
    return min(max(asked, low), high)


@inlined
def motor_step(motor, state, asked, load, step):
    """One step [s] on. state: ANGLE, SPEED, CURRENT, written. asked: current [A]; load: T_load [N m]."""
    h = step / SUBSTEPS
    keep = math.exp(-h / motor.current_lag)
    for _ in range(SUBSTEPS):
        target = current_within(motor, state[SPEED], asked)
        mean = target + (state[CURRENT] - target) * (1.0 - keep) * motor.current_lag / h
        state[CURRENT] = target + (state[CURRENT] - target) * keep
        torque = motor.torque_constant * mean - motor.damping * state[SPEED] - load
        free = state[SPEED] + h * torque / motor.inertia
        rub = h * motor.friction / motor.inertia
        after = max(abs(free) - rub, 0.0) * (1.0 if free > 0.0 else -1.0)
        state[ANGLE] += 0.5 * h * (state[SPEED] + after)
        state[SPEED] = after
