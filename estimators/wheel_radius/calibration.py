"""The reference level of each residual: equal tyres differ by 0.3-0.6 % in radius, so only a change means something.

After the start (or a reset, by the driver after inflating) each residual is learnt as a constant: the same filters
without random walk. A residual is calibrated after `LEARNING_TIME` of driving in which it could be read, once its std
is below `ENOUGH`; left/right and diagonal residuals come soon, front/rear ones need changing torque. Until then the
reference is "equal radii", with the spread of real tyres in its std, and no alarm is given. A pressure loss during
learning is learnt.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_radius.residuals import MIXING, NAMES, Residuals

LEARNING_TIME = np.array([120.0, 120.0, 120.0, 60.0, 60.0])  # [s] of usable driving, at least, of the five residuals
ENOUGH = np.array([2e-4, 3e-4, 3e-4, 6e-4, 6e-4])  # std at which learning may stop
TYRE_SPREAD = 3e-3  # std of one tyre's radius against nominal: two differ by 0.3-0.6 %


class Calibration:
    """Reference levels: level (5,) and std (5,), done (5,) bool."""

    def __init__(self) -> None:
        self.level = np.zeros(5)
        self.std = np.full(5, np.nan)
        self.done = np.zeros(5, dtype=bool)

    def learn(self, residuals: Residuals) -> list[str]:
        """Take over what is known well enough; says what was calibrated now."""
        std = np.sqrt(np.diag(residuals.covariance))
        ready = ~self.done & (residuals.seconds >= LEARNING_TIME) & (std <= ENOUGH)
        self.level[ready], self.std[ready] = residuals.value[ready], std[ready]
        self.done |= ready
        return [f"calibrated {NAMES[i]}: {self.level[i]:+.2e} std {self.std[i]:.1e}" for i in np.flatnonzero(ready)]

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
        return {NAMES[i]: {"level": float(self.level[i]), "std": float(self.std[i])} for i in np.flatnonzero(self.done)}

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> Calibration:
        """The inverse of `document`. ValueError names what is wrong."""
        calibration = cls()
        for name, entry in document.items():
            if name not in NAMES:
                raise ValueError(f"calibration has no residual {name!r}, valid: {', '.join(NAMES)}")
            numbers = [entry.get(key) if isinstance(entry, Mapping) else None for key in ("level", "std")]
            level, std = (n if isinstance(n, (int, float)) else math.nan for n in numbers)
            if not (math.isfinite(level) and math.isfinite(std) and std >= 0.0):
                raise ValueError(f"calibration of {name} is {entry!r}, valid: finite 'level' and 'std' of at least 0")
            i = NAMES.index(name)
            calibration.level[i], calibration.std[i], calibration.done[i] = level, std, True
        return calibration
