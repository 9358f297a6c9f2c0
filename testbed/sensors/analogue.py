"""The error chain of an analogue sensor, from the true quantity to the number in its message.

    y = clip(q round(((1 + s) x + b + w + n) / q))

s scale error (fixed + drawn once), b bias (fixed + drawn once), w random walk, n white noise, q quantisation step. Each
column of a vector sensor has its own draws. Source: IEEE Std 1293 and 952 error terms, without the bias instability.
"""

from __future__ import annotations

import numpy as np

from testbed.sensors.motion import STEPS_PER_SECOND, FloatArray
from testbed.sensors.sampling import Clock, Sampler
from testbed.sensors.settings import AnalogueSettings
from testbed.sensors.streams import Seeds, stream


class AnalogueSensor:
    """One signal's sensor. name: of the signal, picks the random streams together with seed. width: columns."""

    def __init__(self, name: str, settings: AnalogueSettings, seed: int | Seeds, width: int) -> None:
        self._settings = settings
        part = stream(seed, name, "part")
        self.bias = settings.bias + settings.bias_std * part.standard_normal(width)
        self.scale = settings.scale + settings.scale_std * part.standard_normal(width)
        self._noise, self._steps = stream(seed, name, "noise"), stream(seed, name, "walk")
        self._walk = np.zeros((1, width))
        self._sampler = Sampler(
            Clock(settings.rate, settings.jitter, stream(seed, name, "clock")), settings.average, width
        )

    def advance(self, first: int, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Instants of measurement [s], shape (m,), and values, shape (m, width), of rows, shape (n, width).

        first: index of the first row on the 1 ms grid.
        """
        s = self._settings
        instants, x = self._sampler.advance(first, rows)
        y = x * (1.0 + self.scale) + self.bias
        if s.bias_walk:
            steps = self._steps.standard_normal(y.shape) * (s.bias_walk / np.sqrt(s.rate))
            walk = np.cumsum(np.concatenate([self._walk, steps]), axis=0)
            self._walk = walk[-1:]
            y += walk[1:]
        if s.noise:
            y += s.noise * self._noise.standard_normal(y.shape)
        if s.quantisation:
            y = np.rint(y / s.quantisation) * s.quantisation
        return instants / STEPS_PER_SECOND, np.clip(y, s.low, s.high)
