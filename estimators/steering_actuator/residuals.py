"""What the thesis' monitors look at: position, velocity and acceleration residual of the motor, in degrees.

Razavi, Lund 2006, equations 1.4 to 1.6 (seed 004), from motor angle delta_M and its demand delta_Md every STEP:

    eps_pos = delta_M - delta_Md          eps_vel = D eps_pos          eps_acc = D eps_vel

D is the thesis' derivative filter, of which it says nothing but that there are two: s / (T s + 1), backward Euler over
the time that passed. It is linear, so the derivative of the difference is the difference of the derivatives. It begins
at rest at the first sample (a constant error gives no pulse) and again after a silence of GAP. Units deg, deg/s,
deg/s^2. A cell without both signals gives NaN. Left out: quantisation of the filters.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.compiled import compiled

STEP = 0.01  # s: "sample time is always 0.01"
TIME_CONSTANT = 0.02  # s of D. Declared: passes the thesis' sine of 20 Hz by a third
GAP = 20  # cells
RESIDUALS = ("position", "velocity", "acceleration")
UNITS = ("deg", "deg/s", "deg/s^2")


@compiled
def derive(error, out):
    """error: eps_pos of each cell, NaN where missing, (n,) -> out (n, 3): all three."""
    last, rate, push, missed = 0.0, 0.0, 0.0, GAP
    for k in range(len(error)):
        if not np.isfinite(error[k]):
            out[k, :] = np.nan
            missed += 1
            continue
        if missed >= GAP:
            last, rate, push = error[k], 0.0, 0.0
        passed = (missed + 1) * STEP
        old = rate
        rate = (TIME_CONSTANT * rate + error[k] - last) / (TIME_CONSTANT + passed)
        push = (TIME_CONSTANT * push + rate - old) / (TIME_CONSTANT + passed)
        last, missed = error[k], 0
        out[k, 0], out[k, 1], out[k, 2] = error[k], rate, push


def residuals(error: ArrayLike) -> NDArray[np.float64]:
    """(n, 3) of a position residual [deg] of shape (n,), a row each STEP."""
    given = np.ascontiguousarray(error, dtype=np.float64)
    out = np.empty((len(given), len(RESIDUALS)))
    derive(given, out)
    return out
