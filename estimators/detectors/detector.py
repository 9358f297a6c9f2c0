"""What every kind of detector is: frozen parameters, a recursion, and the run lengths that they give.

A detector looks at residuals in units of their own standard deviation before the change, forms a statistic >= 0 and
alarms when that exceeds its level: alarm if g > h. `Monitor` runs one. The average run length is the mean number of
samples from a reset to the alarm: ARL0 without a change (the mean time between false alarms if the detector restarts),
the delay with one that is there from the reset on.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

SIDES = {"upper": (1.0, 0.0), "lower": (0.0, 1.0), "both": (1.0, 1.0)}
"""Which changes are looked for, as (upward, downward)."""


@dataclass(frozen=True)
class RunLength:
    """An average run length in samples. low, high: its 95 % interval, both equal to `mean` where it is exact.

    method: "integral equation", "closed form", "simulation", "importance sampling" or "simulation, extrapolated".
    """

    mean: float
    low: float
    high: float
    method: str

    @classmethod
    def exact(cls, mean: float, method: str = "integral equation") -> RunLength:
        """One without a statistical error."""
        return cls(mean, mean, mean, method)


class Detector(ABC):
    """A kind of detector with its parameters; subclasses are frozen dataclasses. ValueError if they make no sense.

    Every kind has a threshold h >= 0 and `sides`, a key of `SIDES`.
    """

    kind: ClassVar[int]
    threshold: float
    sides: str

    def __post_init__(self) -> None:
        self._check()
        check_number("threshold", self.threshold, 0.0)
        if self.sides not in SIDES:
            raise ValueError(f"sides is {self.sides!r}, valid: {', '.join(SIDES)}")

    @abstractmethod
    def _check(self) -> None:
        """ValueError unless the kind's own parameters make sense."""

    @property
    def level(self) -> float:
        """The statistic above which it alarms."""
        return self.threshold

    @property
    def state_size(self) -> int:
        """Numbers that its recursion remembers."""
        return 2

    @abstractmethod
    def numbers(self) -> NDArray[np.float64]:
        """Its parameters as `recursions.advance` takes them."""

    @abstractmethod
    def average_run_length(self, mean: float = 0.0, std: float = 1.0) -> RunLength:
        """Samples to the alarm when the residuals are independent and Gaussian with this mean and std."""


def check_number(name: str, value: float, low: float, high: float = np.inf, above: bool = False) -> None:
    """ValueError unless value is a finite number in [low, high], or in (low, high] if `above`."""
    inside = np.isfinite(value) and low <= value <= high and not (above and value == low)
    if not inside:
        bound = f"{'above' if above else 'at least'} {low:g}" + (f" and at most {high:g}" if np.isfinite(high) else "")
        raise ValueError(f"{name} is {value:g}, valid: a number {bound}")


def check_count(name: str, value: int, low: int, high: int) -> None:
    """ValueError unless value is a whole number in [low, high]."""
    if int(value) != value or not low <= value <= high:
        raise ValueError(f"{name} is {value:g}, valid: a whole number from {low} to {high}")


def numbers_of(sides: str, *rest: float | Sequence[float]) -> NDArray[np.float64]:
    """The sides and further parameters in one array."""
    return np.concatenate([np.array(SIDES[sides]), *(np.atleast_1d(np.asarray(r, dtype=np.float64)) for r in rest)])


def both_sides(upper: float, lower: float) -> float:
    """Run length of two one-sided CUSUMs side by side: 1/L = 1/L+ + 1/L-, exact for equal drifts >= 0 and thresholds.

    Exact because the side that does not alarm is then at 0 (van Dobben de Bruyn 1968).
    """
    return 1.0 / (1.0 / upper + 1.0 / lower)
