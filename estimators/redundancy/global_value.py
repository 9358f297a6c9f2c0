"""What several sources of one quantity say together: the seed's weighted mean, beside the mean and a Kalman filter.

Seed 003, equations 15 to 19 (method 3), against the mean (method 1) and a Kalman filter (method 2):

    S_GV(t) = sum W_i S_i,   W_i = (1/r_i) / sum(1/r_j),   r_i(t) = g r_i(t-1) + (1 - g) |S_i(t) - S_GV(t-1)|

Corrected: (17) is singular at r = 0, so r is at least `LEAST`; (21) lacks a square (see `mean_square_error`). Sources
that are excluded or silent take no part; where none is left the answer is the last value, and the flag says so. Vectors
of n samples from m sources are arrays (n, m), NaN where a source is silent."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LEAST = 1e-6  # of a deviation r, in the unit of the quantity: far below any sensor's noise
MEMORY = 0.99  # g; the seed gives none
FIRST = 0.1  # r at the start, the same for all: equal weights


class WeightedMean:
    """Method 3, one sample at a time. sources: how many. memory: g, 0 <= g < 1."""

    def __init__(self, sources: int, memory: float = MEMORY, first: float = FIRST) -> None:
        if not 0.0 <= memory < 1.0:
            raise ValueError(f"memory is {memory}, valid: from 0 up to below 1")
        self._memory = memory
        self.deviation = np.full(sources, float(first))
        self.value = np.nan
        self.alone = True

    def step(self, said: NDArray[np.float64], excluded: NDArray[np.bool_]) -> float:
        """said: (m,), NaN where silent; excluded: (m,). The global value; `alone` is True where no source was left and
        it is the last one (NaN before the first)."""
        heard = np.isfinite(said)
        if np.isfinite(self.value):
            off = np.abs(said[heard] - self.value)
            self.deviation[heard] = self._memory * self.deviation[heard] + (1.0 - self._memory) * off
        used = heard & ~excluded
        self.alone = not used.any()
        if not self.alone:
            weight = 1.0 / np.maximum(self.deviation[used], LEAST)
            self.value = float(weight @ said[used] / weight.sum())
        return self.value


def weighted_mean(said: NDArray[np.float64], memory: float = MEMORY) -> NDArray[np.float64]:
    """Method 3 over a record, shape (n, m) -> (n,); nothing is excluded."""
    method, none = WeightedMean(said.shape[1], memory), np.zeros(said.shape[1], dtype=bool)
    return np.array([method.step(row, none) for row in said])


def plain_mean(said: NDArray[np.float64]) -> NDArray[np.float64]:
    """Method 1, shape (n, m) -> (n,): with one of m sources off by b its mean square error is (b/m)^2 more."""
    return said.mean(axis=1)


def kalman_mean(said: NDArray[np.float64], variance: NDArray[np.float64], walk: float) -> NDArray[np.float64]:
    """Method 2, shape (n, m) -> (n,): random walk of the quantity with variance `walk` a sample, white noise of the
    sources of these variances, shape (m,). The seed says no more of its filter than that it is one."""
    value, spread = float(said[0].mean()), float(variance.mean())
    out = np.empty(len(said))
    for k, row in enumerate(said):
        information = 1.0 / (spread + walk)
        value = (value * information + float((row / variance).sum())) / (information + float((1.0 / variance).sum()))
        spread = 1.0 / (information + float((1.0 / variance).sum()))
        out[k] = value
    return out


def mean_square_error(value: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
    """Of the global value [unit^2]: the seed's Table 1."""
    return float(np.mean((value - truth) ** 2))
