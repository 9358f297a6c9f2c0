"""The body's and the hubs' accelerations against the inertial unit and one another, cell by cell.

ISO 8855 axes, (x_i, y_i) corner i from the centre of gravity, w the gyro, f the specific force. The body is rigid, a
hub stays at its corner, and a car's middle moves as its wheels and its gyro say:

    R_i = LI(b_i - f_z - w_z (w_x x_i + w_y y_i)) - y_i HP(w_x) + x_i HP(w_y)    [m/s]     body accelerometer b_i
    D_i = LI(LI(h_i - b_i))                                                      [m]       hub accelerometer h_i
    L_j = LI(f_y (1 - LEAN) - v r_j) - g LI(LI(w_x) - LEAN/g HP(f_y))            [m/s]     j: gyro, rear wheel pair

LI is a leaky integral, HP the high pass LI(d/dt), both with memory MEMORY: so no derivative of the gyro is needed, and
a hub that an accelerometer drives out of its travel gives the accelerometer away. LEAN is the share of g sin(roll) in
f_y. Each residual's own mean (offsets) and variance are learnt over LEARN from cells LAG old, so a fault is told before
it is learnt. A fault of one sensor has one pattern over R:

    b_i: e_i     f_z: (1, 1, 1, 1) / 2     w_x: y / |y|     w_y: x / |x|

q: the largest share of R in units of its std over the patterns; the pattern is the culprit. g <- max(g + q - DRIFT, 0)
alarms above h; while a pattern is accused the others are not judged, and nothing is learnt. It is taken back after BACK
(a gyro's after BACK_GYRO). D and L alike, each alone; D_i not while b_i is in doubt, L not while w_x is; L wants both j
of one sign. Left out: flexing of the body, sensors' heights, suspension angles."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.car import GRAVITY, Car
from estimators.compiled import compiled

STEP = 0.02  # s
MEMORY = 1.0  # s
LEARN, LAG = 8.0, 100  # s; cells: 2 s
JUDGED_AFTER = 500  # cells: 10 s
LEAN = 0.1  # declared: a car rolls by some 6 degrees for each g
FLOOR_R, FLOOR_D, FLOOR_L = 0.02, 0.01, 0.05  # std of R [m/s], D [m], L [m/s] that nothing goes below, declared
PER_CURVE = 0.05  # of v r: what a hard curve adds to the std of R and L, declared
DRIFT = 2.5  # std
LARGEST = 50.0  # std that count at the most
CALM, BACK = 3.0, 150  # std; cells: 3 s
BACK_GYRO = 3000  # cells: 60 s, since the high pass forgets an offset that stays
HOLD = 600  # cells for which L rests once w_x was in doubt: 12 s, until its mean is learnt anew
DOUBT = 0.5  # of the threshold from which on a sensor is in doubt
WILD = 1e3
RESIDUALS = 10  # R (4), D (4), L (2)
# culprits: body fl fr rl rr, f_z, w_x, w_y; hubs; f_y
BODY, FZ, WX, WY, HUB, FY, CULPRITS = 0, 4, 5, 6, 7, 11, 12
# columns of what a cell says: residuals less their means, std (10 each), q (6: rigid, hubs, lateral), culprit accused
# in this cell (or -2 - culprit taken back, -1 none) of each of the six judgements
OFF, STD, Q, EVENT, SAID = slice(0, 10), slice(10, 20), slice(20, 26), slice(26, 32), 32
# channels
AX, AY, AZ, GX, GY, GZ, BODIES, HUBS, SPEEDS = 0, 1, 2, 3, 4, 5, slice(6, 10), slice(10, 14), slice(14, 18)


class Constants(NamedTuple):
    """x, y: of the corners [m], (4,); patterns: unit vectors, (7, 4); radius, rear track [m]."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    patterns: NDArray[np.float64]
    radius: float
    rear_track: float


def constants(car: Car) -> Constants:
    """What the kernel needs of it."""
    front, rear = 0.5 * car.front_track, 0.5 * car.rear_track
    x = np.array([car.cg_to_front_axle] * 2 + [-car.cg_to_rear_axle] * 2)
    y = np.array([front, -front, rear, -rear])
    rows = [*np.eye(4), np.full(4, 0.5), y / np.linalg.norm(y), x / np.linalg.norm(x)]
    return Constants(x, y, np.array(rows), car.rolling_radius, car.rear_track)


class State(NamedTuple):
    """integral: leaky ones: 0-3 of R, 4-7 first and 8-11 second of D, 12, 13 of L, 14 of w_x, 15 of the lean (16,);
    high: high passes of w_x, w_y, f_y, and their last inputs (6,); mean, variance (10,); ring (LAG, 10); g, calm (6,);
    accused: culprit of each judgement, -1 none (6,); learnt: cells that each residual was learnt from (10,); clock:
    last cell, cells, cells for which L rests (3,)."""

    integral: NDArray[np.float64]
    high: NDArray[np.float64]
    mean: NDArray[np.float64]
    variance: NDArray[np.float64]
    ring: NDArray[np.float64]
    g: NDArray[np.float64]
    calm: NDArray[np.float64]
    accused: NDArray[np.int64]
    learnt: NDArray[np.int64]
    clock: NDArray[np.int64]


def new_state() -> State:
    """Before a drive."""
    return State(
        np.zeros(16), np.full(6, np.nan), np.zeros(RESIDUALS), np.zeros(RESIDUALS), np.full((LAG, RESIDUALS), np.nan),
        np.zeros(6), np.zeros(6), np.full(6, -1), np.zeros(RESIDUALS, np.int64), np.array([-1, 0, 0]),
    )  # fmt: skip


@compiled
def _leaky(s, i, value):
    """Integral i goes on; what is not finite lets it leak only."""
    step = STEP * value if abs(value) < WILD else 0.0
    s.integral[i] = (1.0 - STEP / MEMORY) * s.integral[i] + step
    return s.integral[i]


@compiled
def _high(s, i, value):
    """High pass i of a value; NaN keeps what it was."""
    last = s.high[3 + i]
    if not abs(value) < WILD:
        return s.high[i] if math.isfinite(s.high[i]) else 0.0
    before = s.high[i] if math.isfinite(s.high[i]) else 0.0
    s.high[i] = (1.0 - STEP / MEMORY) * before + (value - last if math.isfinite(last) else 0.0)
    s.high[3 + i] = value
    return s.high[i]


@compiled
def _residuals(c, s, cell, out):
    """Fills out (10,) of a cell (18,); NaN where a sensor is silent. Returns v r [m/s^2]."""
    wx, wy, wz = cell[GX], cell[GY], cell[GZ]
    roll, pitch = _high(s, 0, wx), _high(s, 1, wy)
    for i in range(4):
        body, hub = cell[6 + i], cell[10 + i]
        turning = wz * (wx * c.x[i] + wy * c.y[i]) if abs(wz) < WILD else 0.0
        out[i] = _leaky(s, i, body - cell[AZ] - turning) - c.y[i] * roll + c.x[i] * pitch
        if not (abs(body) < WILD and abs(cell[AZ]) < WILD and abs(wx) < WILD and abs(wy) < WILD):
            out[i] = np.nan
        out[4 + i] = _leaky(s, 8 + i, _leaky(s, 4 + i, hub - body))
        if not (abs(body) < WILD and abs(hub) < WILD):
            out[4 + i] = np.nan
    v = np.median(cell[SPEEDS]) * c.radius
    pair = (cell[17] - cell[16]) * c.radius / c.rear_track
    lean = GRAVITY * _leaky(s, 15, _leaky(s, 14, wx) - LEAN / GRAVITY * _high(s, 2, cell[AY]))
    for j in range(2):
        turn = wz if j == 0 else pair
        out[8 + j] = _leaky(s, 12 + j, cell[AY] * (1.0 - LEAN) - v * turn) - lean
        if not (abs(cell[AY]) < WILD and abs(wx) < WILD and abs(v * turn) < WILD):
            out[8 + j] = np.nan
    return v * wz if abs(v * wz) < WILD else 0.0


@compiled
def _learn(s, i, value):
    """An old residual into mean and variance; an outlier counts as four std."""
    if not math.isfinite(value):
        return
    s.learnt[i] += 1
    share = max(STEP / LEARN, 1.0 / s.learnt[i])
    off = value - s.mean[i]
    if s.learnt[i] > 50:
        most = 4.0 * math.sqrt(s.variance[i]) + 1e-3
        off = min(max(off, -most), most)
    s.mean[i] += share * off
    s.variance[i] += share * (off * off - s.variance[i])


@compiled
def _judge(s, k, q, culprit, limit, row):
    """Judgement k: evidence q against a culprit."""
    row[20 + k], row[26 + k] = q, -1.0
    if not math.isfinite(q):
        return
    q = min(q, LARGEST)
    if s.accused[k] >= 0:
        s.calm[k] = s.calm[k] + 1.0 if q < CALM else 0.0
        if s.calm[k] >= (BACK_GYRO if s.accused[k] == WX or s.accused[k] == WY else BACK):
            row[26 + k] = -2.0 - s.accused[k]
            s.accused[k], s.g[k] = -1, 0.0
        return
    s.g[k] = max(s.g[k] + q - DRIFT, 0.0)
    if s.g[k] > limit:
        s.accused[k], s.calm[k] = culprit, 0.0
        row[26 + k] = culprit


@compiled
def follow(c, s, limits, index, cells, said):
    """limits: h of rigid body, hubs, lateral, (3,); index (n,), cells (n, 18): f, w, body and hub accelerations, wheel
    speeds [rad/s]; NaN where silent. Fills said (n, SAID)."""
    now, x = np.empty(RESIDUALS), np.empty(RESIDUALS)
    for k in range(len(index)):
        if s.clock[0] >= 0 and index[k] != s.clock[0] + 1:
            s.high[3:] = np.nan  # a gap: no change across it
        s.clock[0] = index[k]
        s.clock[1] += 1
        curve = PER_CURVE * abs(_residuals(c, s, cells[k], now))
        place = s.clock[1] % LAG
        if s.clock[1] > JUDGED_AFTER // 2:
            for i in range(RESIDUALS):
                group = 0 if i < 4 else i - 3 if i < 8 else 5
                if s.accused[group] < 0 and not (4 <= i < 8 and s.accused[0] == i - 4):
                    _learn(s, i, s.ring[place, i])
        s.ring[place] = now
        for i in range(RESIDUALS):
            floor = FLOOR_R if i < 4 else FLOOR_D if i < 8 else FLOOR_L
            wide = curve * (0.2 if i < 4 else 0.0 if i < 8 else 1.0)
            std = math.sqrt(s.variance[i] + floor * floor + wide * wide)
            x[i] = (now[i] - s.mean[i]) / std
            said[k, i], said[k, 10 + i] = now[i] - s.mean[i], std
        said[k, 20:26], said[k, 26:32] = np.nan, -1.0
        if s.clock[1] <= JUDGED_AFTER:
            continue
        q, culprit = 0.0, 0
        for p in range(7):
            share = abs(np.sum(c.patterns[p] * x[:4]))
            if not share <= q:  # NaN goes through
                q, culprit = share, p
        _judge(s, 0, q, culprit, limits[0], said[k])
        doubt = s.g[0] > DOUBT * limits[0] or s.accused[0] >= 0
        for i in range(4):
            rests = doubt and (culprit == i or s.accused[0] == i)
            _judge(s, 1 + i, np.nan if rests else abs(x[4 + i]), HUB + i, limits[1], said[k])
        both = min(abs(x[8]), abs(x[9])) if x[8] * x[9] > 0.0 else 0.0
        turning = s.accused[0] == WX or (doubt and culprit == WX)
        s.clock[2] = HOLD if turning else max(s.clock[2] - 1, 0)
        both = np.nan if not math.isfinite(x[8] + x[9]) or s.clock[2] > 0 else both
        _judge(s, 5, both, FY, limits[2], said[k])
