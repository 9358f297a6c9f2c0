"""How a drive changes the sensors' default settings: a nested mapping from signal names, or patterns, to fields."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from fnmatch import fnmatchcase
from typing import Any

from testbed.sensors.defaults import default_settings
from testbed.sensors.settings import SensorSettings, check_settings


def sensor_settings(
    overrides: Mapping[str, Mapping[str, Any]] | None = None, active_steering: bool = False
) -> dict[str, SensorSettings]:
    """Settings of every sensor by signal name: the defaults, changed by `overrides`. active_steering: whether the car
    has it, and its sensors.

    overrides: signal name, or pattern with * for any part of it, -> field -> value, as
    {"imu/gyro": {"noise": 0.001}, "hub/*/accel_z": {"rate": 500.0}}; later entries win.
    ValueError (one line) on a name that no sensor has, a field that the sensor has not, and a value out of its limits.
    """
    settings = default_settings(active_steering)
    for pattern, changes in (overrides or {}).items():
        names = [name for name in settings if fnmatchcase(name, pattern)]
        if not names:
            raise ValueError(f"no sensor is named {pattern!r}; there are {', '.join(sorted(settings))}")
        if not isinstance(changes, Mapping):
            raise ValueError(f"{pattern}: {changes!r} is not a mapping of settings, want for example {{'noise': 0.1}}")
        for name in names:
            settings[name] = _changed(name, settings[name], changes)
    return settings


def _changed(name: str, settings: SensorSettings, changes: Mapping[str, Any]) -> SensorSettings:
    known = [part.name for part in fields(settings)]
    for key in changes:
        if key not in known:
            raise ValueError(f"{name} has no setting {key!r}; it has {', '.join(known)}")
    changed = replace(settings, **changes)
    check_settings(name, changed)
    return changed
