"""The contract of a fault's kind. One file in `estimators/faults/kinds` adds one kind; it is found by itself.

    ValueFault   the sensor says another number: `faulty(time, value)`
    LossFault    samples do not arrive: `lost(time)`
    DelayFault   samples arrive later: `seconds`
    SwapFault    two sensors are exchanged

A kind sees only samples inside its fault's time, from <= stamp < to, and (`observe`) the last ones before. What it does
may depend on stamps and on the samples' order and on nothing else. A fault sits behind the sensor's own limits and
quantisation.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.faults.chance import Chance

SIGNAL = "signal"  # a number in the unit of the signal
SIGNAL_RATE = "signal/s"
LARGEST = 1e9  # of a number as typed


@dataclass(frozen=True)
class Number:
    """One number of a kind. unit: a fixed one, SIGNAL or SIGNAL_RATE. default None: it must be given."""

    name: str
    unit: str
    low: float = -LARGEST
    high: float = LARGEST
    default: float | None = None


class Kind(ABC):
    """name: as typed; about: one line; numbers: that follow the name; whole: it acts on whole messages only, not on one
    axis of a vector; wheels_only: only on a wheel's speed sensor."""

    name: ClassVar[str]
    about: ClassVar[str]
    numbers: ClassVar[tuple[Number, ...]] = ()
    whole: ClassVar[bool] = False
    wheels_only: ClassVar[bool] = False

    def __init__(self, numbers: Sequence[float], start: float, chance: Chance, teeth: float) -> None:
        """numbers: SI. start: of the fault [s]. chance: its randomness. teeth: that the car's wheel rings have."""
        self.given, self.start, self.chance, self.teeth = tuple(numbers), start, chance, teeth


class ValueFault(Kind):
    """Changes what is said."""

    @abstractmethod
    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        """time: [s], shape (n,); value: SI, shape (n, k), not to be written -> what is said instead, shape (n, k)."""

    def observe(self, value: NDArray[np.float64]) -> None:
        """Sound samples before the fault, shape (n, k), n at least 1."""
        return


class LossFault(Kind):
    """Loses samples."""

    whole = True

    @abstractmethod
    def lost(self, time: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which samples never arrive, by their stamps [s], shape (n,)."""


class DelayFault(Kind):
    """Holds samples up."""

    whole = True

    @property
    @abstractmethod
    def seconds(self) -> float:
        """[s] by which stamps move back."""


class SwapFault(Kind):
    """Exchanges a sensor with that of the other side."""

    whole = True


@cache
def fault_kinds() -> dict[str, type[Kind]]:
    """Every kind found, by name."""
    package = importlib.import_module("estimators.faults.kinds")
    found: dict[str, type[Kind]] = {}
    for module in pkgutil.iter_modules(package.__path__):
        members = inspect.getmembers(importlib.import_module(f"{package.__name__}.{module.name}"), inspect.isclass)
        for _, kind in members:
            if issubclass(kind, Kind) and not inspect.isabstract(kind) and hasattr(kind, "name"):
                found[kind.name] = kind
    return dict(sorted(found.items()))


def find_kind(name: str) -> type[Kind]:
    """The kind of that name. ValueError lists the valid ones."""
    if name not in fault_kinds():
        raise ValueError(f"no fault is named {name!r}; valid: {', '.join(fault_kinds())}")
    return fault_kinds()[name]
