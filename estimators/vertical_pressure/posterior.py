"""What the bank's likelihoods say of one wheel: a probability over stiffness and road level, both continuous.

A hidden Markov model (Rabiner, Proc. IEEE 77, 1989, forward algorithm) on a grid of ln k_t (1.2 % apart) and ln G (7
% apart). Between the bank's nodes the log-likelihood of a block of samples is interpolated: over stiffness by cubics,
over level by each filter's own law of the level (`innovations`), blended between its two neighbours. From block to
block the stiffness drifts (warming) and may jump (a leak, `STIFFNESS_JUMPS`), the level drifts and may jump (another
road). This is the multiple-model estimate in which a mode is a pair of stiffness and level; the single filters need
no mixing, since they are at rest and hear everything.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.vertical_pressure.bank import LEVELS, STIFFNESSES

PER_STIFFNESS, PER_LEVEL = 5, 20  # fine cells a node
# Declared, not tuned. 0.1 % in a second: what warming does in a minute; a sudden leak once in a quarter of an hour
STIFFNESS_DRIFT, STIFFNESS_JUMPS = 1e-3, 1e-3  # std of ln k_t after 1 s; a second
# 3 % in a second: a class in ten minutes; another surface twice a minute at most
LEVEL_DRIFT, LEVEL_JUMPS = 0.03, 0.03
_FIRST, _LAST = np.log(STIFFNESSES[[0, -1]])
LOG_STIFFNESS = np.linspace(_FIRST, _LAST, (len(STIFFNESSES) - 1) * PER_STIFFNESS + 1)
LOG_LEVEL = np.linspace(np.log(LEVELS[0]), np.log(LEVELS[-1]), (len(LEVELS) - 1) * PER_LEVEL + 1)


def _cubic() -> NDArray[np.float64]:
    """Lagrange weights from the nodes to the fine stiffnesses, (fine, nodes)."""
    nodes = len(STIFFNESSES)
    place = np.arange(len(LOG_STIFFNESS)) / PER_STIFFNESS
    weights = np.zeros((len(place), nodes))
    for f, at in enumerate(place):
        first = min(max(int(at) - 1, 0), nodes - 4)
        for a in range(first, first + 4):
            others = [b for b in range(first, first + 4) if b != a]
            weights[f, a] = np.prod([(at - b) / (a - b) for b in others])
    return weights


CUBIC = _cubic()


@compiled
def block_likelihood(summed, S, count, log_level, cubic):
    """Log-likelihood of a block of `count` samples on the fine grid, (stiffnesses, levels); summed, S as the bank's."""
    nodes, rough = summed.shape
    fine = len(log_level)
    at_nodes = np.empty((nodes, fine))
    for f in range(fine):
        j = min(f // PER_LEVEL, rough - 2)
        share = f / PER_LEVEL - j
        G = np.exp(log_level[f])
        for i in range(nodes):
            low = summed[i, j] / G + count * (log_level[f] + np.log(S[i, j]))
            high = summed[i, j + 1] / G + count * (log_level[f] + np.log(S[i, j + 1]))
            at_nodes[i, f] = -0.5 * ((1.0 - share) * low + share * high)
    return cubic @ at_nodes


@compiled
def taken(p, likelihood):
    """Bayes: p (stiffnesses, levels) times exp(likelihood), normalised, in place."""
    highest = likelihood.max()
    total = 0.0
    for i in range(p.shape[0]):
        for f in range(p.shape[1]):
            p[i, f] *= np.exp(likelihood[i, f] - highest)
            total += p[i, f]
    if total > 0.0 and np.isfinite(total):
        p /= total
    else:
        p[:] = 1.0 / p.size


@compiled
def moved_on(p, prior, drift_k, jump_k, drift_l, jump_l):
    """The grid one block on, in place. drift: share of a cell that goes to each neighbour; jump: of it, by the prior
    of the stiffness, or to every level."""
    rows, columns = p.shape
    old = p.copy()
    for i in range(rows):
        for f in range(columns):
            value = old[i, f]
            up, down = min(i + 1, rows - 1), max(i - 1, 0)
            p[i, f] = value + drift_k * (old[up, f] + old[down, f] - 2.0 * value)
    for f in range(columns):
        total = p[:, f].sum()
        for i in range(rows):
            p[i, f] += jump_k * (prior[i] * total - p[i, f])
    for i in range(rows):
        old[i] = p[i]
        mean = old[i].sum() / columns
        for f in range(columns):
            right, left = min(f + 1, columns - 1), max(f - 1, 0)
            p[i, f] = old[i, f] + drift_l * (old[i, right] + old[i, left] - 2.0 * old[i, f])
            p[i, f] += jump_l * (mean - p[i, f])


class Posterior:
    """Of one wheel. p: (fine stiffnesses, fine levels), sums to 1; begun flat over the levels."""

    def __init__(self, prior: NDArray[np.float64]) -> None:
        """prior: of each exp(LOG_STIFFNESS), at the start and after a jump; need not sum to 1."""
        self._prior = prior / prior.sum()
        self.p = np.repeat(self._prior[:, None], len(LOG_LEVEL), axis=1) / len(LOG_LEVEL)

    def take(self, summed: NDArray[np.float64], S: NDArray[np.float64], count: int) -> None:
        """A block of `count` samples; summed: sums of nu^2 over (S G) with G left at 1, i.e. of nu^2 / S."""
        taken(self.p, block_likelihood(summed, S, count, LOG_LEVEL, CUBIC))

    def pass_time(self, seconds: float) -> None:
        """What may have changed meanwhile; seconds: small."""
        cell_k, cell_l = LOG_STIFFNESS[1] - LOG_STIFFNESS[0], LOG_LEVEL[1] - LOG_LEVEL[0]
        moved_on(
            self.p,
            self._prior,
            min(0.5 * STIFFNESS_DRIFT**2 * seconds / cell_k**2, 0.25),
            min(STIFFNESS_JUMPS * seconds, 1.0),
            min(0.5 * LEVEL_DRIFT**2 * seconds / cell_l**2, 0.25),
            min(LEVEL_JUMPS * seconds, 1.0),
        )

    def stiffness(self) -> NDArray[np.float64]:
        """Probability of each exp(LOG_STIFFNESS)."""
        return self.p.sum(axis=1)

    def level(self) -> NDArray[np.float64]:
        """Probability of each exp(LOG_LEVEL)."""
        return self.p.sum(axis=0)


def moments(probability: NDArray[np.float64], value: NDArray[np.float64]) -> tuple[float, float]:
    """Mean and std."""
    mean = float(probability @ value)
    return mean, max(float(probability @ (value - mean) ** 2), 0.0) ** 0.5
