"""Front against rear wheel of one side (Persson et al. 2002): slip = mu / k + delta.

State x = (1/k, delta) [-, -], random walk; k: longitudinal stiffness over wheel load. Measurement
    s = (w_driven / c_driven) / (w_free / c_free) - 1,     c: what the curve alone would give (`Motion.roll`)
so a smaller driven wheel gives a positive delta, and traction a positive slip. The paper has the front axle driven:
delta = r_rear / r_front - 1, which is its delta13 = 1 - r1 / r3 to first order. For a driven rear axle the state is
r_front / r_rear - 1; `delta()` turns the sign so that delta13, delta24 always mean rear over front, less one.

At constant torque (1/k, delta) cannot be told apart: mu enters the information through an anchor (`bounded_filter`),
and the covariance stays within the prior. Both axles losing alike, or a payload that presses the rear radius, are not
seen or not told from a loss; nor is the radius' own dependence on load, most of which ends up in 1/k.
"""

from __future__ import annotations

import numpy as np

from estimators.wheel_radius.bounded_filter import Anchor, BoundedFilter
from estimators.wheel_radius.motion import Motion
from estimators.wheel_radius.noise import NoiseLevel

COMPLIANCE = 0.034  # 1/k: 0.17 % of slip at mu 0.05
COMPLIANCE_STD = 0.015
COMPLIANCE_DRIFT = 5e-4  # [1/sqrt(s)]: road and tyre temperature
DELTA_STD = 5e-3  # equal tyres differ by 0.3-0.6 %
DRIFT = 1e-4  # [1/sqrt(s)]: a step of 0.25 % is followed within a minute
EXCITATION = 0.02  # [-] by which mu must move to tell slip from radius
SPEED_ERROR = 0.1  # [rad/s] of a cell's wheel speed before it is measured


class Longitudinal:
    """One side: 0 left (delta13), 1 right (delta24). drift: of delta, 0 for a constant (learning)."""

    def __init__(self, side: int, driven_axle: str, drift: float = DRIFT) -> None:
        front, rear = side, side + 2
        self._driven, self._free = (front, rear) if driven_axle == "front" else (rear, front)
        self._sign = 1.0 if driven_axle == "front" else -1.0
        self._filter = BoundedFilter([COMPLIANCE, 0.0], [COMPLIANCE_STD, DELTA_STD], [COMPLIANCE_DRIFT, drift])
        self._anchor = Anchor()
        self._noise: NoiseLevel | None = None
        self._stepped: float | None = None
        self.seconds = 0.0

    def step(self, motion: Motion) -> None:
        """Take one cell."""
        elapsed = 0.1 if self._stepped is None else motion.time - self._stepped
        self._stepped = motion.time
        self._filter.predict(elapsed)
        if not motion.readable or np.isnan(motion.traction):
            if self._noise is not None:
                self._noise.interrupt()
            return
        rolled = motion.omega / motion.roll
        slip = float(rolled[self._driven] / rolled[self._free]) - 1.0
        if self._noise is None:
            self._noise = NoiseLevel(2.0 * (SPEED_ERROR / float(motion.omega[self._free])) ** 2)
        row = np.array([motion.traction, 1.0])
        excited = np.array([self._anchor.follow(motion.traction, EXCITATION), 1.0])
        explained = self._filter.spread(excited)
        self._noise.add(self._filter.update(slip, row, self._noise.variance, excited), explained)
        self.seconds += 0.1

    def delta(self) -> tuple[float, float]:
        """(r_rear / r_front - 1, std) of this side [-]."""
        return self._sign * float(self._filter.state[1]), float(self._filter.std[1])

    def compliance(self) -> tuple[float, float]:
        """(1/k, std) [-]."""
        return float(self._filter.state[0]), float(self._filter.std[0])
