"""What the bank's likelihoods say of one wheel: a probability over stiffness and road, all continuous.

A hidden Markov model (Rabiner, Proc. IEEE 77, 1989, forward algorithm) on a grid of the road's long slope w_l, its
short slope w_s (0.2 apart), ln k_t (2.5 % apart) and ln lambda (25 % apart; both finer than what is ever known of them,
given the drifts). Over the level each filter has its own law of the log-likelihood of a block of N samples,

    -(s / lambda + N ln lambda + N ln S) / 2,    s = sum nu^2 / S

blended between the nodes of the level; over w_s and stiffness ln s and ln S are interpolated by cubics: s itself, and
the likelihood, rise too steeply where a soft tyre's long footprint blinds a slow car's filter. From block to block the
stiffness drifts (warming) and may jump (a leak), the road's level and short slope drift, and the road may jump: another
surface, of which no more is known than at the start. That level and slope wander costs next to nothing: unknown they
are anyway, and what is lost with them is lost in each second alike. This is the multiple-model estimate in which a mode
is a stiffness and a road; the single filters need no mixing, since they hear everything.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.quarter_car.roughness import prior
from estimators.vertical_pressure.bank import LEVELS, LONG, SHORT, STIFFNESSES
from estimators.vertical_pressure.grid import between, likelihood, moved_on, taken

PER_STIFFNESS, PER_SHORT, PER_LEVEL = 5, 2, 11  # fine cells a node
HIGHEST_LEVEL = 1e-3  # lambda [m^3/rad]: class E and F
# Declared, not tuned. 0.1 % in a second: what warming does in a minute; a sudden leak once in a quarter of an hour
STIFFNESS_DRIFT, STIFFNESS_JUMPS = 1e-3, 1e-3  # std of ln k_t after 1 s; a second
# 15 % of level and 0.03 of w_s in a second; another surface twice a minute at most. With rarer surfaces (one in 300 s)
# and levels that jump alone 3 of 12 wheels follow half of a sudden fall of 50 kPa in 45 s, not 1 of 8, but the measured
# road, whose slopes are not those of its first seconds, then reads 40 kPa high
LEVEL_DRIFT, SHORT_DRIFT, ROAD_JUMPS = 0.15, 0.03, 0.03
TINY = 1e-300


def _fine(nodes: NDArray[np.float64], per: int) -> NDArray[np.float64]:
    return np.linspace(nodes[0], nodes[-1], (len(nodes) - 1) * per + 1)


LOG_STIFFNESS = _fine(np.log(STIFFNESSES), PER_STIFFNESS)
FINE_SHORT = _fine(SHORT, PER_SHORT)
_CELL_LEVEL = float(np.log(LEVELS[1] / LEVELS[0])) / PER_LEVEL
LOG_LEVEL = np.log(LEVELS[0]) + _CELL_LEVEL * np.arange(round(np.log(HIGHEST_LEVEL / LEVELS[0]) / _CELL_LEVEL) + 1)
SHAPE = (len(LONG), len(FINE_SHORT), len(LOG_STIFFNESS), len(LOG_LEVEL))


def cubic(nodes: int, per: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Lagrange through the four nearest of evenly spaced nodes: the first of them and their weights, (fine,) and
    (fine, 4)."""
    place = np.arange((nodes - 1) * per + 1) / per
    first = np.clip(place.astype(np.int64) - 1, 0, nodes - 4)
    u = place - first
    weights = [np.prod([(u - b) / (a - b) for b in range(4) if b != a], axis=0) for a in range(4)]
    return first, np.ascontiguousarray(np.transpose(weights))


_FIRST_K, _WEIGHT_K = cubic(len(STIFFNESSES), PER_STIFFNESS)
_FIRST_S, _WEIGHT_S = cubic(len(SHORT), PER_SHORT)


class Posterior:
    """Of one wheel. p: `SHAPE`, sums to 1; begun with the road's prior, every level alike."""

    def __init__(self, prior_k: NDArray[np.float64]) -> None:
        """prior_k: of each exp(LOG_STIFFNESS), at the start and after a jump; need not sum to 1."""
        self._prior = prior_k / prior_k.sum()
        road = prior(LONG)[:, None, None] * prior(FINE_SHORT)[:, None] * np.full(len(LOG_LEVEL), 1.0 / len(LOG_LEVEL))
        self._road = np.ascontiguousarray(road)
        self.p = np.ascontiguousarray(self._road[:, :, None, :] * self._prior[:, None])
        self._likelihood, self._new = np.empty(SHAPE), np.empty(SHAPE)
        self._summed, self._variance = np.empty((*SHAPE[:3], len(LEVELS))), np.empty((*SHAPE[:3], len(LEVELS)))

    def take(self, summed: NDArray[np.float64], log_variance: NDArray[np.float64], count: int) -> None:
        """A block of `count` samples; summed: sums of nu^2 / S, log_variance: ln S, of the bank's nodes."""
        fine = _FIRST_S, _WEIGHT_S, _FIRST_K, _WEIGHT_K
        between(np.log(np.maximum(summed, TINY)), *fine, self._summed)
        between(log_variance, *fine, self._variance)
        cells = SHAPE[0] * SHAPE[1] * SHAPE[2]
        highest = likelihood(
            self._summed.reshape(cells, -1), self._variance.reshape(cells, -1), count, PER_LEVEL, LOG_LEVEL,
            self._likelihood.reshape(cells, -1),
        )  # fmt: skip
        taken(self.p.reshape(-1, SHAPE[3]), self._likelihood.reshape(-1, SHAPE[3]), highest)

    def pass_time(self, seconds: float) -> None:
        """What may have changed meanwhile; seconds: small."""
        moved_on(
            self.p,
            self._new,
            self._prior,
            self._road,
            _share(STIFFNESS_DRIFT, LOG_STIFFNESS, seconds),
            min(STIFFNESS_JUMPS * seconds, 1.0),
            _share(SHORT_DRIFT, FINE_SHORT, seconds),
            _share(LEVEL_DRIFT, LOG_LEVEL, seconds),
            min(ROAD_JUMPS * seconds, 1.0),
        )
        self.p, self._new = self._new, self.p

    def stiffness(self) -> NDArray[np.float64]:
        """Probability of each exp(LOG_STIFFNESS)."""
        return self.p.sum(axis=(0, 1, 3))

    def road(self) -> NDArray[np.float64]:
        """Of each FINE_SHORT and LOG_LEVEL, (shorts, levels)."""
        return self.p.sum(axis=(0, 2))


def _share(drift: float, cells: NDArray[np.float64], seconds: float) -> float:
    """Of a cell that goes to each neighbour; drift: std after 1 s."""
    return min(0.5 * drift**2 * seconds / float(cells[1] - cells[0]) ** 2, 0.12)


def moments(probability: NDArray[np.float64], value: NDArray[np.float64]) -> tuple[float, float]:
    """Mean and std."""
    mean = float(probability @ value)
    return mean, max(float(probability @ (value - mean) ** 2), 0.0) ** 0.5
