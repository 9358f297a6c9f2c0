"""What two accelerometers can tell of a tyre's stiffness in a given time: the Cramer-Rao bound.

The road is a Gaussian process of known shape, so what was measured in T seconds has the Fisher information (Whittle,
Arkiv for Matematik 2, 1953)

    J_ij = T integral over f of tr(S^-1 dS/da_i S^-1 dS/da_j),    S(f): spectral matrix of [a_s, a_us], `response`

for a = (ln k_t, ln G, w_l, w_s): the road's level G and its two slopes (`roughness`) are known (bound 1 / sqrt(J_11))
or not (the Schur complement). No unbiased estimator has a smaller std. One that knows more beforehand is bound by van
Trees' inequality instead: the information of the prior adds to J (Detection, Estimation, and Modulation Theory I, 1968,
ch. 2.4). A uniform prior has no Fisher information of its own; it counts as the Gaussian one of the same std. Left out:
anything that is not known of the quarter car, low frequencies whose few periods T holds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from estimators.quarter_car.quarter_car import QuarterCar
from estimators.quarter_car.response import measured_spectrum
from estimators.quarter_car.roughness import WAVINESS, shape

BAND = (0.2, 50.0)  # Hz, of which both accelerometers' spectra are used
_POINTS = 4000  # of the integral
_STEP = 1e-4  # of a in the central differences; their error is of its square


@dataclass(frozen=True)
class Setting:
    """One quarter car on one road. spectrum: G at 1 rad/m [m^3/rad]; speed [m/s]; noise_std [m/s^2] at rate [Hz]."""

    quarter: QuarterCar
    tyre_stiffness: float
    spectrum: float
    speed: float
    noise_std: float = 0.5
    rate: float = 1000.0
    band: tuple[float, float] = BAND

    @cached_property
    def information(self) -> NDArray[np.float64]:
        """J of (ln k_t, ln G, w_l, w_s) at slopes of 2 for one second, shape (4, 4); G that of `roughness` at its
        reference."""
        frequency = np.linspace(*self.band, _POINTS)
        inverse = np.linalg.inv(self._spectrum(np.zeros(4), frequency))
        slopes = [
            (self._spectrum(step, frequency) - self._spectrum(-step, frequency)) / (2.0 * _STEP)
            for step in _STEP * np.eye(4)
        ]
        shares = [inverse @ slope for slope in slopes]
        found = [[np.trapezoid(np.trace(p @ q, axis1=1, axis2=2).real, frequency) for q in shares] for p in shares]
        return np.array(found)

    def _spectrum(self, change: NDArray[np.float64], frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """At a changed by `change` (4,)."""
        density = 2.0 * self.noise_std**2 / self.rate
        stiffness = float(self.tyre_stiffness * np.exp(change[0]))
        omega = 2.0 * np.pi * frequency / self.speed
        road = shape(omega, WAVINESS + float(change[2]), WAVINESS + float(change[3])) * omega**2
        level = self.spectrum * np.exp(change[1]) * road
        return measured_spectrum(self.quarter, stiffness, level, self.speed, density, frequency)


def relative_stiffness_std(
    setting: Setting,
    seconds: float,
    *,
    level_std: float = np.inf,
    waviness_std: float = 0.0,
    stiffness_std: float = np.inf,
) -> float:
    """Least std of ln k_t after that time. level_std, waviness_std: prior std of ln G and of each slope, 0 for a known
    one, inf for an unknown one; stiffness_std: prior std of ln k_t."""
    stds = np.array([stiffness_std, level_std, waviness_std, waviness_std])
    unknown = np.flatnonzero(stds > 0.0)
    information = seconds * setting.information[np.ix_(unknown, unknown)] + np.diag(stds[unknown] ** -2.0)
    return float(np.linalg.inv(information)[0, 0] ** 0.5)


def pressure_std(
    setting: Setting,
    seconds: float,
    pressure_per_log_stiffness: float,
    *,
    level_std: float = np.inf,
    waviness_std: float = 0.0,
    pressure_prior_std: float = np.inf,
) -> float:
    """The same as pressure [Pa]: pressure_per_log_stiffness is dp / d ln k_t of the tyre's law [Pa]."""
    prior = pressure_prior_std / pressure_per_log_stiffness
    bound = relative_stiffness_std(
        setting, seconds, level_std=level_std, waviness_std=waviness_std, stiffness_std=prior
    )
    return pressure_per_log_stiffness * bound
