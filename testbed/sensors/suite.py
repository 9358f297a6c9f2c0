"""The sensor suite: true motion in, chunk by chunk, and out come the signals that the car's bus carries.

The result does not depend on how the drive is cut into chunks, nor one signal on which others there are.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np

from estimators.drive_log import WHEELS, Signal
from testbed.sensors.defaults import CHANNELS, EDGE_NAMES, SPEED_NAMES
from testbed.sensors.lines import AnalogueLine, Transform, WheelLine
from testbed.sensors.motion import FloatArray, Motion
from testbed.sensors.settings import (
    AnalogueSettings,
    BusSpeedSettings,
    EncoderSettings,
    SensorSettings,
    check_settings,
)
from testbed.sensors.streams import Seeds


class SensedCar(Protocol):
    """What the sensors know of the car."""

    @property
    def nominal_radius(self) -> float:
        """Wheel radius that the brake controller converts with [m]."""


class SensorSuite:
    """All sensors of a car.

    settings: by signal name, as `sensor_settings` gives them; a sensor left out does not exist. seed: whole, >= 0, of
    the drive. car: its nominal radius. car_seed: of its parts (bias, scale, tooth pitches), None: the drive's.
    transforms: applied in order to every signal. ValueError on unknown names, wrong kinds of settings or values out of
    limits.
    """

    def __init__(
        self,
        settings: Mapping[str, SensorSettings],
        seed: int,
        car: SensedCar,
        transforms: Iterable[Transform] = (),
        car_seed: int | None = None,
    ) -> None:
        for number in (seed, car_seed if car_seed is not None else seed):
            if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or number < 0:
                raise ValueError(f"seed {number!r} is not a whole number >= 0")
        seeds = Seeds(int(seed), int(seed if car_seed is None else car_seed))
        if not (math.isfinite(car.nominal_radius) and car.nominal_radius > 0.0):
            raise ValueError(f"nominal radius {car.nominal_radius!r} m is not positive and finite")
        _check_names(settings)
        self._transforms = tuple(transforms)
        self._lines: list[AnalogueLine | WheelLine] = [
            AnalogueLine(name, figures, seeds)
            for name, figures in settings.items()
            if isinstance(figures, AnalogueSettings)
        ]
        for w, wheel in enumerate(WHEELS):
            edges, speed = settings.get(EDGE_NAMES[wheel]), settings.get(SPEED_NAMES[wheel])
            if isinstance(edges, EncoderSettings):
                bus_speed = speed if isinstance(speed, BusSpeedSettings) else None
                self._lines.append(WheelLine(w, edges, bus_speed, seeds, car.nominal_radius))
        self._next: int | None = None

    def advance(self, chunk: Motion) -> dict[str, Signal]:
        """What reached the bus up to the chunk's last step: all signals by name, some perhaps empty.

        ValueError when the chunk does not continue the one before.
        """
        first = chunk.first_step
        if self._next is not None and first != self._next:
            raise ValueError(f"motion: chunk starts at step {first}, the drive continues at step {self._next}")
        self._next = first + len(chunk.time)
        signals: dict[str, Signal] = {}
        for line in self._lines:
            signals |= line.advance(chunk, self._changed)
        return signals

    def _changed(self, name: str, time: FloatArray, value: FloatArray) -> tuple[FloatArray, FloatArray]:
        for transform in self._transforms:
            time, value = transform(name, time, value)
        return time, value


def _check_names(settings: Mapping[str, SensorSettings]) -> None:
    kinds = (
        dict.fromkeys(CHANNELS, AnalogueSettings)
        | dict.fromkeys(EDGE_NAMES.values(), EncoderSettings)
        | dict.fromkeys(SPEED_NAMES.values(), BusSpeedSettings)
    )
    for name, figures in settings.items():
        if name not in kinds:
            raise ValueError(f"no sensor is named {name!r}; there are {', '.join(sorted(kinds))}")
        if not isinstance(figures, kinds[name]):
            raise ValueError(f"{name}: settings are {type(figures).__name__}, want {kinds[name].__name__}")
        check_settings(name, figures)
    for wheel in WHEELS:
        if SPEED_NAMES[wheel] in settings and EDGE_NAMES[wheel] not in settings:
            raise ValueError(f"{SPEED_NAMES[wheel]} is computed from {EDGE_NAMES[wheel]}: keep that sensor too")
