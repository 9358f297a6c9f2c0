"""The motor's servo as a model: what angle a demand leads to, with limits of rate and acceleration.

State angle x [rad of motor], speed w [rad/s], integral z [rad]. With u the demand a delay ago, a cascade as servos have
it, and a motor whose torque is bounded by its current, and by what the voltage leaves at speed:

    w_ref = clip(p (u - x) + f du/dt, +-w_max)          dz/dt = w_ref - w, waiting while a limit binds
    a = q (w_ref - w + r z)   within +-a_max and +-a_0 (1 -+ w / w_0)          dx/dt = w, dw/dt = a - c sign(w)

Semi-implicit Euler at SUBSTEP, demand linear between the cells of STEP. It is simulated, not corrected by what is
measured: an error of the measured angle passes in full (the innovation is made of it by whitening, `watch`). A cell
without a demand takes the last one; after a silence of GAP, or at the beginning, x is the demand and w is 0. No angle
is told then and for RECOVERS after. What a
model does in transients and at its limits is known worse, and for a while after: push is the largest acceleration, and
strain is 1 where a limit cuts off all, 0 where nothing; both fade. Left out: the load, which the tyres put on the
motor: what it does is in the spread (`spread`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.steering_actuator.residuals import GAP, STEP

SUBSTEPS = 10  # of a cell
SUBSTEP = STEP / SUBSTEPS
HISTORY = 12  # cells of demand that are kept
LONGEST_DELAY = STEP * (HISTORY - 2)
STATE = HISTORY + 7  # demands, newest first; x, w, cells since the last demand, strain, z, push, cells to recover
RECOVERS = 10  # cells
ANGLE, SPEED, PUSH, STRAIN = range(4)  # columns of what is said
SAID = 4
CAUSES = slice(SPEED, SAID)  # of the model's error
FADES = 0.05  # s, of push and strain. Declared


class ServoModel(NamedTuple):
    """p [1/s], q [1/s], f [-], delay [s], w_max [rad/s], a_max [rad/s^2], r [1/s], a_0 [rad/s^2], w_0 [rad/s], c
    [rad/s^2], all of the motor."""

    position_gain: float
    speed_gain: float
    feedforward: float
    delay: float
    speed_limit: float
    acceleration_limit: float
    integral_gain: float = 0.0
    stall_acceleration: float = 1e7
    free_speed: float = 1e5
    friction: float = 0.0


MAY_BE_ZERO = ("delay", "feedforward", "integral_gain", "friction")


def checked(model: ServoModel) -> ServoModel:
    """ValueError unless every number makes sense."""
    for name, value in model._asdict().items():
        highest = LONGEST_DELAY if name == "delay" else np.inf
        if not (np.isfinite(value) and 0.0 <= value <= highest) or (value == 0.0 and name not in MAY_BE_ZERO):
            raise ValueError(f"servo {name} is {value!r}, valid: a number above 0, a delay at most {LONGEST_DELAY:g} s")
    return model


def new_state() -> NDArray[np.float64]:
    """Before a drive."""
    state = np.zeros(STATE)
    state[HISTORY + 2] = GAP
    return state


@compiled
def simulate(model, state, demand, out):
    """demand [rad] of each cell, NaN where missing, (n,) -> out (n, SAID): angle, speed, push, strain at its
    centre, NaN before the first demand, the angle also while it recovers. state goes on."""
    behind = model.delay / STEP
    for k in range(len(demand)):
        missing = not np.isfinite(demand[k])
        if missing and state[HISTORY + 2] >= GAP:
            out[k, :] = np.nan
            continue
        if not missing and state[HISTORY + 2] >= GAP:
            state[:HISTORY] = demand[k]
            state[HISTORY:] = 0.0
            state[HISTORY] = demand[k]
            state[HISTORY + 6] = RECOVERS
        newest = state[0] if missing else demand[k]
        for i in range(HISTORY - 1, 0, -1):
            state[i] = state[i - 1]
        state[0] = newest
        state[HISTORY + 2] = state[HISTORY + 2] + 1.0 if missing else 0.0
        x, w, z = state[HISTORY], state[HISTORY + 1], state[HISTORY + 4]
        cut, push = (1.0 - STEP / FADES) * state[HISTORY + 3], (1.0 - STEP / FADES) * state[HISTORY + 5]
        for i in range(SUBSTEPS):
            place = behind + 1.0 - (i + 1.0) / SUBSTEPS  # cells back from this one's centre
            whole = min(int(place), HISTORY - 2)
            part = place - whole
            u = (1.0 - part) * state[whole] + part * state[whole + 1]
            rate = (state[whole] - state[whole + 1]) / STEP
            wanted = model.position_gain * (u - x) + model.feedforward * rate
            cut = max(cut, 1.0 - model.speed_limit / max(abs(wanted), model.speed_limit))
            error = min(max(wanted, -model.speed_limit), model.speed_limit) - w
            asked = model.speed_gain * (error + model.integral_gain * z)
            high = min(model.acceleration_limit, model.stall_acceleration * (1.0 - w / model.free_speed))
            low = max(-model.acceleration_limit, -model.stall_acceleration * (1.0 + w / model.free_speed))
            a = min(max(asked, low), high)
            if a != asked:
                cut = max(cut, min(abs(asked - a) / abs(asked), 1.0))
            if a == asked or asked * error < 0.0:
                z += error * SUBSTEP
            push = max(push, abs(a))
            w += a * SUBSTEP
            rub = model.friction * SUBSTEP
            w = w - rub if w > rub else (w + rub if w < -rub else 0.0)
            x += w * SUBSTEP
        state[HISTORY], state[HISTORY + 1], state[HISTORY + 3], state[HISTORY + 4] = x, w, cut, z
        state[HISTORY + 5] = push
        state[HISTORY + 6] = RECOVERS if missing else max(state[HISTORY + 6] - 1.0, 0.0)
        out[k, 0] = x if state[HISTORY + 6] == 0.0 else np.nan
        out[k, 1], out[k, 2], out[k, 3] = w, push, cut


def simulated(model: ServoModel, demand: NDArray[np.float64]) -> NDArray[np.float64]:
    """A whole drive from the beginning: (n, SAID) for a demand of shape (n,)."""
    out = np.empty((len(demand), SAID))
    simulate(model, new_state(), np.ascontiguousarray(demand, dtype=np.float64), out)
    return out
