"""The contract of an estimator: what it declares, what it is fed, what it gives back.

An estimator is built from what the car's maker knows (`Car`) and is then fed the drive in stretches. A stretch holds
the samples that arrived since the last one, in order of arrival; how the drive is cut into stretches must not change
the result, so an estimator works on what the time stamps say and never on the size of a stretch. It sees no `truth/`,
no other estimator's `est/` and no `alarm/`. Whatever a sensor does (NaN, silence, repeated or late stamps) it raises no
exception: it says less, and a flag says why.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.drive_log import Signal


@dataclass(frozen=True, eq=False)
class Estimate:
    """One quantity over time.

    time: [s], shape (n,). value, std: shape (n,), in `unit` (SI, "" for a ratio). std is finite and not negative: where
    a quantity cannot be told from the data it is as wide as what was known before.
    """

    time: NDArray[np.float64]
    value: NDArray[np.float64]
    std: NDArray[np.float64]
    unit: str = ""


@dataclass(frozen=True, order=True)
class Flag:
    """Something about the input or the method that a reader of the estimates must know. time [s]."""

    time: float
    text: str


@dataclass(frozen=True, order=True)
class Alarm:
    """A warning to the driver. time [s]; wheels: the ones meant, of fl fr rl rr, in that order."""

    time: float
    text: str
    wheels: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outputs:
    """What an estimator says after a stretch: estimates by name (`fl/relative_radius_change`), alarms and flags in time
    order.
    """

    estimates: Mapping[str, Estimate] = field(default_factory=dict)
    alarms: tuple[Alarm, ...] = ()
    flags: tuple[Flag, ...] = ()


class Estimator(ABC):
    """A method. One file that defines a subclass adds it to the registry.

    name: as in `est/NAME/...`. reads: signals it may use. requires: those of them without which it can say nothing.
    requires_any: of these at least one, if there are any.
    """

    name: ClassVar[str]
    reads: ClassVar[tuple[str, ...]]
    requires: ClassVar[tuple[str, ...]]
    requires_any: ClassVar[tuple[str, ...]] = ()

    def __init__(self, car: Car) -> None:
        self.car = car

    @abstractmethod
    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """Take the samples that arrived before `until` [s] and were not given before; say what is new.

        samples: signals by name; a declared signal may be absent. Missing, NaN, late and repeated samples are flagged.
        """

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """Start from a calibration learnt on an earlier drive, as `calibration()` gave it. ValueError if it is
        malformed.
        """
        raise ValueError(f"estimator {self.name} learns no calibration, got {sorted(document)}")

    def calibration(self) -> dict[str, Any] | None:
        """What was learnt of this car (JSON values), None if nothing yet."""
        return None
