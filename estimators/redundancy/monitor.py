"""The two comparisons over cells: yaw rate first, then specific force with the yaw rate that is believed.

A wheel that is stuck takes its pair out of both. A pair that one comparison accuses is out of the other as well: a
sensor is faulty if it is in any measurement. Which wheel of the pair it is: the one whose speed against what the other
axle and the yaw rate ask of it has changed more from what it was before.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.redundancy.comparison import LAG, Memory, new_memory, step
from estimators.redundancy.numbers import FORCE_DRIFT, YAW_DRIFT
from estimators.redundancy.sources import (
    ADAPTIVE_FORCE,
    ADAPTIVE_YAW,
    FORCE_NOISE,
    FORCE_PRIOR,
    FORCE_WALK,
    YAW_NOISE,
    YAW_PRIOR,
    YAW_WALK,
    Past,
    force_sources,
    forget,
    front_speed,
    new_past,
    yaw_sources,
)

# columns of what a cell says
YAW_VALUE, YAW_VARIANCE, YAW_USED, FORCE_VALUE, FORCE_VARIANCE, FORCE_USED, GRADE, GRADE_VARIANCE = range(8)
YAW_EVENT, FORCE_EVENT, WHEEL = range(8, 11)
YAW_X, FORCE_X = 11, 15
SAID = 19
SHORT, LONG = 0.3, 0.01  # per cell: of a wheel's speed against the asked one, now and before


class State(NamedTuple):
    """wheel: deviation of each wheel's speed from the asked one, smoothed short and long, then LAG cells of the long
    one, (2 + LAG, 4); cells: (1,) how many; last: (1,) index of the last cell."""

    yaw: Memory
    force: Memory
    past: Past
    wheel: NDArray[np.float64]
    cells: NDArray[np.int64]


def new_state() -> State:
    """Before a drive."""
    return State(
        new_memory(YAW_NOISE, YAW_PRIOR), new_memory(FORCE_NOISE, FORCE_PRIOR), new_past(), np.zeros((2 + LAG, 4)),
        np.array([0, -1], np.int64),
    )  # fmt: skip


@compiled
def _wheels(c, state, cell, v, turn):
    """Keeps each wheel's relative deviation from the speed that the other axle and the yaw rate ask of it."""
    wheel = state.wheel
    place = 2 + state.cells[0] % LAG
    front = front_speed(c, c.radius * cell[0], c.radius * cell[1], turn)
    rear = 0.5 * c.radius * (cell[2] + cell[3])
    for w in range(4):
        side = -0.5 if w % 2 == 0 else 0.5
        if w < 2:
            asked = math.hypot(rear + side * c.front_track * turn, c.wheelbase * turn)
        else:
            asked = front + side * c.rear_track * turn
        off = (cell[w] * c.radius - asked) / max(v, 2.0)
        if math.isfinite(off):
            wheel[0, w] += SHORT * (off - wheel[0, w])
            wheel[1, w] += max(LONG, 1.0 / (state.cells[0] + 1.0)) * (off - wheel[1, w])
        wheel[place, w] = wheel[1, w]


@compiled
def suspect(state, first):
    """The wheel of a pair (first: 0 front, 2 rear) that has changed more."""
    before = 2 + (state.cells[0] + 1) % LAG if state.cells[0] >= LAG else 1
    left = abs(state.wheel[0, first] - state.wheel[before, first])
    right = abs(state.wheel[0, first + 1] - state.wheel[before, first + 1])
    return first if left >= right else first + 1


@compiled
def follow(c, state, limits, index, cells, stuck, said):
    """limits: thresholds of both comparisons, (2, 4); index: (n,) of the cells; cells: (n, 11); stuck: (n, 4) 1 where a
    wheel's sensor is; said: (n, SAID), filled."""
    yaw_y, yaw_h, yaw_r = np.empty(4), np.empty((4, 8)), np.empty(4)
    force_y, force_h, force_r = np.empty(4), np.empty((4, 6)), np.empty(4)
    for k in range(index.size):
        if state.cells[1] >= 0 and index[k] != state.cells[1] + 1:
            forget(state.past)
        state.cells[1] = index[k]
        cell, row = cells[k], said[k]
        v = yaw_sources(c, state.past, cell, yaw_y, yaw_h, yaw_r)
        front = stuck[k, 0] + stuck[k, 1] > 0.0
        rear = stuck[k, 2] + stuck[k, 3] > 0.0
        for i, out in ((1, front), (2, rear)):
            if out or state.force.accused[i] > 0.0:
                yaw_y[i] = np.nan
        if rear or state.yaw.accused[2] > 0.0 or state.force.accused[2] > 0.0:
            v = 0.5 * c.radius * (cell[0] + cell[1])
        row[YAW_EVENT] = step(
            state.yaw, yaw_y, yaw_h, yaw_r, YAW_WALK, ADAPTIVE_YAW, YAW_DRIFT, limits[0],
            row[YAW_X : YAW_X + 4], row[YAW_VALUE : YAW_USED + 1],
        )  # fmt: skip
        turn = row[YAW_VALUE]
        row[GRADE] = force_sources(c, state.past, cell, v, turn, force_y, force_h, force_r)
        for i, out in ((1, front), (2, rear)):
            if out or state.yaw.accused[i] > 0.0:
                force_y[i] = np.nan
        row[FORCE_EVENT] = step(
            state.force, force_y, force_h, force_r, FORCE_WALK, ADAPTIVE_FORCE, FORCE_DRIFT, limits[1],
            row[FORCE_X : FORCE_X + 4], row[FORCE_VALUE : FORCE_USED + 1],
        )  # fmt: skip
        row[GRADE] += state.force.theta[2] + state.force.theta[3] * state.past.lagged[2]
        row[GRADE_VARIANCE] = state.force.spread[2, 2]
        if math.isfinite(v) and v > 0.0:
            _wheels(c, state, cell, v, turn if math.isfinite(turn) else 0.0)
            state.cells[0] += 1
        row[WHEEL] = -1.0
        for event in (row[YAW_EVENT], row[FORCE_EVENT]):
            if event == 1.0 or event == 2.0:
                row[WHEEL] = suspect(state, 0 if event == 1.0 else 2)
