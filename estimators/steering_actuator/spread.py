"""How far an error may be when nothing is wrong: the more, the more there is of its causes.

    s_t^2 = floor^2 + sum (c_i u_it)^2

Causes of the motor's error: speed, push and strain of the servo model; of the pinion's: speeds of motor and
steering wheel. So an error of timing, of the demand's steps or of a limit counts as what it is.
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
    """floor [rad], per_cause: c_i [rad per unit of the cause]. ValueError if they make no sense."""

    floor: float
    per_cause: tuple[float, ...]

    def __post_init__(self) -> None:
        values = (self.floor, *self.per_cause)
        if not (np.isfinite(values).all() and self.floor > 0.0 and min(values) >= 0.0):
            raise ValueError(f"spread is {values}, valid: a floor above 0 and numbers at least 0")

    def at(self, causes: Array) -> Array:
        """s [rad], (n,), of causes (n, m)."""
        total = np.full(len(causes), self.floor * self.floor)
        for i, c in enumerate(self.per_cause):
            total += (c * causes[:, i]) ** 2
        return np.sqrt(total)


def fitted_spread(errors: Sequence[Array], causes: Sequence[Array]) -> Spread:
    """Largest likelihood of Gaussian errors, (n,) of each drive with causes (n, m), NaN where missing. ValueError
    without any."""
    error, cause = np.concatenate(errors), np.concatenate(causes)
    kept = np.isfinite(error) & np.isfinite(cause).all(axis=1)
    if not kept.any():
        raise ValueError("no errors to fit a spread to")
    error, cause = error[kept], cause[kept]
    typical = max(float(np.sqrt(np.mean(error**2))), LEAST)
    start = np.log([0.3 * typical, *(typical / np.maximum(cause.std(axis=0), 1e-3))])

    def spread_of(logs: Array) -> Spread:
        return Spread(max(float(np.exp(logs[0])), LEAST), tuple(np.exp(logs[1:]).tolist()))

    def cost(logs: Array) -> float:
        s = spread_of(logs).at(cause)
        return float(np.mean(np.log(s) + 0.5 * (error / s) ** 2))

    options = {"xatol": 1e-3, "fatol": 1e-6, "maxiter": 800}
    return spread_of(minimize(cost, start, method="Nelder-Mead", options=options).x)
