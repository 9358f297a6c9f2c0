"""How far an error may be when nothing is wrong: the more, the more there is of two causes.

    s_t^2 = floor^2 + (c_1 u_t)^2 + (c_2 v_t)^2

Causes of the motor's error: speed and strain of the servo model; of the pinion's: speeds of motor and steering
wheel. So an error of timing, or of a
limit, counts as what it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Array = NDArray[np.float64]
LEAST = 1e-6  # rad


@dataclass(frozen=True)
class Spread:
    """floor [rad], per_first and per_second [rad per unit of the cause]. ValueError if they make no sense."""

    floor: float
    per_first: float
    per_second: float

    def __post_init__(self) -> None:
        values = (self.floor, self.per_first, self.per_second)
        if not (np.isfinite(values).all() and self.floor > 0.0 and min(values) >= 0.0):
            raise ValueError(f"spread is {values}, valid: a floor above 0 and two numbers at least 0")

    def at(self, first: Array, second: Array) -> Array:
        """s [rad], (n,)."""
        return np.sqrt(self.floor * self.floor + (self.per_first * first) ** 2 + (self.per_second * second) ** 2)


def fitted_spread(errors: Sequence[Array], firsts: Sequence[Array], seconds: Sequence[Array]) -> Spread:
    """Largest likelihood of Gaussian errors, (n,) of each drive, NaN where missing. ValueError without any."""
    error, first, second = (np.concatenate(parts) for parts in (errors, firsts, seconds))
    kept = np.isfinite(error) & np.isfinite(first) & np.isfinite(second)
    if not kept.any():
        raise ValueError("no errors to fit a spread to")
    error, first, second = error[kept], first[kept], second[kept]
    typical = max(float(np.sqrt(np.mean(error**2))), LEAST)
    start = np.log([0.3 * typical, *(typical / max(float(np.std(x)), 1e-3) for x in (first, second))])

    def cost(logs: Array) -> float:
        s = Spread(max(float(np.exp(logs[0])), LEAST), *np.exp(logs[1:]).tolist()).at(first, second)
        return float(np.mean(np.log(s) + 0.5 * (error / s) ** 2))

    best = minimize(cost, start, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-6, "maxiter": 600}).x
    return Spread(max(float(np.exp(best[0])), LEAST), *np.exp(best[1:]).tolist())
