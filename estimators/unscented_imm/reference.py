"""The interacting multiple model of unscented filters, written to be read: filterpy's filters, mixed here.

Brancati & Tufano, Machines 2022, 10, 1221, eq. 9 to 15, with what is wrong in print corrected (Bar-Shalom, Li,
Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, ch. 11.6): with M[i, j] the probability to
go from i to j, mu the modes' probabilities,

    c_j      = sum_i M[i, j] mu_i
    w_ij     = M[i, j] mu_i / c_j                            sum over i is 1 (eq. 10 uses the predicted mu twice)
    x*_j     = sum_i w_ij x_i
    P*_j     = sum_i w_ij (P_i + (x_i - x*_j)(.)')           eq. 11 lacks the spread of the means
    ln mu_j  = ln c_j - (nu' S^-1 nu + ln det S) / 2 + const     det^-1/2 (eq. 12 has det^-1); in the log domain

filterpy 2.0.0's IMMEstimator is not used for the mixing: its likelihoods stop at 2.2e-308, where all modes look alike;
`update(None)` keeps the stale likelihood; one NaN stays for good; `predict(u)` hands u on as a time step; its docstring
has the matrix transposed (the code means row to column, as here). `compiled_bank` is the same, fast; tested equal.
"""

from __future__ import annotations

import math

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter
from numpy.typing import NDArray

from estimators.quarter_car.quarter_car import QuarterCar, accelerations
from estimators.unscented_imm.settings import STIFFNESS, Settings

felt = accelerations.py_func


def quarter_step(state: NDArray, dt: float, quarter: QuarterCar, phi: float, road: float | None) -> NDArray:
    """Eq. 15, forward Euler (at 1 ms its lag alone makes k_t 2 to 3 % low); road [m], None where it is the sixth state
    and decays by phi."""
    height = state[5] if road is None else road
    a_s, a_us = felt(quarter, *state[:4], state[STIFFNESS], height)
    moved = state.copy()
    moved[:4] += dt * np.array([state[2], state[3], a_s, a_us])
    if road is None:
        moved[5] *= phi
    return moved


class UnscentedMode:
    """One mode's filter."""

    def __init__(self, settings: Settings, wheel: int, mode: int) -> None:
        n = settings.size
        points = MerweScaledSigmaPoints(n, alpha=1.0, beta=0.0, kappa=0.0)
        self._quarter = QuarterCar(*settings.quarters[wheel, mode].tolist())
        self._phi = float(settings.phi[mode])
        self.filter = UnscentedKalmanFilter(n, 2, settings.step, hx=self.felt, fx=quarter_step, points=points)
        self.filter.x, self.filter.P = settings.start.copy(), np.diag(settings.start_variance)
        self.filter.Q, self.filter.R = np.diag(settings.wander[mode]), np.diag(settings.measured_variance)

    def felt(self, state: NDArray, road: float | None) -> NDArray:
        """[a_s, a_us] in a state [m/s^2]."""
        height = state[5] if road is None else road
        return np.array(felt(self._quarter, *state[:4], state[STIFFNESS], height))

    def step(self, measured: NDArray, road_before: float | None, road: float | None) -> float:
        """One sample (2,) [m/s^2]; the log-likelihood of what was measured."""
        f = self.filter
        f.predict(quarter=self._quarter, phi=self._phi, road=road_before)
        f.update(measured, road=road)
        return -0.5 * float(f.y @ np.linalg.solve(f.S, f.y) + np.linalg.slogdet(2.0 * math.pi * f.S)[1])


class ReferenceImm:
    """One wheel. mu: (modes,); x, P: the mixture's mean and covariance."""

    def __init__(self, settings: Settings, wheel: int = 0) -> None:
        modes = settings.quarters.shape[1]
        self._transition = settings.transition
        self.modes = [UnscentedMode(settings, wheel, mode) for mode in range(modes)]
        self.mu = np.full(modes, 1.0 / modes)
        self.x, self.P = self._mixture(self.mu)
        self._road: NDArray | None = None

    def step(self, measured: NDArray[np.float64], road: NDArray[np.float64] | None = None) -> None:
        """One sample [a_s, a_us] [m/s^2], (2,); road: each mode's height [m], (modes,), None where it is a state."""
        predicted = self.mu @ self._transition
        weights = self._transition * self.mu[:, None] / predicted
        starts = [self._mixture(weights[:, j]) for j in range(len(self.modes))]
        before = road if self._road is None else self._road
        likelihood = np.empty(len(self.modes))
        for j, (mode, (x, P)) in enumerate(zip(self.modes, starts, strict=True)):
            mode.filter.x, mode.filter.P = x, P
            heights = (None, None) if road is None or before is None else (float(before[j]), float(road[j]))
            likelihood[j] = mode.step(measured, *heights)
        log_mu = np.log(predicted) + likelihood
        self.mu = np.exp(log_mu - log_mu.max())
        self.mu /= self.mu.sum()
        self.x, self.P = self._mixture(self.mu)
        self._road = road

    def _mixture(self, weights: NDArray) -> tuple[NDArray, NDArray]:
        """Mean and covariance of the modes' mixture, the spread of their means included."""
        x = np.asarray(sum(w * m.filter.x for w, m in zip(weights, self.modes, strict=True)))
        P = np.zeros((len(x), len(x)))
        for w, m in zip(weights, self.modes, strict=True):
            off = m.filter.x - x
            P += w * (m.filter.P + np.outer(off, off))
        return x, P
