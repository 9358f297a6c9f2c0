"""Is a tyre's pressure too low, whatever became of it? A level, once for each wheel until it is filled.

Low: below SHARE of the car's nominal pressure (UN R141 asks for a warning 20 % below) by the sensor's largest constant
error, 3 TOLERANCE, and by a threshold in units of the estimate's std. The threshold is that of a detector
(`Integrator` of period 1) with one false alarm in BETWEEN_FALSE_ALARMS over four wheels, all exactly at SHARE with
sensors that read 3 TOLERANCE too low: the worst that is no loss. Its run length is exact for independent errors;
those of a filter are positively correlated, so false alarms are rarer (Slepian, Bell System Tech. J. 41, 1962). HELD
samples in a row, so that one wild first sample is no warning, make them rarer still.
"""

from __future__ import annotations

from functools import cache
from math import floor, frexp

from estimators.detectors import design_integrator
from estimators.direct_pressure.numbers import BETWEEN_FALSE_ALARMS, TOLERANCE
from estimators.drive_log import WHEELS

SHARE, HELD = 0.8, 5
SHORTEST, LONGEST = 1e-3, 3600.0  # s, of intervals that are told apart


@cache
def _designed(arl0: float) -> float:
    return design_integrator(1.0, arl0, "upper", period=1).detector.level


def threshold(interval: float) -> float:
    """In std of the estimate, for samples every `interval` [s]; for the power of two below it, which is not less."""
    shorter = 2.0 ** (frexp(min(max(interval, SHORTEST), LONGEST))[1] - 1)
    return _designed(floor(len(WHEELS) * BETWEEN_FALSE_ALARMS / shorter))


class LowPressure:
    """Watches one wheel. nominal: gauge pressure [Pa]."""

    def __init__(self, nominal: float) -> None:
        self._nominal = nominal
        self._below = 0
        self._said = False

    def step(self, pressure: float, std: float, interval: float) -> str | None:
        """A warning if one is due. pressure, std: [Pa], without the sensor's constant error; interval: [s]."""
        if self._said:
            return None
        low = pressure < SHARE * self._nominal - 3.0 * TOLERANCE - threshold(interval) * std
        self._below = self._below + 1 if low else 0
        if self._below < HELD:
            return None
        self._said = True
        lost, hours = 100.0 * (1.0 - pressure / self._nominal), BETWEEN_FALSE_ALARMS / 3600.0
        return (
            f"low pressure: {1e-3 * pressure:.0f} kPa (std {1e-3 * (std**2 + TOLERANCE**2) ** 0.5:.1f}), {lost:.0f} % "
            f"below nominal; false alarms: at most one in {hours:.0f} h"
        )

    def reset(self) -> None:
        """The tyre was filled."""
        self._below, self._said = 0, False
