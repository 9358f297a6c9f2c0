"""The reference level of each residual: equal tyres differ by 0.3-0.6 % in radius, so only a change means something.

After the start (or a reset, by the driver after inflating) each residual is learnt as a constant: the same filters
without random walk. A residual is calibrated after `LEARNING_TIME` of driving in which it could be read, once its std
is below `ENOUGH`; left/right and diagonal residuals come soon, front/rear ones need changing torque. Until then the
reference is "equal radii", with the spread of real tyres in its std, and no alarm is given. A pressure loss during
learning is learnt. The mass of the car is learnt beside them: a change of the load since is `payload`'s business.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_radius.payload import SPREAD, radius_shift, side_shift
from estimators.wheel_radius.residuals import MIXING, NAMES, Residuals

LEARNING_TIME = np.array([120.0, 120.0, 120.0, 60.0, 60.0])  # [s] of usable driving, at least, of the five residuals
ENOUGH = np.array([2e-4, 3e-4, 3e-4, 6e-4, 6e-4])  # std at which learning may stop
ACROSS = slice(1, 3)  # delta12 and delta34
FRONT_REAR = slice(3, 5)  # delta13 and delta24, which a load moves
MASS = "mass"  # of the loaded car [kg], beside the residuals in a document
TYRE_SPREAD = 3e-3  # std of one tyre's radius against nominal: two differ by 0.3-0.6 %


class Calibration:
    """Reference levels: level (5,) and std (5,), done (5,) bool."""

    def __init__(self) -> None:
        self.level = np.zeros(5)
        self.std = np.full(5, np.nan)
        self.done = np.zeros(5, dtype=bool)
        self._mass: tuple[float, float] | None = None
        self._stops: int | None = None  # of the drive in which it was learnt

    def learn(self, residuals: Residuals) -> list[str]:
        """Take over what is known well enough; says what was calibrated now."""
        std = np.sqrt(np.diag(residuals.covariance))
        ready = ~self.done & (residuals.seconds >= LEARNING_TIME) & (std <= ENOUGH)
        self.level[ready], self.std[ready] = residuals.value[ready], std[ready]
        self.done |= ready
        if ready[FRONT_REAR].any():
            self._mass, self._stops = residuals.mass, residuals.stops
        return [f"calibrated {NAMES[i]}: {self.level[i]:+.2e} std {self.std[i]:.1e}" for i in np.flatnonzero(ready)]

    def change(self, residuals: Residuals) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Residuals less their reference (5,), and its covariance (5, 5): of the residuals, of the reference, and of a
        change of the load since, of which the likeliest effect is taken off, and of load and wind from the side."""
        change, covariance = residuals.value - self.level, residuals.covariance + self.covariance()
        shift, std = self._load(residuals)
        change[FRONT_REAR] -= shift
        covariance[FRONT_REAR, FRONT_REAR] += std**2
        covariance[ACROSS, ACROSS] += side_shift(self._stops != residuals.stops) ** 2
        return change, covariance

    def _load(self, residuals: Residuals) -> tuple[float, float]:
        """Mean and std of what the load did to delta13 and delta24 since they were learnt [-]."""
        if self._stops == residuals.stops or not self.done[FRONT_REAR].any():
            return 0.0, 0.0
        mass, std = residuals.mass
        before, before_std = self._mass or (mass, SPREAD)
        return radius_shift(mass - before, math.hypot(std, before_std))

    def covariance(self) -> NDArray[np.float64]:
        """Of the reference levels, shape (5, 5); the spread of real tyres while nothing is calibrated."""
        if not self.done.any():
            return TYRE_SPREAD**2 * MIXING @ MIXING.T
        return np.diag(np.where(self.done, self.std, 0.0) ** 2)

    def used(self) -> NDArray[np.bool_]:
        """Which residuals count: the calibrated ones, all while there is none. Shape (5,)."""
        return self.done if self.done.any() else np.ones(5, dtype=bool)

    def document(self) -> dict[str, Any] | None:
        """Calibrated levels by residual name, None if there is none."""
        if not self.done.any():
            return None
        learnt = {
            NAMES[i]: {"level": float(self.level[i]), "std": float(self.std[i])} for i in np.flatnonzero(self.done)
        }
        return learnt | ({} if self._mass is None else {MASS: {"level": self._mass[0], "std": self._mass[1]}})

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> Calibration:
        """The inverse of `document`. ValueError names what is wrong."""
        calibration = cls()
        for name, entry in document.items():
            if name not in (*NAMES, MASS):
                raise ValueError(f"calibration has no residual {name!r}, valid: {', '.join((*NAMES, MASS))}")
            numbers = [entry.get(key) if isinstance(entry, Mapping) else None for key in ("level", "std")]
            level, std = (n if isinstance(n, (int, float)) else math.nan for n in numbers)
            if not (math.isfinite(level) and math.isfinite(std) and std >= 0.0):
                raise ValueError(f"calibration of {name} is {entry!r}, valid: finite 'level' and 'std' of at least 0")
            if name == MASS:
                calibration._mass = level, std
                continue
            i = NAMES.index(name)
            calibration.level[i], calibration.std[i], calibration.done[i] = level, std, True
        return calibration
