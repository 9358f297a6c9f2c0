"""The simulation loop: the one place that steps MuJoCo. Compiled as a whole, free of Python and of the GIL.

One step, in this order:
    mj_step1        positions and velocities of every body at time t
    read all        driver, suspensions, tyres, inflation compute their forces from that state
    write all       xfrc_applied (tyres, air, drive), qfrc_applied (struts, brakes), springs' references, stiffnesses
    mj_step2        accelerations and sensors at time t, then one implicitfast step
    trace           a row for time t
Forces are held over the step, so the integration is of first order in the step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled, inlined
from testbed import trace
from testbed.brake_pull import PullPlan, pulled
from testbed.brakes import brake_moment
from testbed.driver import (
    DRIVELINE_TORQUE,
    ENGINE_TORQUE,
    PATH_ERROR,
    DriverCar,
    Plan,
    ackermann,
    drive_torques,
    steer,
)
from testbed.native import borrowed, call
from testbed.roads.friction import friction_at
from testbed.steering.active_steering import WHEEL, SteeringState, SteeringUnit, superposed
from testbed.suspension import Suspension, strut_force
from testbed.tyre import contact
from testbed.tyre.contact import TyreElement, sidewall_stiffness, torsional_stiffness, wheel_forces
from testbed.tyre.inflation import PRESSURE, TEMPERATURE, Inflation, inflate
from testbed.wind import air_force

INFLATION_STRIDE = 10  # steps between two updates of the gas: it changes over seconds
DIVERGED, ROLLED_OVER, LEFT_WINDOW, DONE = range(4)
STEEPEST = 0.3  # cosine of the body's tilt beyond which it lies on its side: nothing holds it up there
LARGEST_SPEED = 150.0  # m/s; beyond it the drive has diverged


class Views(NamedTuple):
    """MuJoCo's own arrays (no copies) and addresses."""

    step1: int
    step2: int
    model: int
    data: int
    qpos: NDArray[np.float64]
    qvel: NDArray[np.float64]
    xpos: NDArray[np.float64]
    xquat: NDArray[np.float64]
    xmat: NDArray[np.float64]
    cvel: NDArray[np.float64]
    com: NDArray[np.float64]
    xfrc: NDArray[np.float64]
    qfrc: NDArray[np.float64]
    sensors: NDArray[np.float64]
    joint_stiffness: NDArray[np.float64]
    tendon_stiffness: NDArray[np.float64]
    spring_reference: NDArray[np.float64]


class Index(NamedTuple):
    """Where the car's parts are in MuJoCo's arrays, shape (4,) each, wheels fl fr rl rr."""

    chassis: int
    knuckle: NDArray[np.int64]
    rim: NDArray[np.int64]
    belt: NDArray[np.int64]
    travel_q: NDArray[np.int64]
    travel_v: NDArray[np.int64]
    steer_q: NDArray[np.int64]
    spin_q: NDArray[np.int64]
    spin_v: NDArray[np.int64]
    belt_x: NDArray[np.int64]  # joint
    belt_z: NDArray[np.int64]  # joint
    torsion: NDArray[np.int64]  # tendon
    hub_accel: NDArray[np.int64]
    body_accel: NDArray[np.int64]
    accel: int
    gyro: int


class Constants(NamedTuple):
    """Everything that stays as it is during the drive."""

    step: float
    tyre: TyreElement
    suspension: Suspension
    driver: DriverCar
    plan: Plan
    inflation: Inflation
    pulls: PullPlan
    friction_edges: NDArray[np.float64]
    friction_left: NDArray[np.float64]
    friction_right: NDArray[np.float64]
    radius_factor: NDArray[np.float64]
    spin_inertia: NDArray[np.float64]
    drag_area: float  # half rho cd A [kg/m]
    side_area: float  # half rho (side-force slope - cd) A [kg/m]: what wind from the side adds to its share of the drag
    pressure_point: float  # where that acts, ahead of the centre of gravity [m]
    wind: NDArray[np.float64]  # air velocity every `wind.STEP` [m/s], shape (n, 2)
    steering_ratio: float  # of the car without active steering
    active_steering: SteeringUnit


class State(NamedTuple):
    """What the force elements remember."""

    clock: NDArray[np.int64]  # steps done, shape (1,)
    driver: NDArray[np.float64]
    tyres: NDArray[np.float64]  # (4, 5)
    gas: NDArray[np.float64]  # (4, 3)
    leak_span: NDArray[np.float64]
    bristle: NDArray[np.float64]
    outputs: NDArray[np.float64]  # (4, 13)
    work: NDArray[np.float64]  # (6,) J
    steering_motor: NDArray[np.float64]  # these three: see `SteeringState`
    steering_control: NDArray[np.float64]
    steering_unit: NDArray[np.float64]


_START = {name: part.start for name, part in trace.COLUMNS.items()}
_TIME, _POSITION, _VELOCITY = _START["time"], _START["position"], _START["velocity"]
_ACCEL, _GYRO, _BODY, _HUB = _START["accel"], _START["gyro"], _START["body_accel_z"], _START["hub_accel_z"]
_RIM_ANGLE, _RIM_SPEED, _BELT_SPEED = _START["rim_angle"], _START["rim_speed"], _START["belt_speed"]
_TRAVEL, _STEERING, _ENGINE = _START["travel"], _START["steering_wheel"], _START["engine_torque"]
_DRIVELINE, _PATH_ERROR = _START["driveline_torque"], _START["path_error"]
_PRESSURE, _TEMPERATURE = _START["pressure"], _START["temperature"]
_MOTOR = _START["motor_angle"]
_OUTPUT, _WORK = _START[contact.OUTPUT[0]], _START["work"]
_AIR, _SLIP, _ROLLING, _BRAKE, _DRIVE, _STRUT = range(len(trace.WORK))


@inlined
def set_stiffness(views, ix, tyre, gas):
    """Writes the sidewall and torsion stiffness of each tyre's pressure into the model."""
    for w in range(4):
        translation = sidewall_stiffness(tyre, gas[w, PRESSURE])
        views.joint_stiffness[ix.belt_x[w]] = translation
        views.joint_stiffness[ix.belt_z[w]] = translation
        views.tendon_stiffness[ix.torsion[w]] = torsional_stiffness(tyre, gas[w, PRESSURE])


@inlined
def _wheel(w, views, ix, c, s, heights, origin, row, centre, velocity, axis, wrench):
    """Suspension and tyre of one wheel: reads the state, writes its forces."""
    side = 1.0 if w % 2 == 0 else -1.0
    sus = c.suspension
    travel, rate = views.qpos[ix.travel_q[w]], views.qvel[ix.travel_v[w]]
    force = strut_force(sus, w, travel, rate)
    views.qfrc[ix.travel_v[w]] = -force
    damping = sus.compression[w] if rate > 0.0 else sus.rebound[w]
    s.work[_STRUT] += damping * rate * rate * c.step

    knuckle, belt, rim = ix.knuckle[w], ix.belt[w], ix.rim[w]
    lean = -side * (sus.camber_static[w] + sus.camber_gain[w] * travel)
    cos_lean, sin_lean = math.cos(lean), math.sin(lean)
    spin = 0.0
    for i in range(3):
        axis[i] = cos_lean * views.xmat[knuckle, 3 * i + 1] + sin_lean * views.xmat[knuckle, 3 * i + 2]
        centre[i] = views.xpos[belt, i]
        spin += views.cvel[belt, i] * axis[i]
    arm_x = centre[0] - views.com[ix.chassis, 0]
    arm_y = centre[1] - views.com[ix.chassis, 1]
    arm_z = centre[2] - views.com[ix.chassis, 2]
    turn_x, turn_y, turn_z = views.cvel[belt, 0], views.cvel[belt, 1], views.cvel[belt, 2]
    velocity[0] = views.cvel[belt, 3] + turn_y * arm_z - turn_z * arm_y
    velocity[1] = views.cvel[belt, 4] + turn_z * arm_x - turn_x * arm_z
    velocity[2] = views.cvel[belt, 5] + turn_x * arm_y - turn_y * arm_x
    friction = friction_at(centre[0], centre[1], c.friction_edges, c.friction_left, c.friction_right)
    rim_load = wheel_forces(
        c.tyre, heights, origin, s.tyres[w], s.outputs[w], wrench, centre, centre[2] - views.xpos[rim, 2], velocity,
        views.cvel[belt], spin, axis, s.gas[w, PRESSURE], c.radius_factor[w], friction, side, c.step,
    )  # fmt: skip
    for i in range(6):
        views.xfrc[belt, i] = wrench[i]
        views.xfrc[rim, i] = 0.0
    views.xfrc[rim, 2] = rim_load
    s.work[_SLIP] += s.outputs[w, contact.SLIP_LOSS] * c.step
    s.work[_ROLLING] += s.outputs[w, contact.DRAG_LOSS] * c.step
    row[_RIM_ANGLE + w] = views.qpos[ix.spin_q[w]]
    row[_RIM_SPEED + w] = views.qvel[ix.spin_v[w]]
    row[_BELT_SPEED + w] = spin
    row[_TRAVEL + w] = travel


@inlined
def _torques(views, ix, c, s, time, speed, spins, drive, brake):
    """Drive and brake torques onto rims, chassis and knuckles."""
    motion = speed, views.qvel[5], views.xmat[ix.chassis, 6]
    force, load = s.outputs[:, contact.FX], s.outputs[:, contact.LOAD]
    for w in range(4):
        spins[w] = views.qvel[ix.spin_v[w]]
    drive_torques(c.driver, c.plan, s.driver, time, motion, spins, force, load, drive, brake, c.step)
    for w in range(4):
        brake[w] = pulled(c.pulls, w, time, brake[w])
        knuckle, rim = ix.knuckle[w], ix.rim[w]
        spin = spins[w]
        moment = brake_moment(s.bristle, w, brake[w], spin, c.spin_inertia[w], c.step)
        views.qfrc[ix.spin_v[w]] = moment
        s.work[_BRAKE] -= moment * spin * c.step
        if drive[w] != 0.0:
            for i in range(3):
                along = views.xmat[knuckle, 3 * i + 1]
                across = views.xmat[ix.chassis, 3 * i + 1]
                views.xfrc[rim, 3 + i] += drive[w] * along
                views.xfrc[ix.chassis, 3 + i] -= drive[w] * across
                turn = views.cvel[rim, i] * along - views.cvel[ix.chassis, i] * across
                s.work[_DRIVE] += drive[w] * turn * c.step


@inlined
def _chassis(views, ix, c, s, time, row):
    """Air drag, the wind's side force, and steering; returns the forward speed [m/s]."""
    vx, vy = views.qvel[0], views.qvel[1]
    cos_heading, sin_heading = views.xmat[ix.chassis, 0], views.xmat[ix.chassis, 3]
    force_x, force_y, cross = air_force(c.wind, time, c.drag_area, c.side_area, vx, vy, cos_heading, sin_heading)
    for i in range(6):
        views.xfrc[ix.chassis, i] = 0.0
    views.xfrc[ix.chassis, 0], views.xfrc[ix.chassis, 1] = force_x, force_y
    views.xfrc[ix.chassis, 5] = cross * c.pressure_point
    s.work[_AIR] -= (force_x * vx + force_y * vy) * c.step
    speed = vx * cos_heading + vy * sin_heading + views.qvel[2] * views.xmat[ix.chassis, 6]
    heading = math.atan2(sin_heading, cos_heading)
    angle = steer(c.driver, c.plan, s.driver, views.qpos[0], views.qpos[1], heading, speed, c.step)
    row[_STEERING] = angle * c.steering_ratio
    if c.active_steering.present:
        state = SteeringState(s.steering_motor, s.steering_control, s.steering_unit)
        moment, due = s.outputs[0, contact.MZ] + s.outputs[1, contact.MZ], s.clock[0] % c.active_steering.task == 0
        angle = superposed(c.active_steering, state, angle, speed, moment, time, due, c.step, row[_MOTOR : _MOTOR + 7])
        row[_STEERING] = s.steering_unit[WHEEL]
    else:
        for i in range(7):
            row[_MOTOR + i] = 0.0
    left, right = ackermann(c.driver, angle)
    sus = c.suspension
    for w in range(4):
        side = 1.0 if w % 2 == 0 else -1.0
        toe = sus.toe_static[w] + sus.toe_gain[w] * views.qpos[ix.travel_q[w]]
        commanded = (left if w == 0 else right) if w < 2 else 0.0
        views.spring_reference[ix.steer_q[w]] = commanded - side * toe
    row[_TIME] = time
    for i in range(7):
        row[_POSITION + i] = views.qpos[i]
    for i in range(3):
        row[_VELOCITY + i] = views.qvel[i]
    return speed


@inlined
def _finish_row(views, ix, s, row):
    for i in range(3):
        row[_ACCEL + i] = views.sensors[ix.accel + i]
        row[_GYRO + i] = views.sensors[ix.gyro + i]
    for w in range(4):
        row[_BODY + w] = views.sensors[ix.body_accel[w] + 2]
        row[_HUB + w] = views.sensors[ix.hub_accel[w] + 2]
        row[_PRESSURE + w] = s.gas[w, PRESSURE]
        row[_TEMPERATURE + w] = s.gas[w, TEMPERATURE]
        for j in range(s.outputs.shape[1]):
            row[_OUTPUT + 4 * j + w] = s.outputs[w, j]
    row[_ENGINE] = s.driver[ENGINE_TORQUE]
    row[_DRIVELINE] = s.driver[DRIVELINE_TORQUE]
    row[_PATH_ERROR] = s.driver[PATH_ERROR]
    for i in range(s.work.size):
        row[_WORK + i] = s.work[i]


@compiled
def run(views, ix, c, s, heights, origin, room, rows, poses, pose_stride):
    """Steps until `rows` is full, the car has moved `room` along x or y [m], or the drive diverges.

    rows: trace, shape (n, WIDTH); poses: body positions and quaternions, shape (m, bodies, 7), one every `pose_stride`
    steps of the clock. Returns how it ended (DONE, LEFT_WINDOW, ROLLED_OVER, DIVERGED), rows written, poses written.
    """
    views, ix, c, s = borrowed(views), borrowed(ix), borrowed(c), borrowed(s)
    heights, origin, rows, poses = borrowed(heights), borrowed(origin), borrowed(rows), borrowed(poses)
    centre, velocity, axis, wrench = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(6)
    spins, drive, brake, heating = np.zeros(4), np.zeros(4), np.zeros(4), np.zeros(4)
    x0, y0 = views.qpos[0], views.qpos[1]
    taken = 0
    for k in range(rows.shape[0]):
        row = rows[k]
        time = s.clock[0] * c.step
        call(views.step1, views.model, views.data)
        if s.clock[0] % INFLATION_STRIDE == 0:
            for w in range(4):
                heating[w] = s.outputs[w, contact.DRAG_LOSS]
            inflate(c.inflation, s.gas, s.leak_span, heating, time, INFLATION_STRIDE * c.step)
            set_stiffness(views, ix, c.tyre, s.gas)
        speed = _chassis(views, ix, c, s, time, row)
        for w in range(4):
            _wheel(w, views, ix, c, s, heights, origin, row, centre, velocity, axis, wrench)
        _torques(views, ix, c, s, time, speed, spins, drive, brake)
        if s.clock[0] % pose_stride == 0 and taken < poses.shape[0]:
            poses[taken, :, :3] = views.xpos
            poses[taken, :, 3:] = views.xquat
            taken += 1
        call(views.step2, views.model, views.data)
        _finish_row(views, ix, s, row)
        s.clock[0] += 1
        if not (abs(views.qvel[0]) + abs(views.qvel[1]) + abs(views.qvel[2]) < LARGEST_SPEED):
            return DIVERGED, k + 1, taken
        if views.xmat[ix.chassis, 8] < STEEPEST:
            return ROLLED_OVER, k + 1, taken
        if abs(views.qpos[0] - x0) > room[0] or abs(views.qpos[1] - y0) > room[1]:
            return LEFT_WINDOW, k + 1, taken
    return DONE, rows.shape[0], taken
