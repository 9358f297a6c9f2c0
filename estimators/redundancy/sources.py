"""Yaw rate and longitudinal specific force, each four times, from what a car's bus carries in a cell of 50 ms.

Axes as ISO 8855, R nominal radius, t track, d road-wheel angle, r yaw rate, v speed at the rear axle, a_y = v r.

    yaw rate      gyro       r_z                                    nuisance: offset
                  front      (v_fr^2 - v_fl^2) / (2 v_f t_f)        e v + l v a_y: radii differ, load changes them;
                                                                  driven: slip of the lighter inner wheel
                  rear       (v_rr - v_rl) / t_r                    the same
                  steering   v tan d / (L + K v^2), lagged by LAG v  zero of the sensor, K
    specific      imu        f_x + r v_y                            -  (its offset is the grade's)
    force         torque     (T/R - rho c A v^2 / 2) / m            offset, mass, drag; silent where brakes may act
                  front      dv_f/dt + I                            grade, offset of the pitch rate; driven: slip
                  rear       dv/dt + I                              the same

v_f^2 = (v_fl^2 + v_fr^2) / 2 - r^2 (L^2 + t_f^2 / 4): each front wheel rolls square to the line to the turning centre,
so no steering angle is needed. v_y = r l_r (1 - v^2 / V_SLIP^2) is the sideways speed at the centre of gravity. I is
the change of g sin(pitch), from the pitch rate -(w_y - w_z phi), phi = (f_y - v r) / g the roll, through a high pass of
PITCH_MEMORY: so a grade that begins moves accelerometer and wheels alike, a bias does not. Speeds are differenced over
WINDOW cells and everything beside them is the mean over the same time. Left out: brake torque (no signal), tyre slip
beyond the noise that grows with accelerations, wind."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.car import AIR_DENSITY, GRAVITY, Car
from estimators.compiled import compiled
from estimators.grid import Channel

STEP = 0.05  # s
WINDOW = 10  # cells: 0.5 s
CHANNELS = (
    *(Channel(f"wheel/{wheel}/speed") for wheel in ("fl", "fr", "rl", "rr")),
    *(Channel("imu/gyro", axis) for axis in range(3)),
    *(Channel("imu/accel", axis) for axis in range(2)),
    Channel("driveline/torque"),
    Channel("steering/angle"),
)
YAW, FORCE = ("gyro", "front", "rear", "steering"), ("accelerometer", "front", "rear", "torque")
SLOWEST = 2.0  # m/s, below which wheel speeds come too seldom to be compared
UNDERSTEER = 0.002  # K [s^2/m], declared; the nuisance corrects it
LAG = 0.005  # s of the yaw rate behind the steering, for each m/s
V_SLIP = 20.0  # m/s at which the body's side slip changes its sign, declared
PITCH_MEMORY = 60.0  # s
SLIP_OF_PULL = 0.035  # slip over (driving force / load) of a driven wheel, declared; theta corrects it
INNER_SLIP = (
    0.05  # what the lighter inner wheel slips more, over pull and lateral acceleration in g; declared, the same
)
ROUGH_SLIP = 0.04  # noise of a driven wheel's slip, over pull: its load dances, on class D by a quarter
SLIP = 0.004  # [s/m] noise of a speed's change that slip under acceleration makes, over v a
LEAST_DRIVE = 0.0  # N m of driving torque above which no driver brakes
WILD = 200.0  # m/s, rad/s, m/s^2: beyond any car
# standard deviations of the nuisances before a drive, and how far they walk in an hour
YAW_PRIOR = np.array([0.01, 3e-3, 3e-4, 3e-3, 3e-4, 2e-3, 1.0, 0.04])
FORCE_PRIOR = np.array([0.2, 0.15, 0.8, 3e-3, 0.1, 0.02])
YAW_WALK = (np.array([2e-3, 1e-3, 1e-4, 1e-3, 1e-4, 1e-3, 0.2, 0.04])) ** 2 * STEP / 3600.0
FORCE_WALK = np.array([1.0, 0.2, 1.5, 2e-3, 0.2, 0.02]) ** 2 * STEP / 3600.0
# where noise is learnt, and the standard deviation that it begins with
YAW_NOISE = np.array([0.001, 0.02, 0.02, 0.003])
FORCE_NOISE = np.array([0.03, 0.2, 0.2, 0.03])
ADAPTIVE_YAW = np.array([1.0, 1.0, 1.0, 1.0])
ADAPTIVE_FORCE = np.array([1.0, 1.0, 1.0, 1.0])


class Constants(NamedTuple):
    """Of the car, SI. front_pull, rear_pull: what an axle drives, over its load, for each N m of the driveline."""

    radius: float
    front_track: float
    rear_track: float
    wheelbase: float
    to_rear: float
    ratio: float
    mass: float
    drag: float
    front_pull: float
    rear_pull: float


def constants(car: Car) -> Constants:
    """What the sources need of it."""
    shares = {"front": (1.0, 0.0), "rear": (0.0, 1.0), "all": (0.5, 0.5)}[car.driven_axle]
    levers = (car.cg_to_rear_axle, car.cg_to_front_axle)
    pulls = [
        share * car.wheelbase / (car.rolling_radius * car.mass * GRAVITY * lever)
        for share, lever in zip(shares, levers, strict=True)
    ]
    return Constants(
        car.rolling_radius, car.front_track, car.rear_track, car.wheelbase, car.cg_to_rear_axle, car.steering_ratio,
        car.mass, 0.5 * AIR_DENSITY * car.drag_area, *pulls,
    )  # fmt: skip


class Past(NamedTuple):
    """lagged: steering's yaw rate, I and what an offset of 1 rad/s adds to I, (3,); ring: v_front, v_rear, f_x, f_T, I,
    v times the pull of the front and of the rear axle, of the last cells, (WINDOW + 1, 7)."""

    lagged: NDArray[np.float64]
    ring: NDArray[np.float64]


def new_past() -> Past:
    """Before a drive."""
    return Past(np.zeros(3), np.full((WINDOW + 1, 7), np.nan))


@compiled
def forget(past):
    """After a gap: nothing to difference with."""
    past.ring[:, :] = np.nan


@compiled
def front_speed(c, left, right, turn):
    """v_f: speed of the rear axle [m/s] that the front wheels tell at a yaw rate [rad/s]."""
    square = 0.5 * (left * left + right * right) - turn * turn * (c.wheelbase**2 + 0.25 * c.front_track**2)
    return math.sqrt(max(square, 0.0)) if math.isfinite(square) else np.nan


@compiled
def yaw_sources(c, past, cell, y, h, r):
    """Fills y (4,), h (4, 8), r (4,) of the yaw rate. cell: the channels' values, NaN where missing, (11,). Returns the
    speed v [m/s], NaN where unknown."""
    fl, fr, rl, rr = cell[0] * c.radius, cell[1] * c.radius, cell[2] * c.radius, cell[3] * c.radius
    gyro, steer = cell[6], cell[10] / c.ratio
    y[:], h[:, :] = np.nan, 0.0
    v = 0.5 * (rl + rr)
    if not math.isfinite(v):
        v = 0.5 * (fl + fr)
    angle, ahead = steer if math.isfinite(steer) else 0.0, 0.0
    rolls = v >= SLOWEST or v == 0.0
    if abs(gyro) < WILD:
        y[0] = gyro
    if rolls and v < WILD:
        turns = v * math.tan(angle) / c.wheelbase
        y[1] = (fr * fr - fl * fl) / (2.0 * c.front_track * max(front_speed(c, fl, fr, turns), SLOWEST))
        y[2] = (rr - rl) / c.rear_track
        stretch = c.wheelbase + UNDERSTEER * v * v
        wanted = v * math.tan(steer) / stretch
        if math.isfinite(wanted):
            ahead = wanted - past.lagged[0]
            past.lagged[0] += STEP / (STEP + LAG * v) * ahead
            y[3] = past.lagged[0]
            h[3, 5], h[3, 6] = v / stretch, past.lagged[0] * UNDERSTEER * v * v / stretch
    turn = abs(y[3]) if math.isfinite(y[3]) else abs(gyro) if math.isfinite(gyro) else 0.0
    side = v * (y[3] if math.isfinite(y[3]) else gyro)
    side = min(max(side, -10.0), 10.0) if math.isfinite(side) else 0.0
    rolling = min(abs(cell[4]), 1.0) if math.isfinite(cell[4]) else 0.0
    h[0, 0] = 1.0
    if math.isfinite(v):
        h[1, 1] = h[2, 3] = v
        h[1, 2] = h[2, 4] = v * side
    pull = cell[9] if abs(cell[9]) < 1e5 else 0.0
    if math.isfinite(v):
        leaning = min(max(cell[8] / GRAVITY, -1.0), 1.0) if math.isfinite(cell[8]) else side / GRAVITY  # a bank, too
        h[1, 7] = -c.front_pull * pull * leaning * v / c.front_track
        h[2, 7] = -c.rear_pull * pull * leaning * v / c.rear_track
    y[1] -= INNER_SLIP * h[1, 7]
    y[2] -= INNER_SLIP * h[2, 7]
    r[0] = (1e-3) ** 2 + (0.005 * turn) ** 2 + (0.05 * rolling) ** 2
    r[1] = (2e-3) ** 2 + (0.010 * side) ** 2
    r[2] = (1e-3) ** 2 + (0.004 * side) ** 2
    if math.isfinite(v):
        r[1] += (ROUGH_SLIP * c.front_pull * pull * v / c.front_track) ** 2
        r[2] += (ROUGH_SLIP * c.rear_pull * pull * v / c.rear_track) ** 2
    r[3] = (1e-3) ** 2 + (0.005 * side) ** 2 + (0.02 * turn) ** 2 + (0.5 * ahead) ** 2
    return v


@compiled
def force_sources(c, past, cell, v, turn, y, h, r):
    """Fills y (4,), h (4, 6), r (4,) of the specific force; v, turn: speed and yaw rate believed [m/s, rad/s]. Returns
    I, the change of g sin(pitch) [m/s^2]."""
    y[:], h[:, :] = np.nan, 0.0
    turn = turn if math.isfinite(turn) else 0.0
    ring = past.ring
    ring[:-1] = ring[1:].copy()
    ring[-1, 0] = front_speed(c, c.radius * cell[0], c.radius * cell[1], turn)
    ring[-1, 1] = 0.5 * c.radius * (cell[2] + cell[3])
    sideways = turn * c.to_rear * min(max(1.0 - (v / V_SLIP) ** 2, -1.0), 1.0) if math.isfinite(v) else 0.0
    ring[-1, 2] = cell[7] + turn * sideways if abs(cell[7]) < WILD else np.nan
    drives = cell[9] > LEAST_DRIVE and abs(cell[9]) < 1e5
    ring[-1, 3] = (cell[9] / c.radius - c.drag * v * v) / c.mass if drives else np.nan
    roll = (cell[8] - v * turn) / GRAVITY
    pitching = -(cell[5] - turn * min(max(roll, -0.3), 0.3))
    if abs(pitching) < WILD:
        past.lagged[1] += STEP * (GRAVITY * pitching - past.lagged[1] / PITCH_MEMORY)
        past.lagged[2] += STEP * (GRAVITY - past.lagged[2] / PITCH_MEMORY)
    ring[-1, 4] = past.lagged[1]
    pull = cell[9] if abs(cell[9]) < 1e5 else 0.0
    ring[-1, 5] = ring[-1, 0] * c.front_pull * pull
    ring[-1, 6] = ring[-1, 1] * c.rear_pull * pull
    mean, change = np.zeros(7), np.zeros(7)
    for j in range(7):
        change[j] = (ring[-1, j] - ring[0, j]) / (WINDOW * STEP)
        mean[j] = -0.5 * (ring[0, j] + ring[-1, j])
        for k in range(WINDOW + 1):
            mean[j] += ring[k, j]
        mean[j] /= WINDOW
    moves = ring[-1, 1] >= SLOWEST and ring[0, 1] >= SLOWEST
    moves = moves or (ring[-1, 0] >= SLOWEST and ring[0, 0] >= SLOWEST)
    y[0] = mean[2]
    if moves:
        y[1] = change[0] + mean[4] - SLIP_OF_PULL * change[5]
        y[2] = change[1] + mean[4] - SLIP_OF_PULL * change[6]
        h[1, 5], h[2, 5] = change[5], change[6]
        y[3] = mean[3]
    hard = min(abs(mean[2]), 10.0) if math.isfinite(mean[2]) else 0.0
    v = v if math.isfinite(v) else 0.0
    side = min(abs(v * turn), 10.0) if math.isfinite(v) else 0.0
    h[1, 2] = h[2, 2] = h[3, 0] = 1.0
    h[1, 3] = h[2, 3] = past.lagged[2]
    h[3, 4] = (v / V_SLIP) ** 2
    h[3, 1] = cell[9] / c.radius / c.mass if drives else 0.0
    r[0] = 0.01**2 + (0.007 * hard) ** 2 + (0.015 * side) ** 2
    r[1] = 0.03**2 + (SLIP * v * hard) ** 2 + (0.04 * side) ** 2
    r[2] = 0.025**2 + (SLIP * v * hard) ** 2 + (0.02 * side) ** 2
    r[3] = 0.01**2 + (0.03 * hard) ** 2 + (0.02 * side) ** 2
    return mean[4]
