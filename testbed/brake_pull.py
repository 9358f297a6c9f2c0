"""A brake that pulls on its own: one wheel's brake torque, whatever the driver and the anti-lock control ask for.

Above some 1.8 kN m (tyre at its friction limit, dry) the wheel locks and skids: what its speed sensor then says looks
like a fault of the sensor and is none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined
from estimators.drive_log import WHEELS

STRONGEST = 10e3  # N m
FOREVER = 86400.0  # s, the longest drive


@dataclass(frozen=True)
class BrakePull:
    """torque [N m], from start to end [s]."""

    torque: float
    start: float
    end: float = FOREVER

    def check(self, wheel: str) -> None:
        """ValueError in one line for values out of range."""
        if not (0.0 < self.torque <= STRONGEST and 0.0 <= self.start < self.end <= FOREVER):
            raise ValueError(
                f"brake {wheel}={self.torque:g}@{self.start:g}-{self.end:g} is out of range; valid: above 0 up to "
                f"{STRONGEST:g} N m, from a start of 0 s or later to a later end"
            )


class PullPlan(NamedTuple):
    """Shape (4,) each; torque 0 where nothing pulls."""

    torque: NDArray[np.float64]
    start: NDArray[np.float64]
    end: NDArray[np.float64]


def pull_plan(pulls: Mapping[str, BrakePull]) -> PullPlan:
    """Of a drive, from its pulls by wheel."""
    each = [pulls.get(wheel, BrakePull(0.0, 0.0)) for wheel in WHEELS]
    return PullPlan(*(np.array([getattr(p, name) for p in each]) for name in PullPlan._fields))


@inlined
def pulled(plan, w, time, brake):
    """Torque [N m] of the brake of wheel w at a time [s], where the control gives it `brake`."""
    return max(brake, plan.torque[w]) if plan.start[w] <= time < plan.end[w] else brake
