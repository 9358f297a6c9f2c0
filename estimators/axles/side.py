"""One side of the car: front and rear stiffness, the road's level and slopes, what coherence is left, by blocks.

State theta of `likelihood`, Gaussian with covariance P. Between blocks it wanders (`WANDER`), and nu comes back to what
the car shows on an open road (`OPEN_ROAD`). A block moves it to the maximum of

    -(theta - theta_0)' P^-1 (theta - theta_0) / 2 + log-likelihood of the block

by Fisher scoring (Green, J. R. Stat. Soc. B 46, 1984): with the expected information, so that what a sequence of blocks
is fitted to stays without bias, as far as theta_0 is near: each block is then a linear step.

The mean of both ln k is what H_r / H_f says of it, which rests on the small difference of two nearly equal responses,
and c near 1 makes it loud: right only as far as the tables of `calibration` are, so they know pressure and speed, and
as far as both axles' numbers are, so these are states with a declared spread (`parameters`): told numbers up to 10 %
off and taking them for exact, it was 57 kPa off after 40 s with a standard deviation of 11; with the spread declared
18 with 17. Spread and load were checked on 64 tuning drives of 41 s, classes A to D, 36 to 100 km/h.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.axles.block import BINS
from estimators.axles.calibration import Identified
from estimators.axles.evidence import Evidence, evidence, nothing
from estimators.axles.likelihood import (
    BAND,
    BANDS,
    CHANGING,
    FRONT,
    LEVEL,
    LOAD,
    LOSS,
    REAR,
    SHIFT,
    SLOPES,
    STATES,
    expect,
    score_block,
)
from estimators.axles.parameters import LOAD_STD, NUMBERS
from estimators.compiled import compiled
from estimators.quarter_car.road_shape import class_spectrum
from estimators.quarter_car.roughness import WAVINESS, WAVINESS_STD
from estimators.vertical_pressure.bank import SENSOR_STD
from estimators.vertical_pressure.posterior import LEVEL_DRIFT, SHORT_DRIFT, STIFFNESS_DRIFT

NOISE = 2.0 * SENSOR_STD**2 / 1000.0  # N [(m/s^2)^2/Hz]: the sensor's density
# Declared. ln k, level and slopes as in `vertical_pressure.posterior`; 8 mm of a wheelbase in a
# second, since driving and braking slip, and bend the hubs' bushes (tuned: with 0.5 mm a braked car seemed 6 % softer
# in front, with 20 mm nothing is gained); coherence: a factor 1.3 in a second
WANDER = np.array(  # std after 1 s
    [STIFFNESS_DRIFT, STIFFNESS_DRIFT, LEVEL_DRIFT, 8e-3, SHORT_DRIFT, SHORT_DRIFT, *[0.3] * BANDS, *[0.0] * NUMBERS]
)
FAR = np.array([0.7, 0.05])  # of ln lambda, half a class, and delta [m] in one block
LEAST_TOLD = 1e-4  # of eta's spread: P stays positive definite
LEVEL_STD, SHIFT_STD = 3.0, 0.02  # at the start; m: rolling radius 0.7 % off
OPEN_ROAD, OPEN_STD, BACK = np.log(0.015), 1.5, 0.02  # nu: mean, std, 1/s
LOWEST_LOSS, HIGHEST_LOSS = np.log(5e-4), np.log(0.98)  # of nu
LEAST_G, MOST_G = np.log(1e-9), np.log(1.0)
FLATTEST, STEEPEST = 0.5, 4.5  # of the road's slopes
_STATES, _BINS, _SLOPES, _CHANGING, _LOSS, _LOW, _HIGH = STATES, BINS, SLOPES, CHANGING, LOSS, LOWEST_LOSS, HIGHEST_LOSS
_LEAST_G, _MOST_G, _FLATTEST, _STEEPEST = LEAST_G, MOST_G, FLATTEST, STEEPEST
_MOST, _ENOUGH = 12, 0.1  # steps; of a standard deviation
_LONGEST = np.array([0.1, 0.1, 1.0, 0.01, 0.5, 0.5, *[0.7] * BANDS, *[0.1] * NUMBERS])  # of one step


@compiled
def settle(axles, theta, P, Y, speed, stretch, shape, bend, gamma, noise, band, longest, score, J):
    """Takes a block: theta (STATES,) and P (STATES, STATES) move on; score, J: of the block at theta before it."""
    n = _STATES
    H, slope = np.empty((2, _BINS), np.complex128), np.empty((_SLOPES, 2, _BINS), np.complex128)
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
        for i in range(_LOSS, _CHANGING):
            theta[i] = min(max(theta[i], _LOW), _HIGH)
        theta[2] = min(max(theta[2], _LEAST_G), _MOST_G)
        for i in range(4, 6):
            theta[i] = min(max(theta[i], _FLATTEST), _STEEPEST)
        if done:
            break
    expect(axles, theta, speed, stretch, shape, bend, H, slope)
    score_block(Y, H, slope, theta, speed, gamma, noise, band, s, K)
    P[:] = np.linalg.inv(inverse + K)


class Side:
    """Front and rear wheel of one side. theta (STATES,), P (STATES, STATES): see above."""

    def __init__(
        self, known: Identified, log_stiffness: NDArray[np.float64], std: NDArray[np.float64], stiffer: float = 0.0
    ) -> None:
        """log_stiffness: of front and rear [ln N/m] unloaded, prior, (2,); std: of each, (2,); stiffer: d ln k / dx by
        the tyre's law, x of `parameters`."""
        self._known, self._stiffer, self._heard = known, stiffer, False
        road = [np.log(class_spectrum("B")), 0.0, WAVINESS, WAVINESS]
        self.theta = np.concatenate([log_stiffness, road, np.full(BANDS, OPEN_ROAD), np.zeros(NUMBERS)])
        shift = np.hypot(SHIFT_STD, known.told_std * known.axles.wheelbase)
        numbers = [*[max(known.told_std, LEAST_TOLD)] * (NUMBERS - 1), 0.0]
        spread = [*std, LEVEL_STD, shift, WAVINESS_STD, WAVINESS_STD, *[OPEN_STD] * BANDS, *numbers]
        self.P = np.diag(np.square(spread))
        load = np.zeros(STATES)
        load[LOAD], load[[FRONT, REAR]] = 1.0, stiffer
        self.P += LOAD_STD**2 * np.outer(load, load)
        self._score, self._J = np.zeros(STATES), np.zeros((STATES, STATES))

    def pass_time(self, seconds: float) -> None:
        """What may have changed meanwhile."""
        keep = np.ones(STATES)
        lost = slice(LOSS, CHANGING)
        keep[lost] = np.exp(-BACK * seconds)
        self.theta[lost] = OPEN_ROAD + keep[lost] * (self.theta[lost] - OPEN_ROAD)
        self.P = keep[:, None] * self.P * keep
        self.P[range(STATES), range(STATES)] += WANDER**2 * seconds

    def take(self, Y: NDArray[np.complex128], speed: float, stretch: float, gamma: NDArray[np.float64]) -> Evidence:
        """A block Y (BINS, 2) at a speed [m/s]; stretch: `response`; gamma (BINS,): `off_tracking`. What it says by
        itself of the difference and the mean: nothing if it is the first, or moves road level or wheelbase by `FAR`:
        the slope of a likelihood at a wrong road level tells of a difference of some hundred per cent."""
        theta, P, known = self.theta.copy(), self.P.copy(), self._known
        shift = float(theta[SHIFT])
        settle(
            known.axles, self.theta, self.P, Y, speed, stretch, known.shape(speed, shift), known.bend(speed, shift),
            gamma, NOISE, BAND, _LONGEST, self._score, self._J,
        )  # fmt: skip
        said = evidence(theta, P, self._score, self._J)
        moved = np.abs(self.theta[[LEVEL, SHIFT]] - theta[[LEVEL, SHIFT]])
        near = self._heard and bool((moved < FAR).all())
        self._heard = True
        return said if near else nothing(said)

    def difference(self) -> float:
        """d = ln k_f - ln k_r."""
        return float(self.theta[FRONT] - self.theta[REAR])

    def difference_variance(self) -> float:
        """Of d."""
        P = self.P
        return float(max(P[FRONT, FRONT] + P[REAR, REAR] - 2.0 * P[FRONT, REAR], 0.0))

    def mean(self) -> float:
        """Mean of ln k_f and ln k_r [ln N/m]."""
        return float(0.5 * (self.theta[FRONT] + self.theta[REAR]))

    def log_stiffness(self) -> NDArray[np.float64]:
        """ln k_f and ln k_r [ln N/m], (2,)."""
        return self.theta[[FRONT, REAR]].copy()

    def stiffness_variance(self) -> NDArray[np.float64]:
        """Of each of them, (2,)."""
        return np.diag(self.P)[[FRONT, REAR]].copy()

    def load(self) -> float:
        """x of `parameters`."""
        return float(self.theta[LOAD])

    def unloaded_variance(self) -> NDArray[np.float64]:
        """Of each ln k less what the load makes of it, which is what pressure makes, (2,)."""
        P, e = self.P, self._stiffer
        at = [FRONT, REAR]
        return np.asarray(np.diag(P)[at] - 2.0 * e * P[at, LOAD] + e**2 * P[LOAD, LOAD])

    def coherence(self) -> NDArray[np.float64]:
        """1 - e^nu of each band, (BANDS,)."""
        return np.asarray(1.0 - np.exp(self.theta[LOSS:CHANGING]))

    def coherence_std(self) -> NDArray[np.float64]:
        """Of it, (BANDS,)."""
        return np.asarray(np.exp(self.theta[LOSS:CHANGING]) * np.sqrt(np.diag(self.P)[LOSS:CHANGING]))

    def forget(self, std: float) -> None:
        """Both ln k have changed by that much, or not."""
        for state in (FRONT, REAR):
            self.P[state, state] += std**2
