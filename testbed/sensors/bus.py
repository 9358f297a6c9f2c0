"""The way from a sensor to the log: samples get lost, the rest arrives late.

A time stamp is the moment at which a value is on the bus: instant of measurement + delay. A sample is handed on only
when the drive has reached its stamp, so what was still under way when the drive ends is not in the log.
"""

from __future__ import annotations

import numpy as np

from testbed.sensors.motion import FloatArray
from testbed.sensors.streams import Seeds, stream


class Dropouts:
    """Loses single samples, and gaps of whole bursts. dropout, burst: probability per sample; length: of a burst."""

    def __init__(self, name: str, seed: int | Seeds, dropout: float, burst: float, length: int) -> None:
        self._dropout, self._burst, self._length = dropout, burst, length
        self._single, self._start = stream(seed, name, "dropout"), stream(seed, name, "burst")
        self._since = length  # samples since the last burst began

    def keep(self, n: int) -> slice | np.ndarray:
        """Which of the next n samples arrive."""
        if not (self._dropout or self._burst):
            return slice(None)
        kept = np.ones(n, dtype=bool)
        if self._dropout:
            kept &= self._single.random(n) >= self._dropout
        if self._burst and n:
            here = np.arange(n)
            begins = np.where(self._start.random(n) < self._burst, here, -1 - self._since)
            since = here - np.maximum.accumulate(begins)
            self._since = int(since[-1])
            kept &= since >= self._length
        return kept


class Outbox:
    """Holds samples back until the drive has reached their stamps, and hands them on in the order of the stamps."""

    def __init__(self, delay: float, width: int = 0) -> None:
        self._delay = delay
        self._time = np.empty(0)
        self._value = np.empty((0, width)) if width else np.empty(0)

    def send(self, time: FloatArray, value: FloatArray, until: float) -> tuple[FloatArray, FloatArray]:
        """Takes samples measured at `time` [s]; gives stamps and values of all that are on the bus at `until` [s]."""
        time = np.concatenate([self._time, np.rint((time + self._delay) * 1e9) / 1e9])
        value = np.concatenate([self._value, value])
        if len(time) > 1 and (time[1:] < time[:-1]).any():
            order = np.argsort(time, kind="stable")
            time, value = time[order], value[order]
        arrived = int(np.searchsorted(time, until, side="right"))
        self._time, self._value = time[arrived:], value[arrived:]
        return time[:arrived], value[:arrived]
