"""What two hub accelerometers of one side can tell, when their wheels share the road: the Cramer-Rao bound.

As `quarter_car.bound` (Whittle), for the spectral matrix S of the aligned hubs (`likelihood`) and a = (ln k_f, ln k_r,
ln lambda, delta, w_l, w_s), the coherency c known:

    J_ij = T integral over f of tr(S^-1 dS/da_i S^-1 dS/da_j)

What is unknown besides is in the inverse; a prior adds its information (van Trees). With c = 0 front and rear still
share the road's level and slopes, of which `quarter_car.roughness` has the prior. For a car whose suspension has 38
kN/m and 3 kN s/m: front-rear difference 2.7, 1.2, 0.3 % after 2 s with c = 0.9, 0.98, 0.999. Left out: what a filter
needs to settle, parameters that are wrong, c that must be measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from estimators.axles.response import Axles, hub_responses
from estimators.quarter_car.roughness import WAVINESS, WAVINESS_STD, shape

BAND = (0.5, 28.0)  # Hz: to the edge of the anti-alias filter
_POINTS = 800  # of the integral
_STEPS = np.array([1e-4, 1e-4, 1e-4, 1e-5, 1e-4, 1e-4])  # of a, in the central differences


@dataclass(frozen=True)
class SharedRoad:
    """One side of a car on one road. stiffness: of front and rear [N/m]; spectrum: G at 1 rad/m [m^3/rad], falling
    with slope -2; speed [m/s]; coherency: c, of all frequencies; noise_std [m/s^2] at rate [Hz]; waviness_std: prior of
    w_l and w_s."""

    axles: Axles
    stiffness: tuple[float, float]
    spectrum: float
    speed: float
    coherency: float
    noise_std: float = 0.5
    rate: float = 1000.0
    band: tuple[float, float] = BAND
    waviness_std: float = WAVINESS_STD

    def matrix(self, change: NDArray[np.float64], frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """S at a changed by `change` (6,), (n, 2, 2) [(m/s^2)^2/Hz]."""
        H = np.empty((2, len(frequency)), np.complex128)
        kf, kr = self.stiffness[0] * np.exp(change[0]), self.stiffness[1] * np.exp(change[1])
        axles = self.axles._replace(wheelbase=self.axles.wheelbase + change[3])
        hub_responses(axles, kf, kr, self.speed, 1.0, frequency, H)
        H[1] *= np.exp(-2j * np.pi * frequency * change[3] / self.speed)
        shared = np.array([[1.0, self.coherency], [self.coherency, 1.0]])
        wave, long, short = 2.0 * np.pi * frequency / self.speed, WAVINESS + change[4], WAVINESS + change[5]
        level = self.spectrum * np.exp(change[2]) * shape(wave, long, short) * wave**2
        road = level[:, None, None] * np.einsum("in,jn,ij->nij", H, H.conj(), shared)
        return np.asarray(road + 2.0 * self.noise_std**2 / self.rate * np.eye(2))

    @cached_property
    def information(self) -> NDArray[np.float64]:
        """J of one second, (6, 6)."""
        frequency = np.linspace(*self.band, _POINTS)
        inverse = np.linalg.inv(self.matrix(np.zeros(len(_STEPS)), frequency))
        shares = []
        for step in np.diag(_STEPS):
            slope = (self.matrix(step, frequency) - self.matrix(-step, frequency)) / (2.0 * step.max())
            shares.append(inverse @ slope)
        found = [[np.trapezoid(np.trace(p @ q, axis1=1, axis2=2).real, frequency) for q in shares] for p in shares]
        return np.array(found)


def covariance(road: SharedRoad, seconds: float, stiffness_std: float = np.inf) -> NDArray[np.float64]:
    """Least covariance of (ln k_f, ln k_r) after that time, (2, 2); the road and delta unknown. stiffness_std: prior
    std of each ln k."""
    slopes = road.waviness_std**-2.0
    prior = np.diag([stiffness_std**-2.0, stiffness_std**-2.0, 0.0, 0.0, slopes, slopes])
    return np.asarray(np.linalg.inv(seconds * road.information + prior)[:2, :2])


def difference_std(road: SharedRoad, seconds: float) -> float:
    """Least std of ln k_f - ln k_r."""
    C = covariance(road, seconds)
    return float(np.sqrt(C[0, 0] + C[1, 1] - 2.0 * C[0, 1]))


def pressure_std(
    road: SharedRoad, seconds: float, pressure_per_log_stiffness: float, pressure_prior_std: float = np.inf
) -> tuple[float, float]:
    """Least std of front and rear pressure [Pa]; pressure_per_log_stiffness: dp / d ln k of the tyre's law [Pa]."""
    C = covariance(road, seconds, pressure_prior_std / pressure_per_log_stiffness)
    front, rear = pressure_per_log_stiffness * np.sqrt(np.diag(C))
    return float(front), float(rear)
