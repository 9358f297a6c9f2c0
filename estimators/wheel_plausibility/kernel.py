"""Speed of the car from four wheels and the accelerometer, and how far each wheel is off it, cell by cell.

Kalman filter of x = [v, b]: v forward speed of the car's middle line, b what the accelerometer says too much (grade,
pitch, offset), a random walk:

    dv/dt = f_x + r v_y - b,      v_y = r l_r (1 - v^2 / V_SLIP^2) sideways at the centre of gravity
    v_i   = v + slip              each wheel (`geometry.car_speeds`), variance grown by speed, push and curve

A wheel counts with the weight of a Student t (STUDENT degrees): one that is far off counts little at once, and one that
is accused not at all. Under a push a tyre slips to one side only: braked it turns too slowly, driven too fast. So of
the wheels that brake the fastest tells most of v: on the other side only FREE of a slip's variance is reckoned with.
Evidence: z_i = how far |v_i - v| is beyond what v itself is unsure of and what a tyre slips under this push;

    g_i <- max(g_i + (z_i - nu) / h dt, 0),  up and down;  accused above 1;  taken back after BACK_AFTER near v

with nu, h of the side (`thresholds`).
If no wheel is left, v follows the accelerometer and its variance says how badly. Once all that say something agree with
one another for as long as RESTART they are believed again. Left out: brake torque, unlike radii, roll of the body.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.car import GRAVITY, Car
from estimators.compiled import compiled
from estimators.wheel_plausibility.geometry import car_speeds

STEP = 0.02  # s
V_SLIP = 20.0  # m/s at which a car's side slip changes its sign, declared
WALK_SPEED, WALK_OFFSET = 0.05, 0.15  # m/s, m/s^2 per sqrt(s), declared: the grade changes within seconds
NOISE, PER_SPEED, PER_PUSH, PER_CURVE = 0.05, 0.005, 0.04, 0.02  # m/s; of v; of v a/g; of v r times 1 s. Declared
COMMON = 1.0  # s for which the slip of a push lasts, on all wheels alike: so long it counts as one observation
SLIPS, SLIPS_MOST = 0.1, 0.4  # of v a/g, m/s: what a tyre under anti-lock control slips is no error. Declared
PUSHED = 1.0  # m/s^2 from which on the push says to which side a tyre slips. Declared
STUDENT, MOST = 3.0, 2.0  # MOST: of the evidence
NEAR, BACK_AFTER = 0.6, 1.0  # m/s, s
RESTART, TOGETHER = 3.0, 0.6  # s, m/s
FREE = 0.03  # of a slip's variance, on the side to which no tyre slips
UNSURE = 2.0  # standard deviations of v that no wheel is blamed for
WILD = 200.0  # m/s, m/s^2, rad/s: beyond any car
# columns of what is said
SPEED, STD, ERROR, EVIDENCE, ACCUSED, SAID = 0, 1, slice(2, 6), slice(6, 10), slice(10, 14), 14
FIRST_OFFSET, GROWN = 0.5, 50.0  # m/s^2, m/s: std of b at first, of v at most


class Constants(NamedTuple):
    """Of the car, SI. dive: share by which the body's pitch under its own springs overstates an acceleration."""

    radius: float
    front: float
    rear: float
    front_half: float
    rear_half: float
    ratio: float
    dive: float


def constants(car: Car) -> Constants:
    """What the kernel needs of it."""
    pitch_stiffness = 2.0 * (
        car.front_spring_rate * car.cg_to_front_axle**2 + car.rear_spring_rate * car.cg_to_rear_axle**2
    )
    return Constants(
        car.rolling_radius, car.cg_to_front_axle, car.cg_to_rear_axle, 0.5 * car.front_track, 0.5 * car.rear_track,
        car.steering_ratio, GRAVITY * car.chassis_mass * car.cg_height / pitch_stiffness,
    )  # fmt: skip


class State(NamedTuple):
    """x (2,), P (2, 2); g up and down (2, 4); accused, time near v (4,); [cell of the last step, time in which all
    agree, last yaw rate, last steering angle]."""

    x: NDArray[np.float64]
    P: NDArray[np.float64]
    g: NDArray[np.float64]
    accused: NDArray[np.float64]
    near: NDArray[np.float64]
    clock: NDArray[np.float64]


def new_state() -> State:
    """Before a drive: the first cell's wheels tell the speed."""
    return State(
        np.full(2, np.nan),
        np.zeros((2, 2)),
        np.zeros((2, 4)),
        np.zeros(4),
        np.zeros(4),
        np.array([-1.0, 0.0, 0.0, 0.0]),
    )


@compiled
def sideways_speed(c, v, turn):
    """v_y at the centre of gravity [m/s] in a steady curve."""
    return turn * c.rear * min(max(1.0 - (v / V_SLIP) ** 2, -1.0), 1.0)


@compiled
def _sane(value, instead):
    return value if abs(value) < WILD else instead


@compiled
def _begin(s, speeds):
    """v from the median of the wheels that speak."""
    spoken = speeds[np.isfinite(speeds)]
    if len(spoken) == 0:
        return False
    s.x[0], s.x[1] = np.median(spoken), 0.0
    s.P[:, :] = 0.0
    s.P[0, 0], s.P[1, 1] = 1.0, FIRST_OFFSET**2
    return True


@compiled
def _predict(s, push, known, dt):
    """push: f_x + r v_y; known: an accelerometer speaks."""
    x, P = s.x, s.P
    x[0] += (push - x[1]) * dt if known else 0.0
    walk = WALK_SPEED**2 * dt if known else 9.0 * dt
    P[0, 0] += -2.0 * dt * P[0, 1] + dt * dt * P[1, 1] + walk
    P[0, 1] -= dt * P[1, 1]
    P[1, 0] = P[0, 1]
    P[1, 1] += WALK_OFFSET**2 * dt
    P[0, 0] = min(P[0, 0], GROWN**2)
    P[1, 1] = min(P[1, 1], 4.0)


@compiled
def _take(s, value, variance):
    """One wheel, with a Student t's weight."""
    x, P = s.x, s.P
    nu = value - x[0]
    weight = (STUDENT + 1.0) / (STUDENT + nu * nu / (P[0, 0] + variance))
    S = P[0, 0] + variance / weight
    k0, k1 = P[0, 0] / S, P[1, 0] / S
    x[0] += k0 * nu
    x[1] += k1 * nu
    p00, p01, p11 = P[0, 0], P[0, 1], P[1, 1]
    P[0, 0] = p00 - k0 * p00
    P[0, 1] = P[1, 0] = p01 - k0 * p01
    P[1, 1] = p11 - k1 * p01


@compiled
def follow(c, s, limits, index, cells, said):
    """Cells in order: index (n,), cells (n, 7): four wheel speeds [rad/s], f_x, yaw rate, steering-wheel angle; NaN
    where missing. limits (2, 2): nu [m/s], h [m] of a side to which no tyre slips, and of one to which it may. Fills
    said (n, SAID): v, its std, v_i - v (4), g (4), accused (4)."""
    speeds, allowed, judged = np.empty(4), np.empty(2), np.empty((2, 2))
    for k in range(len(index)):
        missed = index[k] - s.clock[0] if s.clock[0] >= 0 else 1.0
        s.clock[0] = index[k]
        dt = min(max(missed, 1.0), 500.0) * STEP
        turn = _sane(cells[k, 5], np.nan)
        steer = _sane(cells[k, 6], np.nan) / c.ratio
        v = s.x[0] if math.isfinite(s.x[0]) else 0.0
        if not math.isfinite(turn):
            turn = v * math.tan(min(max(steer, -0.7), 0.7)) / (c.front + c.rear) if math.isfinite(steer) else 0.0
        if not math.isfinite(steer):
            steer = math.atan(turn * (c.front + c.rear) / max(abs(v), 1.0))
        steer = min(max(steer, -0.7), 0.7)
        sideways = sideways_speed(c, v, turn)
        rolling = cells[k, :4] * c.radius
        for i in range(4):
            rolling[i] = _sane(rolling[i], np.nan)
        car_speeds(rolling, turn, sideways, steer, c.front, c.rear, c.front_half, c.rear_half, speeds)
        if not math.isfinite(s.x[0]) and not _begin(s, speeds):
            said[k] = np.nan
            continue
        push = cells[k, 4]
        known = abs(push) < WILD and missed <= 1.0
        _predict(s, push / (1.0 + c.dive) + turn * sideways if known else 0.0, known, dt)
        hard = min(abs(push), 10.0) if known else 5.0
        v = abs(s.x[0])
        slip = (PER_PUSH * v * hard / GRAVITY) ** 2 * 4.0 * COMMON / STEP
        plain = NOISE**2 + (PER_SPEED * v) ** 2 + (PER_CURVE * v * turn) ** 2
        unsure = UNSURE * math.sqrt(s.P[0, 0])
        slips = unsure + min(SLIPS * v * hard / GRAVITY, SLIPS_MOST)
        slow = not known or push < PUSHED  # a tyre may turn too slowly, too fast: slip is on the side of the push
        fast = not known or push > -PUSHED
        allowed[0], allowed[1] = slips if fast else unsure, slips if slow else unsure
        judged[0], judged[1] = limits[int(fast)], limits[int(slow)]
        before = s.x[0]
        for i in range(4):
            if math.isfinite(speeds[i]) and s.accused[i] == 0.0:
                _take(s, speeds[i], plain + (slip if (fast if speeds[i] > s.x[0] else slow) else FREE * slip))
        _judge(s, speeds, before, allowed, judged, dt)
        _restart(s, speeds, dt)
        said[k, 0], said[k, 1] = s.x[0], math.sqrt(max(s.P[0, 0], 0.0))
        for i in range(4):
            said[k, 2 + i] = speeds[i] - s.x[0]
            said[k, 6 + i] = max(s.g[0, i], s.g[1, i])
            said[k, 10 + i] = s.accused[i]


@compiled
def _judge(s, speeds, before, allowed, limits, dt):
    """Evidence against each wheel; accused, taken back. allowed [m/s], limits (2, 2): too fast, too slow."""
    for i in range(4):
        if not math.isfinite(speeds[i]):
            continue
        off = speeds[i] - before
        for side in range(2):
            z = max((off if side == 0 else -off) - allowed[side], 0.0)
            s.g[side, i] = min(max(s.g[side, i] + (z - limits[side, 0]) / limits[side, 1] * dt, 0.0), MOST)
        s.near[i] = s.near[i] + dt if abs(off) < NEAR else 0.0
        if max(s.g[0, i], s.g[1, i]) > 1.0:
            s.accused[i] = 1.0
        elif s.accused[i] > 0.0 and s.near[i] >= BACK_AFTER:
            s.accused[i] = 0.0


@compiled
def _restart(s, speeds, dt):
    """All wheels accused, yet of one mind for long: they are right."""
    spoken = speeds[np.isfinite(speeds)]
    lonely = len(spoken) >= 3 and s.accused.sum() >= 3.0 and spoken.max() - spoken.min() < TOGETHER
    s.clock[1] = s.clock[1] + dt if lonely else 0.0
    if s.clock[1] >= RESTART and _begin(s, speeds):
        s.clock[1] = 0.0
        s.g[:, :] = 0.0
        s.accused[:] = 0.0
