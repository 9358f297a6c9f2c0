"""A car or tyre off its book values, and estimators that are told something else than what drives.

Factors by dotted name: `{"front.spring_rate": 1.05}` of models/suv.toml, `{"pfz1": 0.8}` of the tyre's properties,
`{"chassis_mass": 0.9}` of `estimators.car.Car`. Nested tables mean the same: `{"front": {"spring_rate": 1.05}}`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, TypeVar

from estimators.car import Car
from models.tyre_properties import load_tyre
from models.vehicle import Vehicle, load_vehicle
from testbed.notes import known_car
from testbed.scenario import Scenario
from testbed.session import Variant

BELIEVED_TYRE = "tyre"
Part = TypeVar("Part")

_vehicle = cache(load_vehicle)
_tyre = cache(load_tyre)


def _flat(factors: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in factors.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def scaled(part: Part, factors: Mapping[str, Any], what: str) -> Part:
    """A frozen dataclass with some of its numbers multiplied. ValueError names a number that it does not have."""
    for name, factor in _flat(factors):
        if isinstance(factor, bool) or not isinstance(factor, int | float) or not (0.0 < factor < math.inf):
            raise ValueError(f"[{what}] {name} is {factor!r}, want a factor above 0")
        part = _scaled(part, name.split("."), float(factor), what)
    return part


def _scaled(part: Any, path: list[str], factor: float, what: str) -> Any:
    values = {f.name: getattr(part, f.name) for f in dataclasses.fields(part)}
    parts = {name: value for name, value in values.items() if dataclasses.is_dataclass(value)}
    numbers = {name: v for name, v in values.items() if isinstance(v, int | float) and not isinstance(v, bool)}
    name, *rest = path
    if rest and name in parts:
        return dataclasses.replace(part, **{name: _scaled(parts[name], rest, factor, what)})
    if rest or name not in numbers:
        raise ValueError(f"[{what}] has no number {name!r}; valid: {', '.join([*numbers, *parts])}")
    return dataclasses.replace(part, **{name: factor * numbers[name]})


def variant_of(
    scenario: Scenario,
    vehicle: Mapping[str, Any],
    tyre: Mapping[str, Any],
    believed: Mapping[str, Any],
    calibrations: Mapping[str, Mapping[str, Any]] | None = None,
) -> Variant:
    """What drives and what is told: factors on the vehicle, on the scenario's tyre, and on what the estimators would
    rightly be told of the unscaled car. ValueError or TypeError names a bad factor."""
    return Variant(
        vehicle=scaled(_vehicle(), vehicle, "vehicle"),
        tyre=scaled(_tyre(scenario.tyre), tyre, "tyre"),
        car=believed_car(scenario, believed),
        calibrations=calibrations,
    )


def believed_car(scenario: Scenario, believed: Mapping[str, Any]) -> Car:
    """The unscaled car on the scenario's tyre, or on the tyre that `believed` names, its numbers multiplied."""
    vehicle: Vehicle = _vehicle()
    factors = dict(believed)
    tyre = factors.pop(BELIEVED_TYRE, scenario.tyre)
    if not isinstance(tyre, str):
        raise ValueError(f"[believed] tyre is {tyre!r}, want the name of a tyre")
    return scaled(known_car(vehicle, _tyre(tyre), scenario), factors, "believed")
