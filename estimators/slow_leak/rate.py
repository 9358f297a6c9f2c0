"""How fast a tyre loses pressure, from its days' values since the leak's start, with a 95 % interval.

    y_t = y_0 - rate (t - t_0) + w_t + v_t

w a random walk of variance wander s^2 a day, v white of variance s^2: generalised least squares, s from the residuals
(Student's t, n - 2 degrees), so that a loss that is no straight line widens the interval. Left out: that the start was
chosen by the same values (it leans to steep rates at the alarm, less and less after it).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.scores.interval import Interval, student_quantile
from estimators.slow_leak.numbers import DAY, MODEL

LEAST_DAYS = 4


@dataclass(frozen=True, eq=False)
class Line:
    """rate: loss [Pa/s] with its interval. At days, shape (n,): the line [Pa] and the half width of its 95 % band."""

    rate: Interval
    day: NDArray[np.float64]
    level: NDArray[np.float64]
    reach: NDArray[np.float64]


def line_of(day: ArrayLike, pressure: ArrayLike, least_noise: float = MODEL.least_noise_std) -> Line | None:
    """Through days' values, shape (n,): number of the day, pressure [Pa], NaN where missing. None for too few days."""
    t, y = np.asarray(day, dtype=np.float64), np.asarray(pressure, dtype=np.float64)
    known = np.isfinite(t) & np.isfinite(y)
    t, y = t[known], y[known]
    if len(np.unique(t)) < LEAST_DAYS:
        return None
    since = t - t[0]
    design = np.stack([np.ones(len(t)), since], axis=1)
    covariance = np.eye(len(t)) + MODEL.wander * np.minimum(since[:, None], since[None, :])
    weighed = np.linalg.solve(covariance, np.column_stack([design, y - y.mean()]))
    spread = np.linalg.inv(design.T @ weighed[:, :2])
    found = spread @ (design.T @ weighed[:, 2])
    residual = y - y.mean() - design @ found
    found[0] += y.mean()
    noise = math.sqrt(
        max(float(residual @ (weighed[:, 2] - weighed[:, :2] @ (found - [y.mean(), 0.0]))), 0.0) / (len(t) - 2)
    )
    reach = float(student_quantile(len(t) - 2)) * max(noise, 0.5 * least_noise)
    rate, half = -float(found[1]) / DAY, reach * math.sqrt(spread[1, 1]) / DAY
    band = reach * np.sqrt(np.einsum("ij,jk,ik->i", design, spread, design))
    return Line(Interval(rate, rate - half, rate + half), t, design @ found, band)
