"""The driver: follows a path with the steering wheel and a speed with engine and brakes.

Steering: what the single-track model (testbed/single_track.py) asks for on the path's curvature k as far ahead as the
car lags, plus feedback of the offset that the car will have at a preview distance d:

    delta = (L + K_us v^2) [k(s + lag) - 2 (e + d sin(heading error)) / d^2]

where the heading wanted is the path's direction less the body's slip angle b k(s - b + D_r v^2) - D_r v^2 k(s - rear
lag), the yaw rate's part and the rear tyres' part. The rate is bounded.
Speed: wheel force m (a_ref + P + I) plus the known drag and grade; engine up to its torque and power, in a gear by
speed and demand, up to its rev limiter, else overrun, else brakes (testbed/brakes.py). Modes: SPEED, COAST (clutch
open), STOP (full braking).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined
from models.tyre_properties import TyreProperties
from models.vehicle import AIR_DENSITY, GRAVITY, Payload, Vehicle
from testbed.brakes import LOCK_SPEED, Brakes, anti_lock, brakes
from testbed.single_track import single_track

SPEED, COAST, STOP = range(3)
PLAN_STEP = 0.01  # s between the rows of a speed plan
PREVIEW_TIME = 0.6  # s
SHORTEST_PREVIEW = 4.0  # m
STEER_RATE = 1.2  # rad/s at the road wheels
LARGEST_STEER = 0.6  # rad
SPEED_GAIN, INTEGRAL_GAIN = 0.8, 0.15  # 1/s, 1/s^2
INTEGRAL_BOUND = 1.5  # m/s^2
ENGINE_LAG = 0.05  # s
ENGINE_SPEED = 470.0  # rad/s above which the driver does not shift down
LIMITER, LIMITER_BAND = 520.0, 20.0  # rad/s of the engine at which the torque is gone, and over which it goes
GRADE_LAG = 0.5  # s over which the grade is felt
ROLLING = 0.009  # rolling resistance that the driver expects [-]
DRIVE_SHARES = {"front": (0.5, 0.5, 0.0, 0.0), "rear": (0.0, 0.0, 0.5, 0.5), "all": (0.25, 0.25, 0.25, 0.25)}
HOLD = 0.25  # share of the brake torque that holds the standing car

# columns of the driver's state
INTEGRAL, STEER, STATION, GEAR, ENGINE_TORQUE, DRIVELINE_TORQUE, PATH_ERROR, GRADE = range(8)
STATE_SIZE = 8


class Plan(NamedTuple):
    """What to drive. speed [m/s], acceleration [m/s^2], mode: at PLAN_STEP, shape (n,); path: x, y, heading, curvature
    at path_step [m], shape (k, 4), going on straight beyond both ends."""

    speed: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    mode: NDArray[np.int64]
    path: NDArray[np.float64]
    path_step: float


class DriverCar(NamedTuple):
    """The car as the driver and its control units know it; SI."""

    mass: float
    wheelbase: float
    front_track: float
    half_track: NDArray[np.float64]  # per wheel, left positive
    rear_arm: float  # from the rear axle forward to the chassis' centre of gravity
    understeer: float  # K_us [rad s^2/m]
    rear_gradient: float  # side slip of the rear axle per lateral acceleration [rad s^2/m]
    yaw_lag: float  # [s^2/m]
    rear_lag: float  # how far the rear tyres' side slip lags the curvature [m]
    radius: float
    drag_area: float
    rolling: float
    drive_share: NDArray[np.float64]  # of the driveline's torque that each wheel gets; open differentials
    brakes: Brakes
    gears: NDArray[np.float64]
    upshift: NDArray[np.float64]
    engine_torque: float
    engine_power: float
    efficiency: float
    overrun: float


def driver_car(vehicle: Vehicle, tyre: TyreProperties, payload: Payload, radius: float, driven: str) -> DriverCar:
    """radius: nominal rolling radius [m]; driven: a key of `DRIVE_SHARES`."""
    line, body = vehicle.driveline, vehicle.chassis
    track = single_track(vehicle, tyre, payload)
    half = np.array([0.5 * axle.track for axle in vehicle.axles]) * np.array([1.0, -1.0, 1.0, -1.0])
    return DriverCar(
        track.mass, track.wheelbase, vehicle.front.track, half, body.cg_to_rear_axle,
        track.understeer, track.rear_gradient, track.yaw_lag, track.yaw_inertia / (track.mass * track.to_front),
        radius, AIR_DENSITY * body.frontal_area * body.drag_coefficient, ROLLING, np.array(DRIVE_SHARES[driven]),
        brakes(vehicle, tyre, radius), np.array(line.gear_ratios), np.array(line.upshift_speeds),
        line.max_engine_torque, line.max_engine_power, line.efficiency, line.overrun_torque,
    )  # fmt: skip


@inlined
def path_place(plan, station):
    """x, y, heading of the path at a station [m]."""
    last = plan.path.shape[0] - 1
    i = int(min(max(station / plan.path_step, 0.0), last - 1.0))
    part = min(max(station / plan.path_step - i, 0.0), 1.0)
    a, b = plan.path[i], plan.path[i + 1]
    heading = a[2] + part * (b[2] - a[2])
    beyond = min(station, 0.0) + max(station - last * plan.path_step, 0.0)
    x = a[0] + part * (b[0] - a[0]) + beyond * math.cos(heading)
    return x, a[1] + part * (b[1] - a[1]) + beyond * math.sin(heading), heading


@inlined
def path_curvature(plan, station):
    """Curvature [1/m] of the path at a station [m]; it is straight beyond its ends."""
    at = station / plan.path_step
    if at < 0.0 or at >= plan.path.shape[0] - 1:
        return 0.0
    i = int(at)
    return plan.path[i, 3] + (at - i) * (plan.path[i + 1, 3] - plan.path[i, 3])


@inlined
def steer(car, plan, state, x, y, heading, speed, step):
    """Road-wheel angle [rad], mean of the two front wheels; keeps station and path error in the state."""
    px, py, direction = path_place(plan, state[STATION])
    dx, dy = x - px, y - py
    state[STATION] += dx * math.cos(direction) + dy * math.sin(direction)
    state[PATH_ERROR] = dy * math.cos(direction) - dx * math.sin(direction)
    drift = car.rear_gradient * speed * speed
    turning = path_curvature(plan, state[STATION] - car.rear_arm + drift)
    pushing = path_curvature(plan, state[STATION] - car.rear_lag)
    turn = heading - direction + car.rear_arm * turning - drift * pushing
    turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
    ahead = max(PREVIEW_TIME * speed, SHORTEST_PREVIEW)
    stretch = 1.0 + car.understeer * speed * speed / car.wheelbase
    coming = path_curvature(plan, state[STATION] + car.yaw_lag * speed * speed / stretch - car.rear_arm)
    feedback = 2.0 * (state[PATH_ERROR] + ahead * math.sin(turn)) / (ahead * ahead)
    wanted = car.wheelbase * stretch * (coming - feedback)
    wanted = min(max(wanted, -LARGEST_STEER), LARGEST_STEER)
    change = min(max(wanted - state[STEER], -STEER_RATE * step), STEER_RATE * step)
    state[STEER] += change
    return state[STEER]


@inlined
def ackermann(car, angle):
    """Road-wheel angles of the front left and right wheel [rad] whose axes meet on the rear axle's line."""
    t = math.tan(angle)
    half = 0.5 * car.front_track * t
    return math.atan(car.wheelbase * t / (car.wheelbase - half)), math.atan(car.wheelbase * t / (car.wheelbase + half))


@inlined
def _reach(car, gear, speed):
    """Largest torque [N m] that the engine gives at the wheels in a gear."""
    ratio = car.gears[gear]
    engine = min(car.engine_torque, car.engine_power * car.radius / (max(speed, 1.0) * ratio))
    return engine * ratio * car.efficiency


@inlined
def _shift(car, state, speed, torque):
    """Gear for a speed [m/s] and a torque wanted at the wheels [N m]: one step at the most."""
    gear = int(state[GEAR])
    if gear < car.upshift.size and speed > car.upshift[gear] and torque < 0.8 * _reach(car, gear + 1, speed):
        gear += 1
    elif gear > 0:
        short = torque > _reach(car, gear, speed) and car.gears[gear - 1] * speed < ENGINE_SPEED * car.radius
        if speed < 0.85 * car.upshift[gear - 1] or (short and _reach(car, gear - 1, speed) > _reach(car, gear, speed)):
            gear -= 1
    state[GEAR] = gear
    return gear


@inlined
def _speed_control(car, plan, state, i, speed, step):
    """Engine torque and brake torque of all wheels [N m] that follow row i of the plan."""
    error = plan.speed[i] - speed
    state[INTEGRAL] += INTEGRAL_GAIN * error * step
    state[INTEGRAL] = min(max(state[INTEGRAL], -INTEGRAL_BOUND), INTEGRAL_BOUND)
    rolling = car.rolling * car.mass * GRAVITY * min(speed, 1.0)
    force = car.mass * (plan.acceleration[i] + SPEED_GAIN * error + state[INTEGRAL] + GRAVITY * state[GRADE])
    torque = (force + 0.5 * car.drag_area * speed * speed + rolling) * car.radius
    if plan.speed[i] <= 0.0 and speed < 0.5:  # stand: hold the car on the brakes
        state[INTEGRAL] = 0.0
        return 0.0, max(-torque, HOLD * car.brakes.torque)
    gear = _shift(car, state, speed, torque)
    gain = car.gears[gear] * car.efficiency
    overrun = -car.overrun * min(max(speed, 0.0), 1.0)
    engine = min(max(torque / gain, overrun), _reach(car, gear, speed) / gain)
    return engine, max(engine * gain - torque, 0.0) if torque < 0.0 else 0.0


@inlined
def _wheel_speed(car, state, w, speed, yaw_rate):
    """Speed of a wheel's centre along the wheel [m/s], no side slip of the rear axle assumed."""
    along = speed - car.half_track[w] * yaw_rate
    if w >= 2:
        return along
    return along * math.cos(state[STEER]) + car.wheelbase * yaw_rate * math.sin(state[STEER])


@inlined
def drive_torques(car, plan, state, time, motion, spin, force, load, drive, brake, step):
    """Writes drive torque and brake torque limit of each wheel [N m], shape (4,) each. motion: forward speed [m/s], yaw
    rate [rad/s] and climb of the body's x axis [-]; spin [rad/s], longitudinal tyre force and load [N], shape (4,)."""
    speed, yaw_rate, climb = motion
    i = min(int(max(time, 0.0) / PLAN_STEP), plan.speed.size - 1)
    state[GRADE] += (climb - state[GRADE]) * min(step / GRADE_LAG, 1.0)
    engine = 0.0
    wanted = 0.0
    if plan.mode[i] == SPEED or time < 0.0:  # before its start a drive settles at its first speed
        engine, wanted = _speed_control(car, plan, state, i, speed, step)
    elif plan.mode[i] == STOP:
        wanted = car.brakes.torque
    ratio = car.gears[int(state[GEAR])]
    turning = 0.0
    for w in range(4):
        turning += car.drive_share[w] * spin[w]
    turning *= ratio
    if engine > 0.0:
        engine *= min(max((LIMITER - turning) / LIMITER_BAND, 0.0), 1.0)
    axle = engine * ratio * car.efficiency
    lag = min(step / ENGINE_LAG, 1.0)
    state[ENGINE_TORQUE] += (engine - state[ENGINE_TORQUE]) * lag
    state[DRIVELINE_TORQUE] += (axle - state[DRIVELINE_TORQUE]) * lag
    wanted = min(wanted, car.brakes.torque)
    for w in range(4):
        drive[w] = car.drive_share[w] * state[DRIVELINE_TORQUE]
        along = _wheel_speed(car, state, w, speed, yaw_rate)
        brake[w] = anti_lock(car.brakes, w, wanted * car.brakes.share[w], along, spin[w], force[w], load[w])
    if speed > LOCK_SPEED:  # select low: the rear wheels keep their side force on a road of unequal friction
        brake[2] = brake[3] = min(brake[2], brake[3])
