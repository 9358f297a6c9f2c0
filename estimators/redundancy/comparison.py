"""One quantity from several sources: each against all the others, what differs slowly learnt, what differs suddenly
told.

Source i says y_i = q + H_i theta + n_i: the quantity q, nuisances theta (offsets, radius differences, ...) that change
slowly, noise of variance R_i. theta is learnt by a Kalman filter in which q is unknown anew in each cell; it learns
from cells `LAG` old, so a fault is told before it is learnt, and not at all from an accused source. With u_i = y_i -
H_i theta and v_i = R_i + H_i P H_i',

    x_i = (u_i - m_i) / std(u_i - m_i),   m_i: mean of the other sources weighted with 1 / v_j

is the residual (the seed's deviation from the global value, in its own standard deviations; for one faulty source the
largest |x_i| is the most likely one). A two-sided CUSUM g of x_i with drift k alarms above h_i; the source with the
largest g/h is accused and takes no further part; the others' statistics, which its fault has moved, start anew. It
recovers when its |x_i| has stayed small. Fewer than two sources left: nothing is compared.

State of a comparison of m sources and p nuisances, rows of one array each:
    theta (p,), spread (p, p), noise (m,) adaptive variance, statistic (m, 2), calm (m,) cells, accused (m,) 0 or 1,
    ring_y (LAG, m), ring_h (LAG, m, p), ring_r (LAG, m), taken (1,)
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled

LAG = 40  # cells between a cell and its learning: 2 s
LEARNING = 100  # cells at the start of which nothing is judged: 5 s
UNKNOWN = 1e4  # variance of q before a cell, in its unit squared: far more than it can be
FORGET = 0.98  # per cell: the adaptive noise remembers 2.5 s
OUTLIER = 9.0  # of the noise's variance: a larger square counts as that much
CALM = 1.5  # |x| smoothed, below which a source is in order; the mean of sound ones is 0.8
CALM_CELLS = 60  # for so long before it is believed again: 3 s
SMOOTH = 0.9  # of |x|, per cell
LARGEST = 1e3  # |x| counted at the most: a wild sample may not take hours to forget


class Memory(NamedTuple):
    """See the module's text."""

    theta: NDArray[np.float64]
    spread: NDArray[np.float64]
    noise: NDArray[np.float64]
    statistic: NDArray[np.float64]
    calm: NDArray[np.float64]
    smooth: NDArray[np.float64]
    accused: NDArray[np.float64]
    ring_y: NDArray[np.float64]
    ring_h: NDArray[np.float64]
    ring_r: NDArray[np.float64]
    taken: NDArray[np.int64]


def new_memory(noise: NDArray[np.float64], prior: NDArray[np.float64]) -> Memory:
    """noise: first guess of each source's adaptive standard deviation, shape (m,); prior: standard deviation of each
    nuisance, shape (p,)."""
    p, sources = len(prior), len(noise)
    return Memory(
        np.zeros(p), np.diag(prior**2), noise**2, np.zeros((sources, 2)), np.zeros(sources),
        np.zeros(sources), np.zeros(sources), np.full((LAG, sources), np.nan), np.zeros((LAG, sources, p)),
        np.ones((LAG, sources)), np.zeros(1, np.int64),
    )  # fmt: skip


@compiled
def _learn(memory, y, h, r, walk, adaptive):
    """One old cell into theta; y of accused or silent sources is NaN. walk: variance gained a cell, by nuisance."""
    p, m = memory.theta.size, y.size
    theta, spread = np.zeros(p + 1), np.zeros((p + 1, p + 1))
    for a in range(p):
        theta[a + 1] = memory.theta[a]
        for b in range(p):
            spread[a + 1, b + 1] = memory.spread[a, b]
        spread[a + 1, a + 1] += walk[a]
    spread[0, 0] = UNKNOWN
    row, gain = np.empty(p + 1), np.empty(p + 1)
    heard = 0
    for i in range(m):
        if not math.isfinite(y[i]):
            continue
        heard += 1
        row[0] = 1.0
        row[1:] = h[i]
        error, variance = y[i], r[i] + memory.noise[i] * adaptive[i]
        for a in range(p + 1):
            error -= row[a] * theta[a]
            gain[a] = 0.0
            for b in range(p + 1):
                gain[a] += spread[a, b] * row[b]
        for a in range(p + 1):
            variance += row[a] * gain[a]
        for a in range(p + 1):
            theta[a] += gain[a] * error / variance
        for a in range(p + 1):
            for b in range(p + 1):
                spread[a, b] -= gain[a] * gain[b] / variance
    if heard > 1:
        memory.theta[:] = theta[1:]
        memory.spread[:, :] = 0.5 * (spread[1:, 1:] + spread[1:, 1:].T)
    if heard > 1:
        _learn_noise(memory, y, h, r, adaptive)


@compiled
def _learn_noise(memory, y, h, r, adaptive):
    """Each source's variance from its deviation against the others alone: against a mean that holds it, the best source
    would think itself ever better."""
    m, p = h.shape
    total, weighted = 0.0, 0.0
    for i in range(m):
        if math.isfinite(y[i]):
            off = y[i]
            for a in range(p):
                off -= h[i, a] * memory.theta[a]
            weight = 1.0 / (r[i] + memory.noise[i])
            total += weight
            weighted += weight * off
    before = memory.noise.copy()
    for i in range(m):
        if math.isfinite(y[i]) and adaptive[i] > 0.0:
            off = y[i]
            for a in range(p):
                off -= h[i, a] * memory.theta[a]
            weight = 1.0 / (r[i] + before[i])
            rest = total - weight
            variance = r[i] + before[i] + 1.0 / rest
            square = min((off - (weighted - weight * off) / rest) ** 2, OUTLIER * variance)
            memory.noise[i] = max(before[i] + (1.0 - FORGET) * (square - variance), 0.0)


@compiled
def _variance(memory, u, v, h, r, adaptive, i, rest):
    """Of u_i less the weighted mean of the others: what all nuisances have in common cancels, as it does in there."""
    m, p = h.shape
    row = h[i].copy()
    variance = r[i] + memory.noise[i] * adaptive[i]
    for j in range(m):
        if j != i and math.isfinite(u[j]) and memory.accused[j] == 0.0:
            share = 1.0 / (v[j] * rest)
            variance += share * share * (r[j] + memory.noise[j] * adaptive[j])
            for a in range(p):
                row[a] -= share * h[j, a]
    for a in range(p):
        for b in range(p):
            variance += row[a] * memory.spread[a, b] * row[b]
    return variance


@compiled
def step(memory, y, h, r, walk, adaptive, drift, threshold, x, said):
    """One cell. y: (m,), NaN where silent; h: (m, p); r: (m,); walk: (p,); adaptive: (m,) 1 where the noise is learnt;
    threshold: h of each source, (m,).

    Fills x (m,), NaN where there is nothing to compare with, and said: global value, its variance, sources used (3,).
    Returns the source accused in this cell, -1 for none, or -2 - i where source i has recovered.
    """
    m, p = h.shape
    place = memory.taken[0] % LAG
    if memory.taken[0] >= LAG:
        old = memory.ring_y[place].copy()
        for i in range(m):
            if memory.accused[i] > 0.0:
                old[i] = np.nan
        _learn(memory, old, memory.ring_h[place], memory.ring_r[place], walk, adaptive)
    memory.ring_y[place], memory.ring_h[place], memory.ring_r[place] = y, h, r
    memory.taken[0] += 1

    u, v = np.empty(m), np.empty(m)
    total, weighted, used = 0.0, 0.0, 0
    for i in range(m):
        x[i], u[i], v[i] = np.nan, y[i], r[i] + memory.noise[i] * adaptive[i]
        for a in range(p):
            u[i] -= h[i, a] * memory.theta[a]
            for b in range(p):
                v[i] += h[i, a] * memory.spread[a, b] * h[i, b]
        if math.isfinite(u[i]) and memory.accused[i] == 0.0:
            total += 1.0 / v[i]
            weighted += u[i] / v[i]
            used += 1
    said[0], said[1], said[2] = np.nan, np.inf, used
    if used > 0:
        said[0], said[1] = weighted / total, 1.0 / total
    worst, largest = -1, 1.0
    for i in range(m):
        if not math.isfinite(u[i]):
            continue
        mine = 0.0 if memory.accused[i] > 0.0 else 1.0 / v[i]
        rest = total - mine
        if used - (1 if mine > 0.0 else 0) < 1:
            continue
        off = u[i] - (weighted - mine * u[i]) / rest
        x[i] = min(max(off / math.sqrt(_variance(memory, u, v, h, r, adaptive, i, rest)), -LARGEST), LARGEST)
        memory.smooth[i] = SMOOTH * memory.smooth[i] + (1.0 - SMOOTH) * abs(x[i])
        if memory.taken[0] <= LEARNING:
            continue
        if memory.accused[i] > 0.0:
            memory.calm[i] = memory.calm[i] + 1.0 if memory.smooth[i] < CALM else 0.0
            continue
        up = max(memory.statistic[i, 0] + x[i] - drift, 0.0)
        down = max(memory.statistic[i, 1] - x[i] - drift, 0.0)
        memory.statistic[i, 0], memory.statistic[i, 1] = min(up, 2.0 * threshold[i]), min(down, 2.0 * threshold[i])
        g = max(up, down) / threshold[i]
        if g > largest:
            worst, largest = i, g
    if worst >= 0 and used < 3:
        worst = -1  # of two that differ neither can be told from the other
    if worst >= 0:
        memory.accused[worst], memory.calm[worst] = 1.0, 0.0
        memory.statistic[:, :] = 0.0
        return worst
    for i in range(m):
        if memory.accused[i] > 0.0 and memory.calm[i] >= CALM_CELLS:
            memory.accused[i] = 0.0
            memory.statistic[i, :] = 0.0
            return -2 - i
    return -1
