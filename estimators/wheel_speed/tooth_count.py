"""Which tooth each edge belongs to: missing edges counted, double ones dropped, nothing assumed of the direction.

An edge `dt` after the last one taken is k = round(dt / T) teeth further on, T the time per tooth of the last interval.
    k = 0                       a double edge, dropped
    |dt / T - k| > MISFIT       it fits no tooth (the late half of a double, a disturbance), dropped
    k = 2 to MOST_MISSING + 1   k - 1 edges are missing
After MOST_MISFITS dropped in a row the wheel has done something that T does not foresee (lock-up, spin): a new run
begins. Within a run the count of teeth is certain; from one to the next only the pattern of the ring can tell it.

Slower than SLOW, a wheel can change its speed by half within a tooth: there every edge counts as the next tooth, and
one that would be missing or double begins a new run. A gap longer than STANDSTILL is a stop: the wheel may have turned
back, which an edge sensor cannot see.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled

MISFIT = 0.25
MOST_MISSING = 7
MOST_MISFITS = 4
SLOW = 1.0 / 40.0  # s per tooth: 1.9 m/s; at 10 m/s^2 an interval there differs by a seventh from the one before
STANDSTILL = 0.5  # s without an edge
LAST, INTERVAL, TOOTH, RUN, DROPPED = range(5)  # state
DOUBLE, MISFITTING, MISSING, RESTARTS = range(4)  # tally


def fresh_state() -> np.ndarray:
    """Before the first edge: last time [s], time per tooth [s], tooth, run, edges dropped in a row; shape (5,)."""
    return np.array([-math.inf, math.inf, 0.0, 0.0, 0.0])


@compiled
def count_teeth(state, time, tooth, run, tally):
    """Takes edges in order; returns how many are kept.

    state: shape (5,), updated. time [s]: shape (n,), rising; the kept ones are moved to its front. tooth, run: shape
    (n,), filled for the kept ones. tally: counts of double, misfitting and missing edges, and of new runs by misfits;
    shape (4,), added to.
    """
    kept = 0
    for i in range(time.size):
        t = time[i]
        dt = t - state[LAST]
        steps, begins, known = 1.0, False, state[INTERVAL] < math.inf
        if dt > STANDSTILL:
            begins, known = True, False
        elif known:
            ratio = dt / state[INTERVAL]
            steps = math.floor(ratio + 0.5)
            if state[INTERVAL] > SLOW or dt > SLOW * max(steps, 1.0):
                begins = steps != 1.0
                steps = 1.0
            elif steps == 0.0 or abs(ratio - steps) > MISFIT or steps > MOST_MISSING + 1.0:
                if state[DROPPED] < MOST_MISFITS:
                    state[DROPPED] += 1.0
                    tally[DOUBLE if steps == 0.0 else MISFITTING] += 1.0
                    continue
                begins, known = True, False
                tally[RESTARTS] += 1.0
            else:
                tally[MISSING] += steps - 1.0
        state[DROPPED] = 0.0
        if begins:
            state[RUN] += 1.0
        state[TOOTH] += steps
        state[INTERVAL] = math.inf if begins and not known else dt / steps
        state[LAST] = t
        time[kept], tooth[kept], run[kept] = t, state[TOOTH], state[RUN]
        kept += 1
    return kept
