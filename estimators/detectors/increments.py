"""Distributions of what one Gaussian residual adds to a CUSUM, as the integral equations need them.

x ~ N(mean, std^2). Each distribution gives, vectorised over u,
    cdf(u)           P(s <= u)
    tail(u)          P(s > u), accurate where it is small
    partial_mean(u)  E[s; s <= u], the integral of v dF(v) up to u
in closed form: s = x (mean), s = x^2 (variance: a scaled chi-square with one degree of freedom), s = x where |x| <=
limit and 0 else (local CUSUM: an atom at 0), and the negative of s = x^2 for a decrease.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

Array = NDArray[np.float64]


def normal_density(z: Array) -> Array:
    """Of the standard normal distribution."""
    return np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)


class Increments(ABC):
    """The distribution of a scalar s."""

    @abstractmethod
    def cdf(self, u: Array) -> Array:
        """P(s <= u)."""

    @abstractmethod
    def tail(self, u: Array) -> Array:
        """P(s > u)."""

    @abstractmethod
    def partial_mean(self, u: Array) -> Array:
        """E[s; s <= u]."""


@dataclass(frozen=True)
class Gaussian(Increments):
    """s = x."""

    mean: float
    std: float

    def cdf(self, u: Array) -> Array:
        """P(s <= u)."""
        return ndtr((u - self.mean) / self.std)

    def tail(self, u: Array) -> Array:
        """P(s > u)."""
        return ndtr((self.mean - u) / self.std)

    def partial_mean(self, u: Array) -> Array:
        """E[s; s <= u]."""
        z = (u - self.mean) / self.std
        return self.mean * ndtr(z) - self.std * normal_density(z)


@dataclass(frozen=True)
class Squared(Increments):
    """s = x^2."""

    mean: float
    std: float

    def _ends(self, u: Array) -> tuple[Array, Array]:
        root = np.sqrt(np.maximum(u, 0.0))
        return (-root - self.mean) / self.std, (root - self.mean) / self.std

    def cdf(self, u: Array) -> Array:
        """P(s <= u)."""
        low, high = self._ends(u)
        return ndtr(high) - ndtr(low)

    def tail(self, u: Array) -> Array:
        """P(s > u)."""
        low, high = self._ends(u)
        return ndtr(-high) + ndtr(low)

    def partial_mean(self, u: Array) -> Array:
        """E[s; s <= u]: with x = m + s z, the second moment of x between -sqrt(u) and sqrt(u)."""
        low, high = self._ends(u)
        m, s = self.mean, self.std
        edge = (2.0 * m * s + s * s * high) * normal_density(high) - (2.0 * m * s + s * s * low) * normal_density(low)
        return (m * m + s * s) * (ndtr(high) - ndtr(low)) - edge


@dataclass(frozen=True)
class NegativeSquared(Increments):
    """s = -x^2."""

    mean: float
    std: float

    def cdf(self, u: Array) -> Array:
        """P(s <= u)."""
        return Squared(self.mean, self.std).tail(-u)

    def tail(self, u: Array) -> Array:
        """P(s > u)."""
        return Squared(self.mean, self.std).cdf(-u)

    def partial_mean(self, u: Array) -> Array:
        """E[s; s <= u]."""
        return Squared(self.mean, self.std).partial_mean(-u) - (self.mean**2 + self.std**2)


@dataclass(frozen=True)
class Filtered(Increments):
    """s = x where |x| <= limit, 0 else."""

    mean: float
    std: float
    limit: float

    def cdf(self, u: Array) -> Array:
        """P(s <= u)."""
        inside, limit = Gaussian(self.mean, self.std), np.array(self.limit)
        below = inside.cdf(-limit)
        return inside.cdf(np.clip(u, -limit, limit)) - below + np.where(u >= 0.0, below + inside.tail(limit), 0.0)

    def tail(self, u: Array) -> Array:
        """P(s > u)."""
        inside, limit = Gaussian(self.mean, self.std), np.array(self.limit)
        above = inside.tail(limit)
        return inside.tail(np.clip(u, -limit, limit)) - above + np.where(u < 0.0, above + inside.cdf(-limit), 0.0)

    def partial_mean(self, u: Array) -> Array:
        """E[s; s <= u]."""
        inside = Gaussian(self.mean, self.std)
        below = inside.partial_mean(np.array([-self.limit]))
        return inside.partial_mean(np.clip(u, -self.limit, self.limit)) - below
