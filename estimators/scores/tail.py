"""The tail of a statistic on sound drives, to place a threshold at a false-alarm rate too low to be counted.

Peaks over threshold (Coles, An Introduction to Statistical Modeling of Extreme Values (2001), 4 and 5). Data are maxima
of blocks of equal length (a minute, a drive), the first step of declustering. Blocks above u may still follow each
other in clusters of mean length 1 / theta; theta, the extremal index, is estimated from the distances between them
(Ferro & Segers, J. R. Stat. Soc. B 65 (2003) 545, on the drives one after the other; 1 for independent blocks). All N
blocks above u are fitted, not the peaks of clusters alone, which would bend the tail (Fawcett & Walshaw, Extremes 10
(2007) 75; on independent blocks we saw xi fall by 0.04); but they count as theta N. With H hours and excesses y over u,

    theta N ~ Poisson(lambda H)     y ~ generalised Pareto: P(Y > y) = (1 + xi y / sigma)^(-1/xi), exp(-y / sigma) at 0
    rate(x) = lambda (1 + xi (x - u) / sigma)^(-1/xi)         x(rate) = u + sigma / xi ((lambda / rate)^xi - 1)

so every rate is one of clusters, that is of alarms, not of samples; theta's own uncertainty is left out (95 %
limits on blocks with theta = 0.5 covered 93 to 97 %).

u is declared: the quantile of all blocks that leaves the largest `share` above it, 10 % unless said otherwise
(DuMouchel, Ann. Stat. 11 (1983) 1019). Parameters are the maximum of the likelihood, with xi from -0.5 (below it the
theory fails; the cut is to the safe side) to 1.5.

Intervals are profile-likelihood: the least and largest value of the figure where the joint likelihood of lambda, sigma
and xi, times theta, is within chi2(1) / 2 of its maximum, which is the profile interval of any figure. The set is taken
along rays from the maximum. They tell what the sample leaves open, not whether the tail keeps its shape beyond the
data: compare fits at two shares.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, special

from estimators.scores.interval import CONFIDENCE, Interval, finite_samples

SHARE = 0.1  # of blocks above the threshold u
LEAST = 20  # independent blocks above u, theta N
SHAPES = (-0.5, 1.5)  # range of xi
RAYS, RADII, HALVINGS = 60, 10, 20  # of the search of the likelihood's level set
FARTHEST = 12.0  # end of a ray, in standard deviations


@dataclass(frozen=True, eq=False)
class Tail:
    """A fitted tail. threshold: u. excesses: of the blocks above u, rising, shape (N,). hours: H. extremal_index:
    theta. rate: lambda [1/h], scale: sigma, shape: xi, each a profile interval.
    """

    threshold: float
    excesses: NDArray[np.float64]
    hours: float
    extremal_index: float
    rate: Interval
    scale: Interval
    shape: Interval
    _level_set: NDArray[np.float64]  # rows lambda, sigma, xi; shape (3, points)

    def threshold_at(self, rate: float) -> Interval:
        """Threshold that the statistic passes `rate` times an hour. ValueError for a rate above that of u: count it."""
        if not 0.0 < rate <= self.rate.value:
            raise ValueError(f"rate is {rate:g} 1/h, valid: above 0 and at most {self.rate.value:g}, the rate at u")
        return self._profiled(lambda p: self.threshold + p[1] * special.boxcox(p[0] / rate, p[2]))

    def rate_at(self, threshold: float) -> Interval:
        """Clusters an hour [1/h] above a threshold; 0 beyond the end of a bounded tail. ValueError below u."""
        if not threshold >= self.threshold:
            raise ValueError(f"threshold is {threshold:g}, valid: from u = {self.threshold:g}, below it count")
        return self._profiled(lambda p: p[0] * np.exp(_log_survival(threshold - self.threshold, p[1], p[2])))

    def _profiled(self, figure: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> Interval:
        return _range(figure, self._level_set)


def fit_tail(
    maxima_by_drive: Sequence[ArrayLike], block_hours: float, share: float = SHARE, confidence: float = CONFIDENCE
) -> Tail:
    """Fit the tail of block maxima of sound drives.

    maxima_by_drive: for each drive its block maxima in order of time, shape (blocks,), NaN for a block without a value.
    block_hours: length of a block [h], the same for all. share: of blocks above u. ValueError for fewer than 20
    independent blocks above u.
    """
    if not (np.isfinite(block_hours) and block_hours > 0.0):
        raise ValueError(f"block_hours is {block_hours}, valid: a number of hours above 0")
    if not 0.0 < share < 1.0:
        raise ValueError(f"share is {share}, valid: above 0 and below 1")
    series = np.concatenate([*(np.asarray(maxima, dtype=np.float64).reshape(-1) for maxima in maxima_by_drive), []])
    blocks = finite_samples(series, "maxima_by_drive", LEAST)
    threshold = float(np.quantile(blocks, 1.0 - share))
    excesses = np.sort(blocks[blocks > threshold]) - threshold
    theta = extremal_index(series > threshold) if len(excesses) else 1.0
    if theta * len(excesses) < LEAST:
        raise ValueError(
            f"maxima_by_drive holds {theta * len(excesses):.3g} independent blocks above {threshold:g}, "
            f"valid: at least {LEAST}; more drives"
        )
    hours = len(blocks) * block_hours
    level_set = _level_set(excesses, theta, hours, confidence)
    rate, scale, shape = (_range(itemgetter(row), level_set) for row in range(3))
    return Tail(threshold, excesses, hours, theta, rate, scale, shape, level_set)


def block_maxima(statistic: ArrayLike, time: ArrayLike, block: float) -> NDArray[np.float64]:
    """Largest statistic of each whole block of `block` [s] from the first time on; NaN for one without a value.

    statistic: shape (n,), NaN where missing. time: [s], shape (n,). The rest that fills no block is left out.
    """
    values, times = np.asarray(statistic, dtype=np.float64), np.asarray(time, dtype=np.float64)
    if values.ndim != 1 or values.shape != times.shape or len(times) == 0:
        raise ValueError(f"statistic has shape {values.shape}, time {times.shape}, valid: both (n,), n at least 1")
    if not block > 0.0:
        raise ValueError(f"block is {block}, valid: a number of seconds above 0")
    number = np.floor((times - times.min()) / block + 1e-9).astype(np.int64)
    maxima = np.full(int(number.max()) + 1, -np.inf)
    seen = ~np.isnan(values)
    np.maximum.at(maxima, number[seen], values[seen])
    step = float(np.median(np.diff(np.sort(times)))) if len(times) > 1 else 0.0
    whole = int(np.floor((np.ptp(times) + step) / block + 1e-9))
    return np.where(np.isneginf(maxima), np.nan, maxima)[:whole]


def extremal_index(above: NDArray[np.bool_]) -> float:
    """One over the mean length of clusters, above 0 to 1, from the distances between blocks above a threshold.

    above: of each block in order, shape (blocks,), at least one true. Ferro & Segers' intervals estimator.
    """
    distance = np.diff(np.flatnonzero(above)).astype(np.float64)
    if len(distance) == 0:
        return 1.0
    if distance.max() > 2.0:
        first, second = distance - 1.0, (distance - 1.0) * (distance - 2.0)
    else:
        first, second = distance, distance**2
    return float(min(1.0, 2.0 * first.sum() ** 2 / (len(distance) * second.sum())))


def _log_survival(excess: ArrayLike, scale: ArrayLike, shape: ArrayLike) -> NDArray[np.float64]:
    """log P(Y > excess) of the generalised Pareto distribution; minus infinity beyond its end."""
    ratio, xi = np.asarray(excess) / np.asarray(scale), np.asarray(shape, dtype=np.float64)
    curved = np.abs(xi) > 1e-8
    divisor = np.where(curved, xi, 1.0)
    with np.errstate(divide="ignore"):
        return np.where(curved, -np.log1p(np.maximum(divisor * ratio, -1.0)) / divisor, -ratio)


def _log_likelihood(excesses: NDArray[np.float64], log_scale: ArrayLike, shape: ArrayLike) -> NDArray[np.float64]:
    """Of sorted excesses for parameters of any one shape; minus infinity outside `SHAPES` and beyond the end."""
    xi, scale = np.asarray(shape, dtype=np.float64), np.exp(log_scale)
    allowed = (xi >= SHAPES[0]) & (xi <= SHAPES[1]) & (1.0 + xi * excesses[-1] / scale > 0.0)
    safe = np.where(allowed, xi, 0.0)
    logs = _log_survival(excesses, scale[..., None], safe[..., None]).sum(axis=-1)
    return np.where(allowed, (1.0 + safe) * logs - len(excesses) * np.log(scale), -np.inf)


def _level_set(excesses: NDArray[np.float64], theta: float, hours: float, confidence: float) -> NDArray[np.float64]:
    """lambda, sigma, xi of the joint likelihood's level set, the maximum first; shape (3, points)."""
    number, scale = theta * len(excesses), float(excesses.mean())
    rate = number / hours
    best = optimize.minimize(
        lambda p: -float(_log_likelihood(excesses, p[0], p[1])),
        x0=(np.log(0.9 * scale), 0.1),
        method="Nelder-Mead",
        options={"xatol": 1e-6, "fatol": 1e-8},
    ).x
    peak = float(_log_likelihood(excesses, *best))
    spread = np.sqrt((1.0 + best[1]) / number)  # asymptotic: cov(log sigma, xi) = spread^2 [[2, -1], [-1, 1 + xi]]
    root = spread * np.linalg.cholesky([[2.0, -1.0], [-1.0, 1.0 + best[1]]])
    angle = np.linspace(0.0, 2.0 * np.pi, RAYS, endpoint=False)
    rays = root @ np.array([np.cos(angle), np.sin(angle)])

    def deviance(radius: NDArray[np.float64]) -> NDArray[np.float64]:
        points = best[:, None, None] + rays[:, None] * radius
        return np.maximum(2.0 * theta * (peak - _log_likelihood(excesses, points[0], points[1])), 0.0)

    limit = float(special.chdtri(1.0, 1.0 - confidence))
    inside, outside = np.zeros((1, RAYS)), np.full((1, RAYS), FARTHEST)
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        within = deviance(middle) <= limit
        inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
    radius = np.linspace(0.0, 1.0, RADII)[:, None] * inside
    slack = np.maximum(limit - deviance(radius), 0.0) / (2.0 * number)
    log_scale, shape = best[:, None, None] + rays[:, None] * radius
    # Poisson: r - 1 - log r = slack, with r = lambda H / (theta N)
    ratios = [np.real(-special.lambertw(-np.exp(-1.0 - slack), branch)) for branch in (0, -1)]
    sides = [np.stack([rate * ratio, np.exp(log_scale), shape]).reshape(3, -1) for ratio in ratios]
    return np.concatenate([np.array([[rate], [np.exp(best[0])], [best[1]]]), *sides], axis=1)


def _range(figure: Callable[[NDArray[np.float64]], NDArray[np.float64]], level_set: NDArray[np.float64]) -> Interval:
    values = figure(level_set)
    return Interval(float(values[0]), float(values.min()), float(values.max()))
