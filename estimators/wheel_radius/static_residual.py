"""Static residual of four wheel speeds (Persson et al. 2002): r = w1/w2 - w3/w4, wheels fl fr rl rr.

Published form, and the form used here, which divides each axle's ratio by what the curve alone would give. To first
order in relative radius changes e_i both are r = e_2 - e_1 - e_4 + e_3 = delta34 - delta12: zero when both wheels of an
axle, or of a side, or all four lose alike. Averages of half a second feed a random walk.

A tyre that has lost pressure also slips less (its patch is longer), and the slip of the two wheels of an axle differs
by pull times the difference of their 1/k (left less right). State x = (r, difference in front, at the rear):
    w1/w2 - w3/w4 = r + pull_front x_2 - pull_rear x_3
the pull entering the information through an anchor, so that without changes of the pull std says that it is unknown.

Error propagation: var r = (w1/w2)^2 (s^2/w1^2 + s^2/w2^2) + (w3/w4)^2 (s^2/w3^2 + s^2/w4^2) for a wheel-speed error s;
it starts the noise level, which is then measured (road, sensors, their memory).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_radius.bounded_filter import Anchor, BoundedFilter
from estimators.wheel_radius.motion import Motion
from estimators.wheel_radius.noise import NoiseLevel

CELL = 0.1  # [s]
BLOCK = 5  # cells
MIN_IN_BLOCK = 3
PRIOR_STD = 6e-3  # equal tyres differ by 0.3-0.6 % in radius; two such differences
DRIFT = 1.4e-4  # [1/sqrt(s)], as two radius ratios of 1e-4 each
UNLIKE_STD = 2.5e-3  # of the 1/k of an axle's wheels against each other: a low tyre's is a tenth smaller
UNLIKE_DRIFT = 2e-4  # [1/sqrt(s)]: as that comes within minutes
PULL_EXCITATION = 0.02  # [-] by which the pull must move to tell slip from radius
SPEED_ERROR = 0.1  # [rad/s] of a cell's wheel speed before it is measured


def published_residual(omega: NDArray[np.float64]) -> float:
    """w1/w2 - w3/w4 [-]; omega: fl fr rl rr [rad/s], shape (4,)."""
    return float(omega[0] / omega[1] - omega[2] / omega[3])


def corrected_residual(omega: NDArray[np.float64], roll: NDArray[np.float64]) -> float:
    """The same without the curve's share; roll: rolling speeds that the path gives the wheels, shape (4,)."""
    return published_residual(omega / roll)


def propagated_variance(omega: NDArray[np.float64], error: float) -> float:
    """Variance of the residual for independent wheel-speed errors of std `error` [rad/s]."""
    front, rear = omega[0] / omega[1], omega[2] / omega[3]
    relative = (error / omega) ** 2
    return float(front**2 * (relative[0] + relative[1]) + rear**2 * (relative[2] + relative[3]))


class StaticResidual:
    """Running estimate of one residual. curve_corrected: which form. drift: 0 for a constant (learning)."""

    def __init__(self, curve_corrected: bool = True, drift: float = DRIFT) -> None:
        self._corrected, self._drift = curve_corrected, drift
        unlike = 0.0 if drift == 0.0 else UNLIKE_DRIFT
        self._filter = BoundedFilter([0.0] * 3, [PRIOR_STD, UNLIKE_STD, UNLIKE_STD], [drift, unlike, unlike])
        self._anchors = Anchor(), Anchor()
        self._noise: NoiseLevel | None = None
        self._block: list[tuple[float, float, float]] = []
        self._block_number: int | None = None
        self._finished: int | None = None
        self.seconds = 0.0

    def step(self, motion: Motion) -> None:
        """Take one cell."""
        number, place = divmod(motion.index, BLOCK)
        if number != self._block_number:
            self._finish()
            self._block_number = number
        if motion.readable and np.isfinite(motion.omega).all():
            if self._noise is None:
                self._noise = NoiseLevel(propagated_variance(motion.omega, SPEED_ERROR) / BLOCK)
            form = (
                corrected_residual(motion.omega, motion.roll) if self._corrected else published_residual(motion.omega)
            )
            form -= float(motion.curve[1] - motion.curve[0]) if self._corrected else 0.0
            self._block.append((form, float(motion.pull[0]), float(motion.pull[1])))
        if place == BLOCK - 1:
            self._finish()

    def _finish(self) -> None:
        """Use the finished block, once."""
        values, self._block = self._block, []
        if self._block_number is None or self._noise is None or self._block_number == self._finished:
            return
        elapsed = 1 if self._finished is None else self._block_number - self._finished
        self._finished = self._block_number
        self._filter.predict(elapsed * BLOCK * CELL)
        enough = len(values) >= MIN_IN_BLOCK
        if elapsed > 1 or not enough:
            self._noise.interrupt()
        if enough:
            mean, front, rear = np.mean(values, axis=0).tolist()
            anchored = [
                anchor.follow(pull, PULL_EXCITATION) for anchor, pull in zip(self._anchors, (front, rear), strict=True)
            ]
            excited = np.array([1.0, anchored[0], -anchored[1]])
            explained = self._filter.spread(excited)
            variance = self._noise.variance * BLOCK / len(values)
            innovation = self._filter.update(mean, np.array([1.0, front, -rear]), variance, excited)
            self._noise.add(innovation, explained)
            self.seconds += len(values) * CELL

    def value(self) -> float:
        """Estimate [-]."""
        return float(self._filter.state[0])

    def std(self) -> float:
        """Of the estimate [-], with what the walk adds since the middle of the last block."""
        return float(np.hypot(self._filter.std[0], self._drift * (0.5 * BLOCK * CELL) ** 0.5))
