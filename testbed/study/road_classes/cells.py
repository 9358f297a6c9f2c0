"""Cells of the study: road class, speed and pressure of one drive at constant speed, and the tasks that drive them.

Speeds: ordinary ones on A to D. The vertical velocity that a road imposes grows as Gd v, so a class up at the same ride
is four times slower; E to G take what eight trial drives of 40 s at 150 kPa all survived upright (20 and 40, 10 and 20,
5 and 10 km/h; at 20 km/h one of eight on G tipped over). Even so one road of ten learnt on stopped the car on G at 10
km/h, and two or three at 5 km/h. Class H, 0.5 m r.m.s. with slopes of a third, is no road for a car: of eight drives at
5 km/h four tipped over, the others stuck in a dip. It is driven to see just that.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from estimators.drive_log import WHEELS
from testbed.roads.iso8608 import class_gd
from testbed.scenario import Scenario

SPEEDS: dict[str, tuple[float, ...]] = {
    "A": (50.0, 80.0, 120.0),
    "B": (50.0, 80.0, 120.0),
    "C": (50.0, 80.0, 110.0),
    "D": (30.0, 50.0, 80.0),
    "E": (20.0, 40.0),
    "F": (10.0, 20.0),
    "G": (5.0, 10.0),
    "H": (5.0,),
}  # km/h
PRESSURES = (250.0, 200.0, 150.0)  # kPa, in all four tyres
DURATION = 30.0  # s


@dataclass(frozen=True)
class Cell:
    """road: class; speed [km/h]; pressure [kPa]."""

    road: str
    speed: float
    pressure: float

    @property
    def name(self) -> str:
        return f"{self.road} {self.speed:g} km/h {self.pressure:g} kPa"


FULL = tuple(Cell(road, v, p) for road, speeds in SPEEDS.items() for v in speeds for p in PRESSURES)
SMALL = tuple(
    Cell(road, v, p)
    for road, v, p in (
        ("A", 120.0, 250.0), ("A", 50.0, 150.0), ("B", 80.0, 250.0), ("B", 50.0, 200.0),
        ("C", 80.0, 250.0), ("C", 50.0, 150.0), ("D", 30.0, 250.0), ("D", 80.0, 200.0),
    )
)  # fmt: skip


@dataclass(frozen=True)
class Change:
    """A car off its numbers: factors on the vehicle, on the tyre, on the road's level Gd(n0), on the speed."""

    vehicle: Mapping[str, float]
    tyre: Mapping[str, float]
    level: float = 1.0
    speed: float = 1.0


NONE = Change({}, {})
AXLES = ("front", "rear")
THREE_PERCENT = {
    "tyre stiffness": Change({}, {"cz0": 1.03}),
    "damper": Change({f"{a}.damping_{way}": 1.03 for a in AXLES for way in ("rebound", "compression")}, {}),
    "road level": Change({}, {}, level=1.03),
}


def task(cell: Cell, seed: int, change: Change = NONE, duration: float = DURATION) -> dict[str, Any]:
    """A drive of a cell. An unchanged level is asked for by the class's own name."""
    road = cell.road if change.level == 1.0 else f"gd={change.level * class_gd(cell.road):.12g}"
    scenario = Scenario(
        road=road, speed=change.speed * cell.speed / 3.6, duration=duration, seed=seed,
        pressures=dict.fromkeys(WHEELS, 1e3 * cell.pressure),
    )  # fmt: skip
    return {
        "cell": cell.name,
        "seed": seed,
        "scenario": scenario.as_notes(),
        "vehicle": dict(change.vehicle),
        "tyre": dict(change.tyre),
    }


def tasks(cells: Iterable[Cell], seeds: Iterable[int], change: Change = NONE) -> list[dict[str, Any]]:
    """All cells on each seed's roads."""
    every = tuple(cells)
    return [task(cell, seed, change) for seed in seeds for cell in every]
