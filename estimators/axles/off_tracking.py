"""How much of the road is common to both wheels of a side when the rear one does not roll in the front one's track.

In a curve of curvature kappa the rear axle cuts in by l^2 kappa / 2 and slides out by its slip angle,
`SLIP_PER_ACCELERATION` a_y, over a wheelbase l: d is at most the sum of both. Two parallel tracks d apart on an
isotropic road of slope -2 have at wave number Omega = 2 pi f / v the coherency rho K_1(rho), rho = Omega d (Kamash &
Robson, J. Sound Vib. 57, 1978): 1 on one track, nothing beyond some wavelengths. It is also lost when the path bends
differently from what it did a wheelbase ago, in lane changes: the largest yaw rate of the last window counts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import kv

from estimators.axles.block import FREQUENCIES

SLIP_PER_ACCELERATION = 0.009  # rad per m/s^2. Declared: rear axle load over its cornering stiffness, passenger cars
STRAIGHT = 2e-3  # m, of d below which nothing is lost


def offset(yaw_rate: float, speed: float, wheelbase: float) -> float:
    """d [m] at a yaw rate [rad/s] and speed [m/s]."""
    curvature = abs(yaw_rate) / speed
    return 0.5 * wheelbase**2 * curvature + wheelbase * SLIP_PER_ACCELERATION * curvature * speed**2


def coherency(d: float, speed: float) -> NDArray[np.float64]:
    """gamma of each bin at an offset d [m] and speed [m/s], (BINS,), 0 to 1."""
    rho = np.maximum(2.0 * np.pi * FREQUENCIES / speed * max(d - STRAIGHT, 0.0), 1e-9)
    return np.where(rho > 1e-6, rho * kv(1, np.minimum(rho, 50.0)), 1.0)
