"""Active front steering in the loop: the driver's hands, the control unit, the motor, and what the road wheels get.

One step at time t, angles as they are at t:
    hands     delta_S: what gives the road-wheel angle wanted through the ratio demanded, or, once the motor is locked,
              through the gear's own; at most HAND_RATE
    gear      delta_G of delta_S and delta_M, delta_F = F_SG(delta_G) of the road wheels (`gear`)
    unit      every millisecond: delta_Md from delta_S and the speed (`ratio`), the current asked for (`servo`)
    motor     one step on (`motor`), against T_load = -(1 - assist) (Mz_fl + Mz_fr) (d delta_F / d delta_G) / i_M, the
              front tyres' aligning moments by the gear, less what the power steering carries
The steering wheel is where the driver holds it: it has no inertia, and he feels nothing. Left out: the moment that
wheels at rest need to be turned (no turn slip in the tyre), kingpin trail and offset.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined
from models.vehicle import ActiveSteering
from testbed.steering import motor as machine
from testbed.steering import servo as control_unit
from testbed.steering.gear import Gear, pinion_for, pinion_of, road_wheels_of, steering_wheel_of
from testbed.steering.lock import NEVER, Lock, fallen, told
from testbed.steering.motor import Motor, motor_step
from testbed.steering.ratio import Ratio, heard, motor_demand, pinion_gain
from testbed.steering.servo import PERIOD, Servo, control, encoded

HAND_RATE = 19.2  # rad/s: 1100 deg/s, as fast as the driver of the plain car and about as fast as anybody
# columns of the unit's state: angles [rad] but for the speed [m/s]
CAR_SPEED, WHEEL, HEARD, DEMAND, PINION, ROAD_WHEELS = range(6)


class SteeringState(NamedTuple):
    """Of `motor`, `servo` and the unit above."""

    motor: NDArray[np.float64]
    control: NDArray[np.float64]
    unit: NDArray[np.float64]


class LoopFault(NamedTuple):
    """What is wrong with the angle sensor that the servo itself works on, every millisecond from the start, shape (n,),
    n = 0 for nothing: it says scale * angle + offset [rad], or, where hold is not 0, what it said last."""

    scale: NDArray[np.float64]
    offset: NDArray[np.float64]
    hold: NDArray[np.float64]


class SteeringUnit(NamedTuple):
    """Everything constant. present: 0 for a car without it."""

    present: int
    gear: Gear
    ratio: Ratio
    motor: Motor
    servo: Servo
    lock: Lock
    fault: LoopFault
    reaction: float  # share of the aligning moment that loads the gear [-]
    task: int  # steps of the drive in a millisecond


NO_FAULT = LoopFault(np.empty(0), np.empty(0), np.empty(0))


def steering_unit(
    numbers: ActiveSteering, present: bool, step: float, lock: float | None = None, fault: LoopFault = NO_FAULT
) -> SteeringUnit:
    """step: of the drive [s], a whole number in a millisecond; lock: time of the order to lock [s]."""
    n = numbers
    return SteeringUnit(
        int(present),
        Gear(n.wheel_ratio, n.motor_ratio, n.rack_ratio, n.rack_stop),
        Ratio(np.array(n.ratio_speeds, float), np.array(n.ratios, float), n.demand_lag, n.speed_lag),
        Motor(
            n.motor_inertia, n.motor_friction, n.motor_damping, n.torque_constant, n.resistance, n.supply_voltage,
            n.largest_current, n.current_lag,
        ),
        Servo(
            n.position_gain, n.velocity_gain, n.velocity_integral, n.largest_speed, n.largest_current,
            n.motor_inertia / n.torque_constant,
        ),
        Lock(NEVER if lock is None else lock, n.lock_delay),
        fault,
        1.0 - n.assist_share,
        round(PERIOD / step),
    )  # fmt: skip


def steering_state(speed: float) -> SteeringState:
    """Straight ahead at a speed [m/s]."""
    unit = np.zeros(6)
    unit[CAR_SPEED] = speed
    return SteeringState(np.zeros(3), np.zeros(5), unit)


@inlined
def turn(unit, state, wanted, speed, time, step):
    """The driver's hands for the road-wheel angle wanted [rad], and the gear. speed: of the car [m/s]. Returns the
    road wheels' angle [rad]."""
    u, motor_angle = state.unit, state.motor[machine.ANGLE]
    u[CAR_SPEED] += (speed - u[CAR_SPEED]) * min(step / unit.ratio.speed_lag, 1.0)
    pinion = pinion_for(unit.gear, wanted)
    if told(unit.lock, time):
        wheel = steering_wheel_of(unit.gear, pinion, motor_angle)
    else:
        wheel = pinion / pinion_gain(unit.gear, unit.ratio, u[CAR_SPEED])
    u[WHEEL] += min(max(wheel - u[WHEEL], -HAND_RATE * step), HAND_RATE * step)
    u[PINION] = pinion_of(unit.gear, u[WHEEL], motor_angle)
    u[ROAD_WHEELS] = road_wheels_of(unit.gear, u[PINION])
    return u[ROAD_WHEELS]


@inlined
def command(unit, state, time, due):
    """The control unit: demand and current asked for [A]. due: whether it is its turn."""
    u, c = state.unit, state.control
    if due:
        u[HEARD] += (heard(u[WHEEL]) - u[HEARD]) * -math.expm1(-PERIOD / unit.ratio.demand_lag)
        u[DEMAND] = motor_demand(unit.gear, unit.ratio, u[CAR_SPEED], u[HEARD])
        sensed = encoded(state.motor[machine.ANGLE])
        at = int(time / PERIOD + 0.5)
        if time >= 0.0 and at < unit.fault.hold.size:
            if unit.fault.hold[at] != 0.0:
                sensed = c[control_unit.SENSED]
            else:
                sensed = unit.fault.scale[at] * sensed + unit.fault.offset[at]
        control(unit.servo, c, u[DEMAND], sensed)
    return 0.0 if told(unit.lock, time) else c[control_unit.ASKED]


@inlined
def advance(unit, state, asked, moment, time, step):
    """The motor, one step on from `time`. asked: [A]; moment: aligning moments of the front tyres, summed [N m]."""
    if fallen(unit.lock, time):
        state.motor[machine.SPEED] = state.motor[machine.CURRENT] = 0.0
        return
    slope = 1.0 / (unit.gear.rack_ratio * math.cos(state.unit[ROAD_WHEELS]))
    load = -unit.reaction * moment * slope / unit.gear.motor_ratio
    motor_step(unit.motor, state.motor, asked, load, step)


@inlined
def superposed(unit, state, wanted, speed, moment, time, due, step, row):
    """One step: what the road wheels get [rad] where the driver wants `wanted` [rad]. row: the trace's columns from
    `motor_angle` to `motor_locked`, shape (7,), written; the rest as above."""
    angle = turn(unit, state, wanted, speed, time, step)
    asked = command(unit, state, time, due)
    row[0] = state.motor[machine.ANGLE]
    row[1] = state.motor[machine.SPEED]
    row[2] = unit.motor.torque_constant * state.motor[machine.CURRENT]
    row[3] = state.unit[DEMAND]
    row[4] = state.unit[PINION]
    row[5] = angle
    row[6] = 1.0 if fallen(unit.lock, time) else 0.0
    advance(unit, state, asked, moment, time, step)
    return angle
