"""The seed's nonlinear residual (TNL) and its decision.

Seed 003, equation 14, d = S_i - S_GV the deviation of a source from the global value:

    S = sgn(d) (1 - exp(-d^2 / 2 sigma^2))

Corrected: the printed factor 1 / (0.4 sqrt(2 pi)) = 0.9974 only makes S jump at zero, and is left out. A source is
faulty where |S| > threshold. Since S rises with |d|, sigma and the threshold are one parameter:

    |d| > sigma sqrt(-2 ln(1 - threshold))

(0.06, 0.47) is 0.0676 m/s^2, (0.02, 0.78) is 0.0348 m/s^2."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def transformed(deviation: ArrayLike, sigma: float) -> NDArray[np.float64]:
    """S in (-1, 1) of deviations d, in the unit of sigma > 0."""
    d = np.asarray(deviation, dtype=np.float64)
    return -np.sign(d) * np.expm1(-0.5 * (d / sigma) ** 2)


def limit(sigma: float, threshold: float) -> float:
    """The deviation |d| beyond which |S| is above the threshold. ValueError unless sigma > 0 and 0 <= threshold < 1."""
    if not (sigma > 0.0 and 0.0 <= threshold < 1.0):
        raise ValueError(f"sigma {sigma}, threshold {threshold}; valid: above 0, and from 0 up to below 1")
    return sigma * math.sqrt(-2.0 * math.log1p(-threshold))


def faulty(deviation: ArrayLike, sigma: float, threshold: float) -> NDArray[np.bool_]:
    """The seed's decision C for deviations d, shape (n,)."""
    size: NDArray[np.float64] = np.atleast_1d(np.abs(transformed(deviation, sigma)))
    return size > threshold


def any_measurement(decisions: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """A source is faulty where it is in any of the measurements, shape (measurements, n) -> (n,). Equation 1 writes a
    product, which would ask for all of them."""
    return np.logical_or.reduce(decisions, axis=0)
