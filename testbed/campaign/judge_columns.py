"""Rows of a campaign's table as arrays on one time axis, and what its quantities are called and measured in."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS
from testbed.course import PAIRS, low_wheels

VALUE = "/value"


@dataclass(frozen=True)
class Quantity:
    """label; unit that is shown, scale from SI to it; settled: an estimate is settled while its error stays below this,
    in the unit shown; loss: whether a smaller value of a wheel means a lower pressure."""

    label: str
    unit: str
    scale: float
    settled: float
    loss: bool = True


# the last part of a name, as of `testbed.course`; the first that a method gives is the one that tells low tyres
QUANTITIES = {
    "pressure": Quantity("pressure", "kPa", 1e-3, 15.0),
    "relative_pressure_change": Quantity("relative pressure change", "kPa", 1e-3, 15.0),
    "stiffness": Quantity("stiffness", "kN/m", 1e-3, 10.0),
    "relative_radius_change": Quantity("relative radius change", "%", 100.0, 0.05),
    **{name: Quantity(f"ratio {name}", "%", 100.0, 0.05, loss=False) for name in PAIRS},
}


class Name(NamedTuple):
    """Of an estimate; wheel None where it is of the whole car."""

    method: str
    wheel: str | None
    quantity: str


def parsed(name: str) -> Name:
    """Of METHOD/WHEEL/QUANTITY or METHOD/QUANTITY."""
    method, *wheel, quantity = name.split("/")
    return Name(method, wheel[0] if wheel else None, quantity)


class Drives:
    """The drives that were driven to their end. time: [s], shape (n,), of the longest of them; rows as they came."""

    def __init__(self, rows: Sequence[Mapping[str, Any]]) -> None:
        self.rows = [row for row in rows if row["error"] is None]
        self.time = np.array(max((row["time_s"] for row in self.rows), key=lambda t: t[-1], default=[]))
        self.ends = np.array([row["time_s"][-1] for row in self.rows])

    def __len__(self) -> int:
        return len(self.rows)

    def names(self) -> list[Name]:
        """Every estimate that has a truth, in order of method, quantity and wheel. ValueError for a quantity that
        `testbed.course` knows and QUANTITIES does not."""
        columns = {key for row in self.rows for key, values in row.items() if key.endswith(VALUE) and values}
        found = [parsed(key.removesuffix(VALUE)) for key in columns]
        kinds, wheels = list(QUANTITIES), [None, *WHEELS]
        for name in found:
            if name.quantity not in kinds:
                raise ValueError(f"no unit to judge {name.quantity!r} in; known: {', '.join(kinds)}")
        return sorted(found, key=lambda n: (n.method, kinds.index(n.quantity), wheels.index(n.wheel)))

    def column(self, name: str) -> NDArray[np.float64]:
        """A column over time, shape (drives, n): the last sample at or before each time, NaN where there is none."""
        table = np.full((len(self.rows), len(self.time)), np.nan)
        for drive, row in enumerate(self.rows):
            if row.get(name):
                last = np.searchsorted(row["time_s"], self.time + 1e-6, side="right") - 1
                known = (last >= 0) & (self.time <= self.ends[drive] + 1e-6)
                table[drive, known] = np.array(row[name], dtype=np.float64)[last[known]]
        return table

    def estimate(self, name: Name) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Value, std and truth in the unit shown, shape (drives, n); NaN where a std is none."""
        path = "/".join(filter(None, name))
        scale = QUANTITIES[name.quantity].scale
        value, std, truth = (scale * self.column(f"{path}/{what}") for what in ("value", "std", "truth"))
        return value, np.where(std > 0.0, std, np.nan), truth

    def alarms(self, method: str) -> list[list[tuple[float, tuple[str, ...]]]]:
        """Of each drive: time [s] and wheels of a method's alarms."""
        every = (json.loads(row["alarms"]) for row in self.rows)
        return [[(time, tuple(wheels)) for time, name, wheels in given if name == method] for given in every]

    def low(self, share: float) -> list[list[tuple[float, tuple[str, ...]]]]:
        """Of each drive: times [s] with the wheels that have lost that share of nominal pressure by then. A drive that
        begins so has it from 0 s on."""
        found = []
        for row in self.rows:
            pressures = zip(*(row[f"pressure_kpa/{wheel}"] for wheel in WHEELS), strict=True)
            lost = [low_wheels(p, row["nominal_pressure_kpa"], share) for p in pressures]
            found.append(list(zip([0.0, *row["time_s"]], [lost[0], *lost], strict=True)))
        return found
