"""One side of the car: front and rear stiffness, road level and what coherence is left, followed block by block.

State theta of `likelihood`, Gaussian with covariance P. Between blocks it wanders (`WANDER`), and nu comes back to what
the car shows on an open road (`OPEN_ROAD`). A block moves it to the maximum of

    -(theta - theta_0)' P^-1 (theta - theta_0) / 2 + log-likelihood of the block

by Fisher scoring (Green, J. R. Stat. Soc. B 46, 1984): with the expected information, so that what a sequence of blocks
is fitted to stays without bias, as far as theta_0 is near: each block is then a linear step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.axles.block import BINS
from estimators.axles.calibration import Identified
from estimators.axles.evidence import Evidence, evidence
from estimators.axles.likelihood import BAND, BANDS, FRONT, LOSS, REAR, STATES, expect, score_block
from estimators.compiled import compiled
from estimators.vertical_pressure.bank import SENSOR_STD

NOISE = 2.0 * SENSOR_STD**2 / 1000.0  # N [(m/s^2)^2/Hz]: the sensor's density
# Declared. ln k as in `vertical_pressure.posterior`; another surface within a second; 8 mm of a wheelbase in a
# second, since driving and braking slip, and bend the hubs' bushes (tuned: with 0.5 mm a braked car seemed 6 % softer
# in front, with 20 mm nothing is gained); coherence: a factor 1.3 in a second
WANDER = np.array([1e-3, 1e-3, 0.15, 8e-3, *[0.3] * BANDS])  # std after 1 s
LEVEL_STD, SHIFT_STD = 3.0, 0.02  # at the start; m: rolling radius 0.7 % off
OPEN_ROAD, OPEN_STD, BACK = np.log(0.015), 1.5, 0.02  # nu: mean, std, 1/s
LOWEST_LOSS, HIGHEST_LOSS = np.log(5e-4), np.log(0.98)  # of nu
LEAST_G, MOST_G = np.log(1e-9), np.log(1.0)
_STATES, _BINS, _LOSS, _LOW, _HIGH = STATES, BINS, LOSS, LOWEST_LOSS, HIGHEST_LOSS
_LEAST_G, _MOST_G = LEAST_G, MOST_G
_MOST, _ENOUGH = 12, 0.1  # steps; of a standard deviation
_LONGEST = np.array([0.1, 0.1, 1.0, 0.01, *[0.7] * BANDS])  # of one step


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
        if done:
            break
    expect(axles, theta, speed, stretch, shape, bend, H, slope)
    score_block(Y, H, slope, theta, speed, gamma, noise, band, s, K)
    P[:] = np.linalg.inv(inverse + K)


class Side:
    """Front and rear wheel of one side. theta, P: see above."""

    def __init__(self, known: Identified, log_stiffness: NDArray[np.float64], std: float) -> None:
        """log_stiffness: of front and rear [ln N/m], prior, (2,); std: of each."""
        self._known = known
        self.theta = np.concatenate([log_stiffness, [np.log(4e-6), 0.0], np.full(BANDS, OPEN_ROAD)])
        self.P = np.diag(np.array([std, std, LEVEL_STD, SHIFT_STD, *[OPEN_STD] * BANDS]) ** 2)
        self._score, self._J = np.zeros(STATES), np.zeros((STATES, STATES))

    def pass_time(self, seconds: float) -> None:
        """What may have changed meanwhile."""
        keep = np.ones(STATES)
        keep[LOSS:] = np.exp(-BACK * seconds)
        self.theta[LOSS:] = OPEN_ROAD + keep[LOSS:] * (self.theta[LOSS:] - OPEN_ROAD)
        self.P = keep[:, None] * self.P * keep
        self.P[range(STATES), range(STATES)] += WANDER**2 * seconds

    def difference_variance(self) -> float:
        """Of ln k_f - ln k_r."""
        return float(max(self.P[FRONT, FRONT] + self.P[REAR, REAR] - 2.0 * self.P[FRONT, REAR], 0.0))

    def take(self, Y: NDArray[np.complex128], speed: float, stretch: float, gamma: NDArray[np.float64]) -> Evidence:
        """A block Y (BINS, 2) at a speed [m/s]; stretch: `response`; gamma (BINS,): `off_tracking`. What it says by
        itself."""
        known, theta, P = self._known, self.theta.copy(), self.P.copy()
        settle(
            known.axles, self.theta, self.P, Y, speed, stretch, known.shape(speed), known.bend(speed), gamma, NOISE, BAND, _LONGEST,
            self._score, self._J,
        )  # fmt: skip
        return evidence(theta, P, self._score, self._J)

    def reopen(self, states: tuple[int, ...], std: float) -> None:
        """Forget that much of what is known of these states."""
        for state in states:
            self.P[state, state] += std**2
