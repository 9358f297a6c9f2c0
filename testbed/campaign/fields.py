"""Fields of a campaign file's [scenario], with their units in the name, and the scenario that they mean.

A number per wheel may be one number for all four. `road_gd` stands in for `road`: a level of unevenness that can be
drawn from a distribution.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from estimators.drive_log import WHEELS
from testbed.brake_pull import FOREVER, BrakePull
from testbed.campaign.distributions import KINDS
from testbed.scenario import Scenario
from testbed.tyre.inflation import Leak, PressureSet

KELVIN = 273.15

Convert = Callable[[str, Any], Any]


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} is {value!r}, want a number, or a table of one of {', '.join(KINDS)}")
    return float(value)


def _scaled(factor: float, offset: float = 0.0) -> Convert:
    return lambda name, value: factor * _number(name, value) + offset


def _as_is(name: str, value: Any) -> Any:
    return value


def _tuple(name: str, value: Any) -> tuple[Any, ...]:
    if not isinstance(value, list | tuple):
        raise ValueError(f"{name} is {value!r}, want a list")
    return tuple(value)


def _mapping(name: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ValueError(f"{name} is {value!r}, want a table with {', '.join(WHEELS)}")
    return value


def _per_wheel(factor: float, offset: float = 0.0) -> Convert:
    def convert(name: str, value: Any) -> dict[str, float]:
        wheels = value if isinstance(value, Mapping) else dict.fromkeys(WHEELS, value)
        return {wheel: factor * _number(f"{name}.{wheel}", v) + offset for wheel, v in wheels.items()}

    return convert


def _parts(name: str, value: Any, wanted: tuple[str, ...], optional: tuple[str, ...] = ()) -> dict[str, float]:
    table = _mapping(name, value)
    odd = (set(table) ^ set(wanted)) - set(optional)
    if odd:
        raise ValueError(f"{name} has {sorted(table)}, want {', '.join((*wanted, *optional))}")
    return {key: _number(f"{name}.{key}", v) for key, v in table.items()}


def _leaks(name: str, value: Any) -> dict[str, Leak]:
    found = {}
    for wheel, entry in _mapping(name, value).items():
        parts = _parts(f"{name}.{wheel}", entry, ("rate",), ("start_s",))
        found[wheel] = Leak(1e3 * parts["rate"], parts.get("start_s", 0.0))
    return found


def _sets(name: str, value: Any) -> dict[str, PressureSet]:
    found = {}
    for wheel, entry in _mapping(name, value).items():
        parts = _parts(f"{name}.{wheel}", entry, ("to", "start_s"), ("within_s",))
        found[wheel] = PressureSet(1e3 * parts["to"], parts["start_s"], parts.get("within_s", 0.1))
    return found


def _pulls(name: str, value: Any) -> dict[str, BrakePull]:
    found = {}
    for wheel, entry in _mapping(name, value).items():
        parts = _parts(f"{name}.{wheel}", entry, ("torque", "start_s"), ("end_s",))
        found[wheel] = BrakePull(parts["torque"], parts["start_s"], parts.get("end_s", FOREVER))
    return found


# field of the file -> field of the scenario, conversion
FIELDS: dict[str, tuple[str, Convert]] = {
    "road": ("road", _as_is),
    "road_gd": ("road", lambda name, value: f"gd={_number(name, value)!r}"),
    "speed_kmh": ("speed", _scaled(1.0 / 3.6)),
    "duration_s": ("duration", _scaled(1.0)),
    "manoeuvre": ("manoeuvre", _as_is),
    "tyre": ("tyre", _as_is),
    "seed": ("seed", _as_is),
    "car_seed": ("car_seed", _as_is),
    "pressure_kpa": ("pressures", _per_wheel(1e3)),
    "leak_kpa_s": ("leaks", _leaks),
    "set_kpa": ("pressure_sets", _sets),
    "brake_nm": ("brake_pulls", _pulls),
    "radius_percent": ("radius_factor", _per_wheel(0.01, 1.0)),
    "payload_kg": ("payload", _scaled(1.0)),
    "payload_position_m": ("payload_position", _tuple),
    "friction": ("friction", _as_is),
    "grade_percent": ("grade", _scaled(0.01)),
    "bank_percent": ("bank", _scaled(0.01)),
    "wind_kmh": ("wind", _scaled(1.0 / 3.6)),
    "wind_from_deg": ("wind_from", _scaled(math.pi / 180.0)),
    "gust_percent": ("gusts", _scaled(0.01)),
    "obstacles": ("obstacles", _tuple),
    "faults": ("faults", _tuple),
    "driven": ("driven", _as_is),
    "ambient_c": ("ambient", _scaled(1.0, KELVIN)),
    "sensors": ("sensors", _mapping),
    "active_steering": ("active_steering", _as_is),
    "faults_in_loop": ("faults_in_loop", _as_is),
    "lock_steering_s": ("steering_lock", _scaled(1.0)),
}


def scenario_from(fields: Mapping[str, Any], **beside: Any) -> Scenario:
    """The scenario of these fields of a file; beside: fields of the scenario itself. ValueError names a bad one."""
    values: dict[str, Any] = {}
    for name, value in fields.items():
        if name not in FIELDS:
            raise ValueError(f"unknown field {name!r} of [scenario]; valid: {', '.join(FIELDS)}")
        target, convert = FIELDS[name]
        if target in values:
            raise ValueError(f"{name!r} says again what another field of [scenario] says of the {target}")
        values[target] = convert(name, value)
    return Scenario(**(beside | values))
