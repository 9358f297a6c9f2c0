"""The least standard deviation that anyone could state of a tyre's stiffness by now: the bound beside the report.

Posterior Cramer-Rao bound of (ln k_t, ln lambda, w_l, w_s), stiffness and road (`quarter_car.roughness`) (Tichavsky,
Muravchik, Nehorai, IEEE Trans. Signal Processing 46, 1998):

    J <- (J^-1 + Q)^-1 while time passes,    J <- J + seconds * J_1 while the wheel is heard

J_1 from `quarter_car.bound` (both accelerometers to 50 Hz, white noise) at the stiffness that is believed; Q the
drifts of `posterior`, its jumps left out, which only makes the bound smaller; the first J that of the prior. So it
holds for any method, within what the quarter car says; what the car's parameters leave unknown is not in it.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from estimators.quarter_car.bound import Setting
from estimators.quarter_car.quarter_car import QuarterCar
from estimators.quarter_car.roughness import WAVINESS_STD
from estimators.vertical_pressure.chain import Quarter
from estimators.vertical_pressure.posterior import (
    LEVEL_DRIFT,
    LOG_LEVEL,
    LOG_STIFFNESS,
    SHORT_DRIFT,
    STIFFNESS_DRIFT,
    moments,
)

_Q = np.diag([STIFFNESS_DRIFT**2, LEVEL_DRIFT**2, 0.0, SHORT_DRIFT**2])  # of 1 s
# From 8 to 33 m/s and class A to D J_1 moves by 5 %; here it is largest
_SPEED, _LEVEL = 30.0, 64e-6  # m/s, m^3/rad
_STEP = 0.1  # of ln k_t, over which J_1 is the same


class Limit:
    """Of one wheel."""

    def __init__(self, prior: np.ndarray) -> None:
        """prior: probability of each exp(LOG_STIFFNESS); every level of LOG_LEVEL equally likely."""
        _, stiffness = moments(prior / prior.sum(), LOG_STIFFNESS)
        level = float(np.ptp(LOG_LEVEL)) / math.sqrt(12.0)
        self._information = np.diag([stiffness**-2.0, level**-2.0, WAVINESS_STD**-2.0, WAVINESS_STD**-2.0])

    def pass_time(self, seconds: float) -> None:
        """The tyre and the road may change."""
        covariance = np.linalg.inv(self._information) + seconds * _Q
        self._information = np.linalg.inv(covariance)

    def hear(self, seconds: float, quarter: Quarter, log_stiffness: float) -> None:
        """The wheel is heard, its tyre believed to have that ln k_t."""
        self._information += seconds * _of_a_second(quarter, round(log_stiffness / _STEP))

    def std(self) -> float:
        """Of ln k_t."""
        return float(np.linalg.inv(self._information)[0, 0] ** 0.5)


@lru_cache(maxsize=256)
def _of_a_second(quarter: Quarter, step: int) -> np.ndarray:
    unsprung = quarter.unsprung_mass + quarter.belt_mass
    car = QuarterCar(quarter.sprung_mass, unsprung, quarter.spring_rate, 0.0, quarter.damping, 0.0)
    return Setting(car, math.exp(step * _STEP), _LEVEL, _SPEED).information
