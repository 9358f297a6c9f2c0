"""Wheels on a curve: what each wheel speed says of the car, by the thesis' three geometries and as a rigid body.

Razavi, Lund 2006, section 6.1.3 (seed 004). delta: mean road-wheel angle [rad], positive to the left; l wheelbase, b
track [m]. A geometry divides each wheel's speed by the factor that it has over the inner rear wheel:

    none      1
    simple    front 1 / cos(delta), outer (l + b |delta|) / l                                      eq 6.3, 6.4
    exact     rear 1, (l + b t) / l; front 1 / cos(d_i), (l + b t) / (l cos(d_o))                  eq 6.5, corrected
              t = tan(d_i), d_i inner, tan(d_o) = l / (l / t + b) outer road-wheel angle (Ackermann)

In eq 6.5 v_FL / v_FR = cos(d_l) is a slip of the pen: with its own lines it is sin(d_r) / sin(d_l); cos(d_l) is v_RL /
v_FL. All three assume that nothing slips sideways. `car_speeds` does not need the steering angle to place the car:

    v_i = (w_i R - (v_y + r x_i) sin d_i) / cos d_i + r y_i

is the forward speed of the car's middle line by wheel i at (x_i, y_i) from the centre of gravity, r the yaw rate that
the gyro says, v_y the sideways speed there, w_i R the wheel's rolling speed. Left out: camber, unlike radii.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.compiled import compiled

GEOMETRIES = ("none", "simple", "exact")


def factors(geometry: str, steer: ArrayLike, wheelbase: float, track: float) -> NDArray[np.float64]:
    """Speed of each wheel over the inner rear one, shape (n, 4), fl fr rl rr; steer: delta, shape (n,). ValueError for
    an unknown geometry."""
    if geometry not in GEOMETRIES:
        raise ValueError(f"geometry is {geometry!r}, valid: {', '.join(GEOMETRIES)}")
    delta = np.asarray(steer, float)
    angle = np.abs(delta)
    over = np.ones((len(angle), 4))  # inner front, outer front, inner rear, outer rear
    if geometry == "simple":
        over[:, 1] = over[:, 3] = 1.0 + track * angle / wheelbase
        over[:, :2] /= np.cos(angle)[:, None]
    elif geometry == "exact":
        middle = np.tan(angle)  # of an imagined wheel between the front ones
        inner = middle / (1.0 - 0.5 * track * middle / wheelbase)
        outer = middle / (1.0 + 0.5 * track * middle / wheelbase)
        over[:, 1] = over[:, 3] = 1.0 + track * inner / wheelbase
        over[:, 0] /= np.cos(np.arctan(inner))
        over[:, 1] /= np.cos(np.arctan(outer))
    right = delta < 0.0  # eq 6.6: there the right wheels are the inner ones
    over[right] = over[right][:, [1, 0, 3, 2]]
    return over


@compiled
def car_speeds(rolling, turn, sideways, steer, front, rear, front_half, rear_half, speeds):
    """Fills speeds (4,) [m/s] by wheel. rolling: w R (4,) [m/s]; turn r [rad/s], sideways v_y [m/s], steer: mean
    road-wheel angle [rad]; front, rear: distances of the axles from the centre of gravity, half tracks [m]."""
    cosine, sine = math.cos(steer), math.sin(steer)
    across = (sideways + turn * front) * sine
    speeds[0] = (rolling[0] - across) / cosine + turn * front_half
    speeds[1] = (rolling[1] - across) / cosine - turn * front_half
    speeds[2] = rolling[2] + turn * rear_half
    speeds[3] = rolling[3] - turn * rear_half
