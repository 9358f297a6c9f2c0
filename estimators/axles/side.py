"""One side of the car: front and rear stiffness, road level and slope, and what coherence is left, block by block.

State theta of `likelihood`, Gaussian with covariance P. Between blocks it wanders (`WANDER`), and nu comes back to what
the car shows on an open road (`OPEN_ROAD`). A block moves it to the maximum of

    -(theta - theta_0)' P^-1 (theta - theta_0) / 2 + log-likelihood of the block

by Fisher scoring (Green, J. R. Stat. Soc. B 46, 1984): with the expected information, so that what a sequence of blocks
is fitted to stays without bias, as far as theta_0 is near: each block is then a linear step.

Two such states run side by side. The joint one, with the coherency, tells the difference d = ln k_f - ln k_r. The
other, for which gamma = 0, hears front and rear as two single wheels and tells their mean m:

    ln k_f = m + d / 2        ln k_r = m - d / 2        var = var(m) (1 + c^2) + var(d) / 4

since over one road both single wheels err alike. The joint state's own mean is not used: what H_r / H_f says of it
rests on the small difference of two nearly equal responses, which no model of a car has to a per cent, and c near 1
makes it loud: it was 8 % off at half the pressure, where m is right to 0.5 %. That costs a third of the accuracy that
the bound promises for m.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.axles.block import BINS
from estimators.axles.calibration import Identified
from estimators.axles.evidence import Evidence, evidence
from estimators.axles.likelihood import BAND, BANDS, FRONT, LOSS, REAR, STATES, expect, score_block
from estimators.compiled import compiled
from estimators.quarter_car.roughness import WAVINESS, WAVINESS_STD
from estimators.vertical_pressure.bank import SENSOR_STD
from estimators.vertical_pressure.posterior import LEVEL_DRIFT, SHORT_DRIFT, STIFFNESS_DRIFT

NOISE = 2.0 * SENSOR_STD**2 / 1000.0  # N [(m/s^2)^2/Hz]: the sensor's density
# Declared. ln k as in `vertical_pressure.posterior`, level and slope too; 8 mm of a wheelbase in a
# second, since driving and braking slip, and bend the hubs' bushes (tuned: with 0.5 mm a braked car seemed 6 % softer
# in front, with 20 mm nothing is gained); coherence: a factor 1.3 in a second
WANDER = np.array([STIFFNESS_DRIFT, STIFFNESS_DRIFT, LEVEL_DRIFT, 8e-3, SHORT_DRIFT, *[0.3] * BANDS])  # std after 1 s
LEVEL_STD, SHIFT_STD = 3.0, 0.02  # at the start; m: rolling radius 0.7 % off
OPEN_ROAD, OPEN_STD, BACK = np.log(0.015), 1.5, 0.02  # nu: mean, std, 1/s
LOWEST_LOSS, HIGHEST_LOSS = np.log(5e-4), np.log(0.98)  # of nu
LEAST_G, MOST_G = np.log(1e-9), np.log(1.0)
FLATTEST, STEEPEST = 0.5, 4.5  # of w
_STATES, _BINS, _LOSS, _LOW, _HIGH = STATES, BINS, LOSS, LOWEST_LOSS, HIGHEST_LOSS
_LEAST_G, _MOST_G, _FLATTEST, _STEEPEST = LEAST_G, MOST_G, FLATTEST, STEEPEST
_MOST, _ENOUGH = 12, 0.1  # steps; of a standard deviation
_LONGEST = np.array([0.1, 0.1, 1.0, 0.01, 0.2, *[0.7] * BANDS])  # of one step


@compiled
def settle(axles, theta, P, Y, speed, stretch, shape, bend, gamma, noise, band, longest, score, J):
    """Takes a block: theta (STATES,) and P (STATES, STATES) move on; score, J: of the block at theta before it."""
    n = _STATES
    H, slope = np.empty((2, _BINS), np.complex128), np.empty((2, 2, _BINS), np.complex128)
    before, inverse = theta.copy(), np.linalg.inv(P)
    s, K = np.empty(n), np.empty((n, n))
    for k in range(_MOST):
        expect(axles, theta, speed, stretch, shape, bend, H, slope)
        score_block(Y, H, slope, theta, speed, gamma, noise, band, s, K)
        if k == 0:
            score[:] = s
            J[:] = K
        whole = inverse + K
        step = np.linalg.solve(whole, s - inverse @ (theta - before))
        far = 0.0
        for i in range(n):
            far = max(far, abs(step[i]) / longest[i])
        if far > 1.0:
            step /= far
        done = True
        for i in range(n):
            theta[i] += step[i]
            if abs(step[i]) > _ENOUGH / np.sqrt(whole[i, i]):
                done = False
        for i in range(_LOSS, n):
            theta[i] = min(max(theta[i], _LOW), _HIGH)
        theta[2] = min(max(theta[2], _LEAST_G), _MOST_G)
        theta[4] = min(max(theta[4], _FLATTEST), _STEEPEST)
        if done:
            break
    expect(axles, theta, speed, stretch, shape, bend, H, slope)
    score_block(Y, H, slope, theta, speed, gamma, noise, band, s, K)
    P[:] = np.linalg.inv(inverse + K)


class _State:
    """theta, P: see above; shared: 1 with the coherency, 0 without."""

    def __init__(self, log_stiffness: NDArray[np.float64], std: float, shared: float) -> None:
        self.theta = np.concatenate([log_stiffness, [np.log(4e-6), 0.0, WAVINESS], np.full(BANDS, OPEN_ROAD)])
        self.P = np.diag(np.array([std, std, LEVEL_STD, SHIFT_STD, WAVINESS_STD, *[OPEN_STD] * BANDS]) ** 2)
        self._shared = shared
        self._score, self._J = np.zeros(STATES), np.zeros((STATES, STATES))

    def pass_time(self, seconds: float) -> None:
        keep = np.ones(STATES)
        keep[LOSS:] = np.exp(-BACK * seconds)
        self.theta[LOSS:] = OPEN_ROAD + keep[LOSS:] * (self.theta[LOSS:] - OPEN_ROAD)
        self.P = keep[:, None] * self.P * keep
        self.P[range(STATES), range(STATES)] += WANDER**2 * seconds

    def take(
        self, known: Identified, Y: NDArray[np.complex128], speed: float, ratio: float, gamma: NDArray
    ) -> Evidence:
        theta, P = self.theta.copy(), self.P.copy()
        settle(
            known.axles, self.theta, self.P, Y, speed, ratio, known.shape(speed), known.bend(speed),
            self._shared * gamma, NOISE, BAND, _LONGEST, self._score, self._J,
        )  # fmt: skip
        return evidence(theta, P, self._score, self._J)

    def forget(self, std: float) -> None:
        for state in (FRONT, REAR):
            self.P[state, state] += std**2


class Side:
    """Front and rear wheel of one side."""

    def __init__(self, known: Identified, log_stiffness: NDArray[np.float64], std: float) -> None:
        """log_stiffness: of front and rear [ln N/m], prior, (2,); std: of each."""
        self._known = known
        self._joint, self._alone = _State(log_stiffness, std, 1.0), _State(log_stiffness, std, 0.0)

    def pass_time(self, seconds: float) -> None:
        """What may have changed meanwhile."""
        self._joint.pass_time(seconds)
        self._alone.pass_time(seconds)

    def take(self, Y: NDArray[np.complex128], speed: float, stretch: float, gamma: NDArray[np.float64]) -> Evidence:
        """A block Y (BINS, 2) at a speed [m/s]; stretch: `response`; gamma (BINS,): `off_tracking`. What it says by
        itself of d, from the joint state, and of m, from the other."""
        joint = self._joint.take(self._known, Y, speed, stretch, gamma)
        alone = self._alone.take(self._known, Y, speed, stretch, gamma)
        return Evidence(joint.difference, alone.mean)

    def difference(self) -> float:
        """d = ln k_f - ln k_r."""
        return float(self._joint.theta[FRONT] - self._joint.theta[REAR])

    def difference_variance(self) -> float:
        """Of d."""
        P = self._joint.P
        return float(max(P[FRONT, FRONT] + P[REAR, REAR] - 2.0 * P[FRONT, REAR], 0.0))

    def mean(self) -> float:
        """m: mean of ln k_f and ln k_r [ln N/m]."""
        return float(0.5 * (self._alone.theta[FRONT] + self._alone.theta[REAR]))

    def log_stiffness(self) -> NDArray[np.float64]:
        """ln k_f and ln k_r [ln N/m], (2,)."""
        return self.mean() + 0.5 * self.difference() * np.array([1.0, -1.0])

    def stiffness_variance(self) -> float:
        """Of each of them."""
        P = self._alone.P
        mean = 0.25 * (P[FRONT, FRONT] + P[REAR, REAR] + 2.0 * P[FRONT, REAR])
        return float(mean * (1.0 + self.coherence().mean() ** 2) + 0.25 * self.difference_variance())

    def coherence(self) -> NDArray[np.float64]:
        """1 - e^nu of each band, (BANDS,)."""
        return np.asarray(1.0 - np.exp(self._joint.theta[LOSS:]))

    def coherence_std(self) -> NDArray[np.float64]:
        """Of it, (BANDS,)."""
        return np.asarray(np.exp(self._joint.theta[LOSS:]) * np.sqrt(np.diag(self._joint.P)[LOSS:]))

    def forget(self, std: float) -> None:
        """Both ln k have changed by that much, or not."""
        self._joint.forget(std)
        self._alone.forget(std)
