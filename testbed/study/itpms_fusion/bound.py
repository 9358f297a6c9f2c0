"""How soon vibration could find a loss at one false alarm in 100 h, whatever the method: the Cramer-Rao bound.

A mode of frequency f and damping zeta, excited by a white road and heard without noise for a time T, has

    var(ln f) >= zeta / (2 pi f T)

so n tyres that lose d [ln pressure] bring the information J = n sum over modes (g d)^2 2 pi f / zeta per second while
the mode is heard (g = d ln f / d ln p). A CUSUM that knows pattern, loss and every constant of the car alarms when it
has gathered ln(ARL0) nats, at J / 2 per second. Heard: antiphase from 13 m/s on, in phase between 9 and 16 m/s (the
contact patch's gap and the slip's damping, see `estimators.vibration.modes`), so standing and creeping in town count as
waiting. Radius adds to it where fewer than four tyres are low; what limits a radius is not noise but what else changes
with traction, load and path, for which no bound is known.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.itpms.monitor import SENSITIVITY
from estimators.itpms.thresholds import FALSE_ALARMS_PER_HOUR

# frequency [Hz], damping, slowest and fastest [m/s], of the default car
HEARD = ((87.0, 0.07, 13.0, math.inf), (41.0, 0.15, 9.0, 16.0))
ARL0 = 3600.0 / FALSE_ALARMS_PER_HOUR  # samples of 1 s


def information(speed: NDArray[np.float64], tyres: int, share: float) -> NDArray[np.float64]:
    """J of each second at speeds [m/s], shape (n,)."""
    lost = math.log1p(-share)
    total = np.zeros(len(speed))
    for (frequency, damping, slowest, fastest), sensitivity in zip(HEARD, SENSITIVITY, strict=True):
        each = (sensitivity * lost) ** 2 * 2.0 * math.pi * frequency / damping
        total += np.where((speed >= slowest) & (speed <= fastest), each, 0.0)
    return tyres * total


def detection_bound(speed: NDArray[np.float64], reached: float, tyres: int, share: float) -> float | None:
    """Seconds from `reached` [s] on, when the loss is complete, to the alarm; None if the drive ends before. speed: of
    each second of the drive [m/s]."""
    gathered = 0.0
    rates = 0.5 * information(speed, tyres, share)[round(reached) :]
    for second, rate in enumerate(rates):
        if rate > 0.0 and gathered + rate >= math.log(ARL0):
            return second + (math.log(ARL0) - gathered) / float(rate)
        gathered += float(rate)
    return None
