"""The seed's whole method on a record of sources: global value without the faulty ones, residual, decision, recovery.

Seed 003, sections 3 and 4, with the corrections of `global_value` and `residual`. In each sample the sources are judged
against the global value of the sample before, updated by those that are not faulty; a source recovers as soon as its
residual is small again. Where all are excluded the global value stays, `alone` says so, and a source that comes back to
it is taken in again: the answer is defined, if not right.

Sources from wheel speeds, equations 2 to 5: (3) needs plus,

    v = (v_R + v_L) / 2,   a = (v(t) - v(t - T)) / T,   yaw rate = (v_R - v_L) / track
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.redundancy.global_value import MEMORY, WeightedMean
from estimators.redundancy.residual import limit


@dataclass(frozen=True)
class Parameters:
    """sigma: sensitivity, in the unit of the quantity; threshold: of |S|; memory: g of the weights."""

    sigma: float
    threshold: float
    memory: float = MEMORY

    @property
    def limit(self) -> float:
        """The deviation that is faulty."""
        return limit(self.sigma, self.threshold)


FALSE_ALARMS_FIRST = Parameters(0.06, 0.47)  # Table 3: m/s^2
ERROR_FIRST = Parameters(0.02, 0.78)  # Table 4: m/s^2


@dataclass(frozen=True)
class Judged:
    """value: global value, (n,); faulty: decisions, (n, m); alone: samples in which no source was left, (n,)."""

    value: NDArray[np.float64]
    faulty: NDArray[np.bool_]
    alone: NDArray[np.bool_]


def judge(said: NDArray[np.float64], parameters: Parameters) -> Judged:
    """said: (n, m), NaN where a source is silent: silence is no fault, but takes no part."""
    n, m = said.shape
    method, far = WeightedMean(m, parameters.memory), parameters.limit
    value, alone, faulty = np.empty(n), np.empty(n, dtype=bool), np.zeros((n, m), dtype=bool)
    excluded = np.zeros(m, dtype=bool)
    for k in range(n):
        value[k] = method.step(said[k], excluded)
        alone[k] = method.alone
        excluded = np.abs(said[k] - value[k]) > far  # NaN is not
        faulty[k] = excluded
    return Judged(value, faulty, alone)


def pair_sources(
    left: NDArray[np.float64], right: NDArray[np.float64], track: float, period: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Longitudinal acceleration [m/s^2] and yaw rate [rad/s] of a wheel pair from circumferential speeds [m/s] at a
    sampling period [s], shape (n,); the first acceleration is 0."""
    speed = 0.5 * (left + right)
    return np.diff(speed, prepend=speed[0]) / period, (right - left) / track
