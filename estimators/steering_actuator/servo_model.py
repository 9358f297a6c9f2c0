"""The motor's servo as a model: what angle a demand leads to, with limits of rate and acceleration.

State angle x [rad of motor], speed w [rad/s]. With u the demand a delay ago,

    w_ref = clip(p (u - x) + f du/dt, +-w_max)          a = clip(q (w_ref - w), +-a_max)          dx/dt = w, dw/dt = a

unlimited x = (f p-form) (q f s + q p) / (s^2 + q s + q p) u: any stable second-order servo with one zero. Semi-implicit
Euler at SUBSTEP, demand linear between the cells of STEP. It is simulated, not corrected by what is measured: an error
of the measured angle passes in full (the innovation is made of it by whitening, `watch`). A cell without a demand takes
the last one; after a silence of GAP, or at the beginning, x is the demand and w is 0. What a model does at its limits
is known worse, and for a while after: strain is 1 where a limit cuts off all, 0 where nothing, and fades. Left out: friction, load, flux
limits of the motor: what they do is in the spread (`watch.Spread`).
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
STATE = HISTORY + 4  # demands, newest first; x, w, cells since the last demand, strain
ANGLE, SPEED, ACCELERATION, STRAIN = range(4)  # columns of what is said
SAID = 4
FADES = 0.05  # s, of the strain. Declared


class ServoModel(NamedTuple):
    """p [1/s], q [1/s], f [-], delay [s], w_max [rad/s], a_max [rad/s^2] of the motor."""

    position_gain: float
    speed_gain: float
    feedforward: float
    delay: float
    speed_limit: float
    acceleration_limit: float


def checked(model: ServoModel) -> ServoModel:
    """ValueError unless every number makes sense."""
    for name, value in model._asdict().items():
        lowest, highest = 0.0, LONGEST_DELAY if name == "delay" else np.inf
        if not (np.isfinite(value) and lowest <= value <= highest) or (
            value == 0.0 and name not in ("delay", "feedforward")
        ):
            raise ValueError(f"servo {name} is {value!r}, valid: a number above 0, a delay at most {LONGEST_DELAY:g} s")
    return model


def new_state() -> NDArray[np.float64]:
    """Before a drive."""
    state = np.zeros(STATE)
    state[HISTORY + 2] = GAP
    return state


@compiled
def simulate(model, state, demand, out):
    """demand [rad] of each cell, NaN where missing, (n,) -> out (n, SAID): angle, speed, acceleration, strain at its
    centre, NaN before the first demand. state goes on."""
    behind = model.delay / STEP
    for k in range(len(demand)):
        missing = not np.isfinite(demand[k])
        if missing and state[HISTORY + 2] >= GAP:
            out[k, :] = np.nan
            continue
        if not missing and state[HISTORY + 2] >= GAP:
            state[:HISTORY] = demand[k]
            state[HISTORY], state[HISTORY + 1], state[HISTORY + 3] = demand[k], 0.0, 0.0
        newest = state[0] if missing else demand[k]
        for i in range(HISTORY - 1, 0, -1):
            state[i] = state[i - 1]
        state[0] = newest
        state[HISTORY + 2] = state[HISTORY + 2] + 1.0 if missing else 0.0
        x, w, a, cut = state[HISTORY], state[HISTORY + 1], 0.0, state[HISTORY + 3] * (1.0 - STEP / FADES)
        for i in range(SUBSTEPS):
            place = behind + 1.0 - (i + 1.0) / SUBSTEPS  # cells back from this one's centre
            whole = min(int(place), HISTORY - 2)
            part = place - whole
            u = (1.0 - part) * state[whole] + part * state[whole + 1]
            rate = (state[whole] - state[whole + 1]) / STEP
            wanted = model.position_gain * (u - x) + model.feedforward * rate
            cut = max(cut, 1.0 - model.speed_limit / max(abs(wanted), model.speed_limit))
            wanted = min(max(wanted, -model.speed_limit), model.speed_limit)
            a = model.speed_gain * (wanted - w)
            cut = max(cut, 1.0 - model.acceleration_limit / max(abs(a), model.acceleration_limit))
            a = min(max(a, -model.acceleration_limit), model.acceleration_limit)
            w += a * SUBSTEP
            x += w * SUBSTEP
        state[HISTORY], state[HISTORY + 1], state[HISTORY + 3] = x, w, cut
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = x, w, a, cut


def simulated(model: ServoModel, demand: NDArray[np.float64]) -> NDArray[np.float64]:
    """A whole drive from the beginning: (n, SAID) for a demand of shape (n,)."""
    out = np.empty((len(demand), SAID))
    simulate(model, new_state(), np.ascontiguousarray(demand, dtype=np.float64), out)
    return out
