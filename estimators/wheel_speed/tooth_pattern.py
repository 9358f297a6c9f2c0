"""Where the teeth of a ring really are: their places against an even ring, learnt while the wheel turns.

Edge m of N teeth lies at the angle (2 pi / N) (m + e[m mod N]), e in pitches with zero mean. The mean of the edge times
over one whole turn around edge m does not know e, nor do the differences of times one turn apart:

    T   = (t[m+N/2] - t[m-N/2]) / N                          time per tooth
    t'' = (t[m+N] - 2 t[m] + t[m-N]) / N^2                   per tooth^2, from the change of speed
    e_m = (t[m] - mean(t[m-N/2 .. m+N/2]) + t'' M2 / 2) / T   M2 = mean of j^2 over the turn, ends counting half

Each turn gives each tooth one such value, noisy with what the wheel really did; e is their mean over the turns, at
last forgetting exponentially over MOST_TURNS. A missing edge is filled in by interpolation for its neighbours' means
and teaches nothing of its own tooth. Turns in which the speed changes by more than STEADY, and those slower than
SLOWEST, in which a single vibration is as large as a tooth's error, teach nothing.
Left out: which tooth is which after a new run (see `ring`).
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled

MOST_TURNS = 1000.0
STEADY = 0.03  # relative change of speed over a turn
SLOWEST = 1.0 / 80.0  # s per tooth: 3.8 m/s
WILD = 0.2  # pitches: no ring, but a disturbance
FILLED, COUNT, HEAD_TOOTH, HEAD_RUN = range(4)  # state


@compiled
def learn_pattern(state, window, real, tooth, time, run, pattern, turns, square, halves):
    """Takes counted edges of one wheel, updates the pattern of the present run.

    state: shape (4,). window [s], real: the last 2 N + 1 edge times, and 1 where seen, 0 where filled in. tooth, run
    [-], time [s]: shape (n,). pattern [pitches], turns, square [pitches^2]: mean, number and mean square deviation of
    the values of each tooth of the ring, shape (N,), updated; halves: mean and number of the values of even turns
    (rows 0, 1) and of odd ones (2, 3), shape (4, N); set back to zero when a run begins. Returns at which edge a new
    run begins (it is not taken), or n.
    """
    teeth = pattern.size
    span, half = 2 * teeth + 1, teeth // 2
    second = 0.0
    for j in range(1, half):
        second += 2.0 * j * j
    second = (second + half * half) / teeth
    for i in range(tooth.size):
        if run[i] != state[HEAD_RUN]:
            return i
        steps = 1
        before = window[span - 1]
        if state[FILLED] > 0.0:
            steps = int(tooth[i] - state[HEAD_TOOTH])
        for k in range(1, steps + 1):
            for j in range(span - 1):
                window[j], real[j] = window[j + 1], real[j + 1]
            window[span - 1] = before + (time[i] - before) * k / steps if k < steps else time[i]
            real[span - 1] = 1.0 if k == steps else 0.0
            state[FILLED] = min(state[FILLED] + 1.0, span)
            if state[FILLED] < span or real[teeth] == 0.0:
                continue
            first, last = window[teeth - half], window[teeth + half]
            mean = 0.5 * (first + last) - window[teeth] * teeth
            for j in range(teeth - half + 1, teeth + half):
                mean += window[j]
            mean /= teeth  # of the turn, less the edge's own time
            per_tooth = (last - first) / teeth
            bend = (window[span - 1] - 2.0 * window[teeth] + window[0]) / (teeth * teeth)
            if abs(bend) * teeth > STEADY * per_tooth or per_tooth > SLOWEST:
                continue
            value = (0.5 * bend * second - mean) / per_tooth
            if abs(value) > WILD:
                continue
            m = int(tooth[i] - steps + k - teeth)
            n, half_of = m % teeth, 2 * ((m // teeth) % 2)
            turns[n] = min(turns[n] + 1.0, MOST_TURNS)
            miss = value - pattern[n]
            pattern[n] += miss / turns[n]
            square[n] += (miss * miss - square[n]) / turns[n]
            halves[half_of + 1, n] = min(halves[half_of + 1, n] + 1.0, 0.5 * MOST_TURNS)
            halves[half_of, n] += (value - halves[half_of, n]) / halves[half_of + 1, n]
        state[HEAD_TOOTH] = tooth[i]
        state[COUNT] += 1.0
    return tooth.size


def value_noise(turns: np.ndarray, square: np.ndarray) -> float:
    """Std of one turn's value of a tooth [pitches]; inf before the second turn of every tooth."""
    if turns.min() < 2.0:
        return math.inf
    return float(np.sqrt(np.mean(square * turns / (turns - 1.0))))


def order_noise(halves: np.ndarray) -> np.ndarray | None:
    """Mean square of the error of each order's amplitude |rfft| [pitches^2], shape (N/2 + 1,), in the mean of both
    halves; None before each tooth has two turns in both. Even turns less odd ones know nothing of the ring and change
    sign with every turn: they are the wheel's own motion at half orders, where its spectrum is as at the whole ones
    between, each the mean of its two neighbours."""
    if halves[1::2].min() < 2.0:
        return None
    teeth = halves.shape[1]
    differing = 0.5 * (halves[0] - halves[2]) * np.exp(-1j * np.pi * np.arange(teeth) / teeth)
    power = np.abs(np.fft.fft(differing)[: teeth // 2 + 1]) ** 2  # at orders 1/2, 3/2, ...
    return 0.5 * (power + np.concatenate([power[:1], power[:-1]]))
