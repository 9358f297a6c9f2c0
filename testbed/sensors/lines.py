"""From the true motion to the log: each line is a sensor, the changes asked for, losses and delay.

analogue:  motion -> error chain -> transforms -> dropouts -> delay -> signal
wheel:     motion -> edges -> transforms -> delay -> signal `edges`
                                             `-> bus speed -> transforms -> dropouts -> delay -> signal `speed`
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from estimators.drive_log import WHEELS, Signal
from testbed.sensors.analogue import AnalogueSensor
from testbed.sensors.bus import Dropouts, Outbox
from testbed.sensors.bus_speed import BusSpeed
from testbed.sensors.defaults import CHANNELS, EDGE_NAMES, SPEED_NAMES
from testbed.sensors.encoder import Encoder
from testbed.sensors.motion import WIDTHS, FloatArray, Motion
from testbed.sensors.settings import AnalogueSettings, BusSpeedSettings, EncoderSettings
from testbed.sensors.streams import Seeds

# Changes what a sensor says: (signal name, instants of measurement [s], values) -> instants and values.
# Instants may not move forward past the chunk that they came in. Edges come with values of 1, one an edge.
Transform = Callable[[str, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


class AnalogueLine:
    """One analogue signal."""

    def __init__(self, name: str, settings: AnalogueSettings, seed: int | Seeds) -> None:
        self._name, self._channel = name, CHANNELS[name]
        width = WIDTHS[self._channel.field] if self._channel.wheel is None else 0
        self._scalar = width == 0
        self._sensor = AnalogueSensor(name, settings, seed, max(width, 1))
        self._dropouts = Dropouts(name, seed, settings.dropout, settings.burst, settings.burst_length)
        self._outbox = Outbox(settings.delay, width)

    def advance(self, chunk: Motion, changed: Transform) -> dict[str, Signal]:
        """The signal by its name, as far as it has reached the bus."""
        rows = getattr(chunk, self._channel.field)
        if self._channel.wheel is not None:
            rows = rows[:, self._channel.wheel]
        rows = np.array(rows, dtype=np.float64, order="C").reshape(len(rows), -1)
        time, value = self._sensor.advance(chunk.first_step, rows)
        time, value = changed(self._name, time, value[:, 0] if self._scalar else value)
        kept = self._dropouts.keep(len(time))
        time, value = self._outbox.send(time[kept], value[kept], chunk.end)
        return {self._name: Signal(time, value, self._channel.unit, self._channel.frame)}


class WheelLine:
    """A wheel's edges, and the bus speed computed from them (speed None: not on this bus)."""

    def __init__(
        self,
        wheel: int,
        edges: EncoderSettings,
        speed: BusSpeedSettings | None,
        seed: int | Seeds,
        nominal_radius: float,
    ) -> None:
        self._wheel = wheel
        self._edges, self._speed = EDGE_NAMES[WHEELS[wheel]], SPEED_NAMES[WHEELS[wheel]]
        self._encoder = Encoder(self._edges, edges, seed)
        self._edge_box, self._count = Outbox(edges.delay), 0
        self._bus_speed: BusSpeed | None = None
        if speed is not None:
            self._bus_speed = BusSpeed(speed, edges.teeth, nominal_radius)
            self._dropouts = Dropouts(self._speed, seed, speed.dropout, speed.burst, speed.burst_length)
            self._speed_box = Outbox(speed.delay)

    def advance(self, chunk: Motion, changed: Transform) -> dict[str, Signal]:
        """Edges (value: running count) and bus speed by name, as far as they have reached the bus."""
        first, w = chunk.first_step, self._wheel
        edges = self._encoder.advance(first, chunk.rim_angle[:, w].copy(), chunk.rim_speed[:, w].copy())
        edges, ones = changed(self._edges, edges, np.ones(len(edges)))
        edges, _ = self._edge_box.send(edges, ones, chunk.end)
        signals = {self._edges: Signal(edges, self._count + np.arange(1.0, len(edges) + 1.0))}
        self._count += len(edges)
        if self._bus_speed is not None:
            time, value = self._bus_speed.advance(first, first + len(chunk.time) - 1, edges)
            time, value = changed(self._speed, time, value)
            kept = self._dropouts.keep(len(time))
            time, value = self._speed_box.send(time[kept], value[kept], chunk.end)
            signals[self._speed] = Signal(time, value, "rad/s")
        return signals
