"""Relative rolling-radius change of each wheel from the residuals' changes, and its pressure.

Five residuals y = MIXING e + noise, four changes e. The mean of the four is unobservable and ASSUMED ZERO: one wheel
that loses x shows as -3/4 x, the other three as +1/4 x. The rest has a weak prior (std `PRIOR`), so the least squares
is the minimum-norm one where the data speak, and a contrast that no method sees keeps the prior's width.

The diagonal contrast reaches up to three residuals through the same wheel speeds; they are weighted as if independent,
and the variance of that contrast is then multiplied by the number of sources that carried it. Day-to-day changes that
are no loss of pressure (load, temperature, speed) enter as `FLOOR`.
Pressure: d p = d e / S, S the car's radius sensitivity, whose spread of real cars is part of the std.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.wheel_radius.residuals import MIXING

PRIOR = 3e-3  # about a third of the pressure
FLOOR = np.array([1.0e-4, 1.0e-4, 1.0e-4, 3.0e-4, 3.0e-4])  # declared, of the five residuals
CONTRASTS = 0.5 * np.array([[1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0]])  # orthonormal rows
_DIAGONAL = 2


def wheel_change(
    change: NDArray[np.float64], covariance: NDArray[np.float64], used: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Contrasts (left-right, front-rear, diagonal; each half a sum) and their covariance.

    change: (5,) residuals against calibration; covariance: (5, 5); used: (5,) which count. Returns (3,), (3, 3).
    """
    mixing = (MIXING @ CONTRASTS.T)[used]
    noise = covariance[np.ix_(used, used)] + np.diag(FLOOR[used] ** 2)
    weight = mixing.T @ np.linalg.inv(noise)
    posterior = np.linalg.inv(weight @ mixing + np.eye(3) / PRIOR**2)
    contrasts = posterior @ weight @ change[used]
    sources = int(used[0]) + int(used[1:3].all()) + int(used[3:5].all())
    widen = np.ones(3)
    widen[_DIAGONAL] = np.sqrt(max(sources, 1))
    return contrasts, posterior * np.outer(widen, widen)


def per_wheel(
    contrasts: NDArray[np.float64], covariance: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Radius change of fl fr rl rr with zero mean (4,) [-], and its std (4,)."""
    spread = CONTRASTS.T @ covariance @ CONTRASTS
    return CONTRASTS.T @ contrasts, np.sqrt(np.diag(spread))


def pressure_change(
    car: Car, radius_change: NDArray[np.float64], std: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Pressure change [Pa] that such a radius change means, and its std, with the sensitivity's own."""
    pressure = radius_change / car.radius_sensitivity
    return pressure, np.hypot(std / car.radius_sensitivity, pressure * car.radius_sensitivity_relative_std)
