"""How far estimates are from the truth: errors of many drives on one time grid, shape (drives, time), NaN if missing.

With e_ij the error (estimate less truth) of drive i at time j, m_i = mean_j e_ij and q_i = mean_j e_ij^2 over the
samples that drive i has, and every drive weighing the same however many it lacks,

    bias = mean_i m_i    rmse^2 = mean_i q_i    std^2 = mean_i mean_j (e_ij - bias)^2 + var_i(m_i) / n

(the last term is the variance of the bias itself, so that n drives of constant error have the usual n - 1).
Overall figures take the drive as the independent unit: bias by Student t over m_i, rmse and std by Student t on the
logarithm over the drives' mean squares (of strongly correlated errors 95 % limits cover 95 % for the bias; 92 to 93 %
of 20 drives, 95 % of 60 for the others). Figures at one time compare drives only: Student t for the bias; chi-square
for rmse and std (n and n - 1 degrees, Gaussian errors); 5, 50 and 95 % quantiles with distribution-free limits,
infinite where the drives are too few to give one. Limits hold at each time alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.scores.interval import (
    CONFIDENCE,
    Band,
    Interval,
    chi_square_root,
    mean_interval,
    positive_mean_interval,
    quantile_ranks,
    student_mean,
)
from estimators.scores.survival import EventTimes


@dataclass(frozen=True, eq=False)
class ErrorOverTime:
    """Figures at each time, in the unit of the error. drives: how many have a sample there. q05, q50, q95: quantiles
    of the error over drives; q05 to q95 is the 5-95 % band.
    """

    drives: NDArray[np.int64]
    bias: Band
    rmse: Band
    std: Band
    q05: Band
    q50: Band
    q95: Band


def bias(error: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Mean error over drives and time. error: shape (drives, time)."""
    return mean_interval(_drive_means(error_matrix(error)), confidence)


def rmse(error: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Root mean square error over drives and time. error: shape (drives, time)."""
    return positive_mean_interval(_drive_means(error_matrix(error) ** 2), confidence).mapped(np.sqrt)


def std(error: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Standard deviation of the error about the common bias, over drives and time. error: shape (drives, time)."""
    given = error_matrix(error)
    means = _drive_means(given)
    seen = int(np.isfinite(means).sum())
    square = positive_mean_interval(_drive_means((given - np.nanmean(means)) ** 2), confidence)
    if square.value == 0.0:
        return square
    of_bias = float(np.nanvar(means, ddof=1)) / seen if seen > 1 else 0.0
    return square.mapped(lambda s: math.sqrt(s * (1.0 + of_bias / square.value)))


def error_over_time(error: ArrayLike, confidence: float = CONFIDENCE) -> ErrorOverTime:
    """All figures at each time. error: shape (drives, time)."""
    given = error_matrix(error)
    number = np.isfinite(given).sum(axis=0)
    counted = np.where(number > 0, number, np.nan)
    mean = student_mean(given, confidence)
    square = np.nansum(given**2, axis=0) / counted
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = np.nansum((given - mean.value) ** 2, axis=0) / (counted - 1.0)
    quantiles = (_quantile_over_time(given, p, confidence) for p in (0.05, 0.5, 0.95))
    return ErrorOverTime(
        number,
        mean,
        chi_square_root(square, counted, confidence),
        chi_square_root(variance, counted - 1.0, confidence),
        *quantiles,
    )


def settling_times(
    error: ArrayLike, time: ArrayLike, bound: float, until: ArrayLike | None = None, hold: float = 0.0
) -> EventTimes:
    """First time of each drive after which |error| stays within `bound` to its end; censored at its end if it does not.

    error: shape (drives, time). time: [s], shape (time,), rising. until: end of each drive [s], shape (drives,); the
    last time if None. hold: least time [s] that it must have stayed within. Missing samples are passed over: the error
    on either side counts, and a drive without any has not settled. ValueError unless bound > 0.
    """
    given, clock = error_matrix(error), np.asarray(time, dtype=np.float64)
    if clock.shape != given.shape[1:] or not (np.diff(clock) > 0.0).all():
        raise ValueError(
            f"time has shape {clock.shape}, valid: {given.shape[1:]} rising numbers, one a column of error"
        )
    if not bound > 0.0:
        raise ValueError(f"bound is {bound}, valid: a number above 0 in the unit of the error")
    ends = np.full(len(given), clock[-1]) if until is None else np.asarray(until, dtype=np.float64)
    if ends.shape != (len(given),) or not np.isfinite(ends).all():
        raise ValueError(f"until has shape {ends.shape}, valid: ({len(given)},) finite ends of drives [s]")
    settled_at, settled = ends.copy(), np.zeros(len(given), dtype=bool)
    for drive, row in enumerate(given):
        seen = np.flatnonzero(~np.isnan(row) & (clock <= ends[drive]))
        outside = np.flatnonzero(np.abs(row[seen]) > bound)
        first = outside[-1] + 1 if len(outside) else 0
        if first < len(seen) and ends[drive] - clock[seen[first]] >= hold:
            settled_at[drive], settled[drive] = clock[seen[first]], True
    return EventTimes(settled_at, settled)


def error_matrix(error: ArrayLike, name: str = "error") -> NDArray[np.float64]:
    """Errors as an array, shape (drives, time). ValueError for another shape, an infinite error, or no error at all."""
    given = np.asarray(error, dtype=np.float64)
    if given.ndim != 2:
        raise ValueError(f"{name} has shape {given.shape}, valid: (drives, time)")
    if np.isinf(given).any():
        raise ValueError(f"{name} holds {given[np.isinf(given)][0]}, valid: finite numbers, NaN where missing")
    if np.isnan(given).all():
        raise ValueError(f"{name} of shape {given.shape} holds no number, valid: at least one that is not NaN")
    return given


def _drive_means(given: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mean over the samples of each drive, shape (drives,), NaN for a drive without any."""
    number = np.isfinite(given).sum(axis=1)
    return np.nansum(given, axis=1) / np.where(number > 0, number, np.nan)


def _quantile_over_time(given: NDArray[np.float64], probability: float, confidence: float) -> Band:
    """NaN sorts last, so that rank k of the n samples at a time is row k - 1."""
    ordered = np.sort(given, axis=0)
    value, low, high = np.full((3, given.shape[1]), np.nan)
    number = np.isfinite(given).sum(axis=0)
    for count in np.unique(number[number > 0]).tolist():
        here = np.flatnonzero(number == count)
        table = ordered[:count, here]
        edge = np.full((1, len(here)), np.inf)
        limits = np.concatenate([-edge, table, edge])
        ranks = quantile_ranks(count, probability, confidence)
        value[here] = np.quantile(table, probability, axis=0, method="median_unbiased")
        low[here], high[here] = limits[ranks[0]], limits[ranks[1]]
    return Band(value, low, high)
