"""A belief on the grid of `posterior`, compiled: interpolation from the bank's nodes, Bayes' rule, passing time.

Arrays are (long slopes, short slopes, stiffnesses, levels), levels innermost: every inner loop runs along them.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled

_C = tuple(1.0 / math.factorial(k) for k in range(11))  # of the exponential


@compiled
def between(nodes, first_s, weight_s, first_k, weight_k, out):
    """From nodes (stiffnesses, longs, shorts, levels) to fine stiffnesses and short slopes, out (longs, fine shorts,
    fine stiffnesses, levels)."""
    stiffnesses, longs, _, levels = nodes.shape
    along = np.empty((stiffnesses, levels))
    for a in range(longs):
        for s in range(len(first_s)):
            n = first_s[s]
            w0, w1, w2, w3 = weight_s[s]
            for i in range(stiffnesses):
                for j in range(levels):
                    along[i, j] = (
                        w0 * nodes[i, a, n, j]
                        + w1 * nodes[i, a, n + 1, j]
                        + w2 * nodes[i, a, n + 2, j]
                        + w3 * nodes[i, a, n + 3, j]
                    )
            for k in range(len(first_k)):
                n = first_k[k]
                w0, w1, w2, w3 = weight_k[k]
                for j in range(levels):
                    out[a, s, k, j] = (
                        w0 * along[n, j] + w1 * along[n + 1, j] + w2 * along[n + 2, j] + w3 * along[n + 3, j]
                    )


@compiled
def likelihood(log_summed, log_variance, count, per_level, log_level, out):
    """Log-likelihood of a block of `count` samples of all cells, out (cells, levels); its largest value. log_summed,
    log_variance (cells, level nodes): ln s and ln S of the filters."""
    columns, rough = len(log_level), log_summed.shape[1]
    top = np.full(columns, -np.inf)
    over, level = -0.5 * np.exp(-log_level), -0.5 * count * log_level
    for i in range(out.shape[0]):
        row = out[i]
        for j in range(rough - 1):
            s, V = np.exp(log_summed[i, j]), -0.5 * count * log_variance[i, j]
            more_s, more_V = np.exp(log_summed[i, j + 1]) - s, -0.5 * count * log_variance[i, j + 1] - V
            first = j * per_level
            for f in range(first, min(first + per_level, columns) if j < rough - 2 else columns):
                share = min((f - first) / per_level, 1.0)
                row[f] = over[f] * (s + share * more_s) + V + share * more_V + level[f]
        for f in range(columns):
            top[f] = row[f] if row[f] > top[f] else top[f]
    return top.max()


@compiled
def taken(p, log_likelihood, highest):
    """Bayes: p times exp(log_likelihood), normalised, in place; both (cells, levels). highest: of log_likelihood.

    The exponential is one that a processor's vectors can do: the 128th power of a Taylor polynomial, to 1e-8; cells
    that are e^-64 less likely than the best are taken for that.
    """
    rows, columns = p.shape
    totals = np.zeros(columns)
    for i in range(rows):
        for f in range(columns):
            x = log_likelihood[i, f] - highest
            x = (x if x > -64.0 else -64.0) * (1.0 / 128.0)
            y = _C[10]
            y = y * x + _C[9]
            y = y * x + _C[8]
            y = y * x + _C[7]
            y = y * x + _C[6]
            y = y * x + _C[5]
            y = y * x + _C[4]
            y = y * x + _C[3]
            y = y * x + _C[2]
            y = y * x + 1.0
            y = y * x + 1.0
            y *= y
            y *= y
            y *= y
            y *= y
            y *= y
            y *= y
            y *= y
            p[i, f] *= y
            totals[f] += p[i, f]
    total = totals.sum()
    if total > 0.0 and np.isfinite(total):
        p /= total
    else:
        p[:] = 1.0 / p.size


@compiled
def moved_on(p, new, prior_k, prior_road, drift_k, jump_k, drift_s, drift_l, jump_road):
    """The grid one block on, p (`SHAPE`) into new. drift: share of a cell that goes to each neighbour in ln k, w_s,
    ln lambda; jump: of all, to the prior of the stiffness (k,), of the road (long, short, levels)."""
    longs, shorts, rows, columns = p.shape
    by_stiffness, by_road = np.zeros(rows), np.zeros((longs, shorts, columns))
    for a in range(longs):
        for s in range(shorts):
            for k in range(rows):
                own = p[a, s, k]
                for f in range(columns):
                    by_road[a, s, f] += own[f]
                by_stiffness[k] += own.sum()
    stays, last = (1.0 - jump_k) * (1.0 - jump_road), columns - 1
    for a in range(longs):
        for s in range(shorts):
            more, less = min(s + 1, shorts - 1), max(s - 1, 0)
            for k in range(rows):
                up, down = min(k + 1, rows - 1), max(k - 1, 0)
                here, other = jump_k * (1.0 - jump_road) * prior_k[k], jump_road * by_stiffness[k]
                own, out = p[a, s, k], new[a, s, k]
                above, below, steeper, flatter = p[a, s, up], p[a, s, down], p[a, more, k], p[a, less, k]
                arrived, road = by_road[a, s], prior_road[a, s]
                for f in range(columns):
                    value = own[f]
                    moved = value + drift_k * (above[f] + below[f] - 2.0 * value)
                    moved += drift_s * (steeper[f] + flatter[f] - 2.0 * value)
                    out[f] = stays * moved + here * arrived[f] + other * road[f]
                for f in range(1, last):
                    out[f] += stays * drift_l * (own[f + 1] + own[f - 1] - 2.0 * own[f])
                out[0] += stays * drift_l * (own[1] - own[0])
                out[last] += stays * drift_l * (own[last - 1] - own[last])
