"""The errors that the thesis adds to the motor angle (4.2.2), in degrees over cells of STEP.

Constants, noise and sine are there from the beginning (its times from 0.2 s on say so), slopes from 5 s on. "Band
limited white noise, noise power P" is a simulation block's: one draw a sample, of variance P / STEP. The sine is
averaged over a cell, as the cells of the signals are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.steering_actuator.residuals import STEP

SLOPE_START = 5.0  # s
SINE_AMPLITUDE, SINE_HZ = 40.0, 20.0  # deg
_KINDS = ("none", "constant", "noise", "sine", "slope")


@dataclass(frozen=True)
class Error:
    """kind: of _KINDS. size: deg, noise power, deg of amplitude or deg/s; start: s, of a constant."""

    kind: str
    size: float = 0.0
    start: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in _KINDS:
            raise ValueError(f"error is {self.kind!r}, valid: {', '.join(_KINDS)}")

    @property
    def name(self) -> str:
        """As in a table."""
        return "no_error" if self.kind == "none" else f"{self.kind}_{self.size:g}"

    def of(self, cells: int, seed: int = 0) -> NDArray[np.float64]:
        """Shape (cells,). seed: of noise."""
        time = STEP * (np.arange(cells) + 0.5)
        if self.kind == "constant":
            return np.where(time > self.start, self.size, 0.0)
        if self.kind == "noise":
            return np.sqrt(self.size / STEP) * np.random.default_rng(seed).standard_normal(cells)
        if self.kind == "sine":
            return self.size * np.sinc(SINE_HZ * STEP) * np.sin(2.0 * np.pi * SINE_HZ * time)
        return self.size * np.maximum(time - SLOPE_START, 0.0) if self.kind == "slope" else np.zeros(cells)


THESIS = (
    Error("none"),
    *(Error("constant", size) for size in (20.0, 30.0, 50.0, 100.0, 500.0, 1000.0, 1500.0)),
    *(Error("noise", power) for power in (50.0, 100.0)),
    Error("sine", SINE_AMPLITUDE),
    *(Error("slope", rate) for rate in (20.0, 50.0, 500.0)),
)
