"""Does an estimator's reported uncertainty tell the truth? Normalised estimation error squared (NEES) and shares.

    NEES = e' P^-1 e,   (e / std)^2 for one quantity

Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), 5.4.2. If errors are
Gaussian with the reported covariance P, n times the mean NEES of n drives at one time is chi-square with n d degrees,
d quantities. Above d the estimator is overconfident, below it is too modest.

At one time, the interval of the mean is n mean d / chi2 / n for the two chi-square limits, and it holds d exactly if
the mean lies between chi2 / n: the usual acceptance region, given as well. Over all time the NEES of one drive is
correlated to an unknown extent, so a drive's mean is one sample and the interval Student t on the logarithm over
drives. Errors that are not Gaussian show in the shares of |e| < std (68.3 %) and < 2 std (95.4 %).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from estimators.scores.accuracy import error_matrix
from estimators.scores.interval import (
    CONFIDENCE,
    Band,
    Interval,
    chi_square_limits,
    positive_mean_interval,
    shared_proportion_interval,
)

GAUSSIAN_SHARES = tuple(float(2.0 * special.ndtr(k) - 1.0) for k in (1.0, 2.0))  # of |e| < std and < 2 std


@dataclass(frozen=True, eq=False)
class Consistency:
    """quantities: d, what the mean NEES should be. mean: over drives and time. over_time, acceptance: the mean at each
    time with its interval, and the region where a consistent estimator's mean lies with the stated confidence (its
    value is d). Consistent at a time: over_time's interval holds d, which is: its value lies in acceptance.
    """

    quantities: int
    mean: Interval
    over_time: Band
    acceptance: Band

    @property
    def consistent(self) -> bool:
        """Whether the overall interval holds what the mean should be."""
        return self.quantities in self.mean

    @property
    def ratio(self) -> Interval:
        """Root mean square of the error in reported standard deviations: 1 if they are true, above if too small."""
        return self.mean.mapped(lambda nees: float(np.sqrt(nees / self.quantities)))


def nees(error: ArrayLike, covariance: ArrayLike) -> NDArray[np.float64]:
    """NEES of errors of several quantities. error: shape (..., d). covariance: shape (..., d, d). Gives shape (...),
    NaN where an error or a covariance is missing. ValueError for a covariance that is not positive definite.
    """
    e, p = np.asarray(error, dtype=np.float64), np.asarray(covariance, dtype=np.float64)
    if e.ndim < 1 or p.shape != (*e.shape, e.shape[-1]):
        raise ValueError(f"covariance has shape {p.shape}, valid: {(*e.shape, *e.shape[-1:])} beside error {e.shape}")
    present = np.isfinite(e).all(axis=-1) & np.isfinite(p).all(axis=(-2, -1))
    found = np.full(e.shape[:-1], np.nan)
    try:
        root = np.linalg.cholesky(p[present])
    except np.linalg.LinAlgError:
        raise ValueError("covariance is singular or indefinite somewhere, valid: positive definite") from None
    found[present] = np.sum(np.linalg.solve(root, e[present][..., None])[..., 0] ** 2, axis=-1)
    return found


def nees_of_std(error: ArrayLike, std: ArrayLike) -> NDArray[np.float64]:
    """NEES of one quantity. error, std: shape (drives, time), or std one that fits it. NaN where either is missing.
    ValueError for a std that is not above 0.
    """
    return (error_matrix(error) / _positive(std)) ** 2


def nees_consistency(normalised: ArrayLike, quantities: int = 1, confidence: float = CONFIDENCE) -> Consistency:
    """Judge NEES of drives over time, shape (drives, time), of so many quantities each; NaN where missing."""
    given = error_matrix(normalised, "normalised")
    if quantities < 1:
        raise ValueError(f"quantities is {quantities}, valid: a whole number from 1")
    number = np.isfinite(given).sum(axis=0)
    counted = np.where(number > 0, number, np.nan)
    mean = np.nansum(given, axis=0) / counted
    low, high = chi_square_limits(counted * quantities, confidence)
    seen = np.isfinite(given).any(axis=1)
    return Consistency(
        quantities,
        positive_mean_interval(np.nanmean(given[seen], axis=1), confidence),
        Band(mean, mean * counted * quantities / high, mean * counted * quantities / low),
        Band(np.where(number > 0, float(quantities), np.nan), low / counted, high / counted),
    )


def share_within(error: ArrayLike, std: ArrayLike, multiple: float, confidence: float = CONFIDENCE) -> Interval:
    """Share of the time in which |error| < multiple x std, each drive weighing the same.

    error, std: shape (drives, time). Compare with `GAUSSIAN_SHARES`.
    """
    ratio = np.abs(error_matrix(error)) / _positive(std)
    present = np.isfinite(ratio)
    seen = present.any(axis=1)
    if not seen.any():
        raise ValueError("error and std have no sample in common, valid: at least one where neither is NaN")
    shares = ((ratio < multiple) & present)[seen].sum(axis=1) / present[seen].sum(axis=1)
    return shared_proportion_interval(shares, confidence)


def _positive(std: ArrayLike) -> NDArray[np.float64]:
    given = np.asarray(std, dtype=np.float64)
    if (given <= 0.0).any():
        raise ValueError(f"std holds {given[given <= 0.0].flat[0]}, valid: numbers above 0, NaN where missing")
    return given
