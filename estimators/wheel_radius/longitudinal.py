"""Front against rear wheel of one side (Persson et al. 2002): slip = mu / k + delta.

State x = (1/k, delta) [-, -], random walk; k: longitudinal stiffness over wheel load. Measurement
    s = (w_driven / c_driven) / (w_free / c_free) - 1,     c: what the curve alone would give (`Motion.roll`)
so a smaller driven wheel gives a positive delta, and traction a positive slip. The paper has the front axle driven:
delta = r_rear / r_front - 1, which is its delta13 = 1 - r1 / r3 to first order. For a driven rear axle the state is
r_front / r_rear - 1; `delta()` turns the sign so that delta13, delta24 always mean rear over front, less one.

Slip and traction are averaged over a second: within it they shake together for reasons other than the slip curve (the
driver's control, pitch), which would count as excitation. At constant torque (1/k, delta) cannot be told apart: mu
enters the information through an anchor (`bounded_filter`), and the covariance stays within the prior. A change of the
road's grip is a jump of 1/k on both sides (`grip`), which then starts anew.

All wheels driven: no wheel rolls freely, and the shares of the axles are not known. Slip of the front less slip of the
rear is again linear in the drive, with a factor between -1/k and 1/k: the same filter with that prior; `compliance()`
means nothing then. Both axles losing alike are not seen; a payload is the business of `payload`; the radius' own
dependence on load ends up in 1/k.
"""

from __future__ import annotations

import numpy as np

from estimators.wheel_radius.bounded_filter import Anchor, BoundedFilter
from estimators.wheel_radius.motion import Motion
from estimators.wheel_radius.noise import NoiseLevel

COMPLIANCE = 0.04  # 1/k: 0.2 % of slip at mu 0.05
COMPLIANCE_STD = 0.015
COMPLIANCE_DRIFT = 5e-4  # [1/sqrt(s)]: road and tyre temperature
SHARED_STD = 0.03  # of the front axle's 1/k less the rear's, each times its unknown share, all wheels driven
DELTA_STD = 5e-3  # equal tyres differ by 0.3-0.6 %
DRIFT = 1e-4  # [1/sqrt(s)]: a step of 0.25 % is followed within a minute
EXCITATION = 0.02  # [-] by which mu must move to tell slip from radius
SPEED_ERROR = 0.1  # [rad/s] of a block's wheel speed before it is measured
CELL = 0.1  # [s]
BLOCK = 10  # cells
MIN_IN_BLOCK = 5


class Longitudinal:
    """One side: 0 left (delta13), 1 right (delta24). driven_axle: front, rear, all. drift: of delta, 0 for a constant
    (learning)."""

    def __init__(self, side: int, driven_axle: str, drift: float = DRIFT) -> None:
        front, rear = side, side + 2
        self._driven, self._free = (rear, front) if driven_axle == "rear" else (front, rear)
        self._sign = -1.0 if driven_axle == "rear" else 1.0
        self._in_curve = 0.5 * self._sign * (1.0 if side == 0 else -1.0)
        mean, std = (0.0, SHARED_STD) if driven_axle == "all" else (COMPLIANCE, COMPLIANCE_STD)
        self._filter = BoundedFilter([mean, 0.0], [std, DELTA_STD], [COMPLIANCE_DRIFT, drift])
        self._anchor = Anchor()
        self._noise: NoiseLevel | None = None
        self._block: list[tuple[float, float]] = []
        self._block_number: int | None = None
        self._finished: int | None = None
        self._speed = 0.0
        self.surprise: tuple[float, float] | None = None
        """Innovation of the block that the last cell completed and the traction in it [-], None if none."""
        self.seconds = 0.0

    def step(self, motion: Motion) -> None:
        """Take one cell."""
        self.surprise = None
        number, place = divmod(motion.index, BLOCK)
        if number != self._block_number:
            self._finish()
            self._block_number = number
        if motion.readable and not np.isnan(motion.traction):
            slip = float(
                motion.omega[self._driven] / motion.roll[self._driven]
                / (motion.omega[self._free] / motion.roll[self._free])
            ) - 1.0  # fmt: skip
            slip -= self._in_curve * float(motion.curve[1] - motion.curve[0])
            if not np.isnan(slip):
                self._block.append((slip, motion.traction))
                self._speed = float(motion.omega[self._free])
        if place == BLOCK - 1:
            self._finish()

    def _finish(self) -> None:
        """Use the finished block, once."""
        block, self._block = self._block, []
        if self._block_number is None or self._block_number == self._finished:
            return
        elapsed = 1 if self._finished is None else self._block_number - self._finished
        self._finished = self._block_number
        self._filter.predict(elapsed * BLOCK * CELL)
        enough = len(block) >= MIN_IN_BLOCK
        if self._noise is not None and (elapsed > 1 or not enough):
            self._noise.interrupt()
        if not enough:
            return
        if self._noise is None:
            self._noise = NoiseLevel(2.0 * (SPEED_ERROR / self._speed) ** 2 / BLOCK)
        slip, traction = np.mean(block, axis=0).tolist()
        row = np.array([traction, 1.0])
        excited = np.array([self._anchor.follow(traction, EXCITATION), 1.0])
        explained = self._filter.spread(excited)
        innovation = self._filter.update(slip, row, self._noise.variance * BLOCK / len(block), excited)
        self._noise.add(innovation, explained)
        self.surprise = innovation, traction
        self.seconds += len(block) * CELL

    def forget_slope(self) -> None:
        """1/k is as little known as at the start: the road's grip has changed."""
        self._filter.forget(0)

    def roughness(self) -> float:
        """Std of a block's slip about the filter's line [-], 0 before there is one."""
        return 0.0 if self._noise is None else self._noise.scatter

    def delta(self) -> tuple[float, float]:
        """(r_rear / r_front - 1, std) of this side [-]."""
        return self._sign * float(self._filter.state[1]), float(self._filter.std[1])

    def compliance(self) -> tuple[float, float]:
        """(1/k, std) [-]."""
        return float(self._filter.state[0]), float(self._filter.std[0])
