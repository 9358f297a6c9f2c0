"""Is a tyre's pressure too low, whatever became of it? A level, once for each wheel until it is filled.

Low: below SHARE of the car's nominal pressure by SIGMAS standard deviations, the sensor's constant error among them, at
HELD samples in a row. UN R141 asks for a warning 20 % below. A sound tyre 20 kPa above that level warns with the
probability that a sensor is off by 9 standard deviations: no rate is designed.
"""

from __future__ import annotations

SHARE, SIGMAS, HELD = 0.8, 3.0, 5


class LowPressure:
    """Watches one wheel. nominal: gauge pressure [Pa]."""

    def __init__(self, nominal: float) -> None:
        self._nominal = nominal
        self._below = 0
        self._said = False

    def step(self, pressure: float, std: float) -> str | None:
        """A warning if one is due. pressure, std: [Pa]."""
        low = pressure < SHARE * self._nominal - SIGMAS * std
        self._below = self._below + 1 if low else 0
        if self._said or self._below < HELD:
            return None
        self._said = True
        lost = 100.0 * (1.0 - pressure / self._nominal)
        return f"low pressure: {1e-3 * pressure:.0f} kPa (std {1e-3 * std:.1f}), {lost:.0f} % below nominal"

    def reset(self) -> None:
        """The tyre was filled."""
        self._below, self._said = 0, False
