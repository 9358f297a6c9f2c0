"""How much warmer the tyres run than when the drive began, as a change of ln pressure, from speed alone.

    dx/dt = GAIN v - x / TAU        x: ln p(warm) - ln p(cold); v [m/s]

Rolling losses heat the tyre by about their force times v; gas at constant volume follows the temperature, p + p_atm ~ T
(20 K at a steady 100 km/h, 0.48 % of 250 kPa each; warm after 20 to 30 min: declared, as in `models/tyres`). A drive is
taken to begin cold. What a car warms more or less than that (load, tyre, rim) is a state of `sound_car` with a std of
UNLIKE of x; a drive that begins warm is within what a day may be off. Left out: brakes, sun, rain.
"""

from __future__ import annotations

import math

TAU = 1000.0  # s
GAIN = 20.0 * 0.0048 / (100.0 / 3.6 * TAU)  # per m
UNLIKE = 0.25


class Warming:
    """x by block. seconds: of a block."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._last: int | None = None
        self.excess = 0.0

    def step(self, number: int, speed: float) -> float:
        """x after block `number` at a speed [m/s], NaN if unknown, which counts as standing."""
        elapsed = self._seconds * (1 if self._last is None else number - self._last)
        self._last = number
        self.excess *= math.exp(-elapsed / TAU)
        if math.isfinite(speed):
            self.excess += GAIN * speed * self._seconds
        return self.excess
