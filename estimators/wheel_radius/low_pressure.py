"""Which wheels have lost pressure: a threshold on the loss that best explains the three observable contrasts.

For every set of one, two or three wheels the common loss x of the set is fitted (generalised least squares); a set and
its complement differ in the sign, and only x < 0, a loss, counts. The set with the least misfit wins, each further
wheel costing `PER_WHEEL` of misfit. It alarms when -x exceeds both
    LEVEL of the nominal pressure times the car's radius sensitivity      (15 %: 0.15 % of radius for the default car)
    SIGMAS standard deviations of x
for `PERSISTENCE` without a break. UN R141 asks for -20 %, FMVSS 138 for -25 %: on a car of the mean sensitivity 15 %
leaves a margin for noise; on a car 40 % less sensitive a loss of 25 % just reaches it. Equal loss in all four is
invisible. The threshold is a level, not a designed test, and no rate is claimed beyond what was counted: no alarm in 6
h of synthetic driving without a loss (wheel-speed noise 0.03 to 0.6 rad/s a sample), so below 0.5 per hour at 95 %.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.drive_log import WHEELS
from estimators.estimator import Alarm
from estimators.wheel_radius.wheel_change import CONTRASTS

LEVEL = 0.15
SIGMAS = 4.0
PERSISTENCE = 10.0  # [s]
RELEASE = 60.0  # [s] without a loss after which the same wheels alarm anew
PER_WHEEL = 4.0  # misfit (chi-square) that a further wheel must explain
_SETS = tuple(wheels for size in (1, 2, 3) for wheels in combinations(range(4), size))


@dataclass(frozen=True)
class Loss:
    """The wheels (indices of fl fr rl rr) and their common radius change [-] (negative), with its std."""

    wheels: tuple[int, ...]
    change: float
    std: float


def likeliest_loss(contrasts: NDArray[np.float64], covariance: NDArray[np.float64]) -> Loss:
    """Of all sets, the one whose common loss explains contrasts (3,) with covariance (3, 3) best."""
    weight = np.linalg.inv(covariance)
    best, best_cost = Loss((), 0.0, 0.0), np.inf
    for wheels in _SETS:
        shape = CONTRASTS[:, wheels].sum(axis=1)
        information = float(shape @ weight @ shape)
        change = float(shape @ weight @ contrasts) / information
        rest = contrasts - change * shape
        cost = float(rest @ weight @ rest) + PER_WHEEL * len(wheels)
        if change < 0.0 and cost < best_cost:
            best, best_cost = Loss(wheels, change, information**-0.5), cost
    return best


class LowPressureAlarm:
    """Watches the likeliest loss over time."""

    def __init__(self, car: Car) -> None:
        self._car = car
        self.level = LEVEL * car.pressure * car.radius_sensitivity
        self._candidate: tuple[int, ...] = ()
        self._since = 0.0
        self._announced: tuple[int, ...] = ()
        self._last_loss = -np.inf

    def step(self, time: float, contrasts: NDArray[np.float64], covariance: NDArray[np.float64]) -> Alarm | None:
        """An alarm if one is due at `time` [s]."""
        loss = likeliest_loss(contrasts, covariance)
        if not -loss.change > max(self.level, SIGMAS * loss.std):
            self._candidate = ()
            if time - self._last_loss > RELEASE:
                self._announced = ()
            return None
        self._last_loss = time
        if loss.wheels != self._candidate:
            self._candidate, self._since = loss.wheels, time
        if time - self._since < PERSISTENCE or loss.wheels == self._announced:
            return None
        self._announced = loss.wheels
        return Alarm(time, self._text(loss), tuple(WHEELS[i] for i in loss.wheels))

    def _text(self, loss: Loss) -> str:
        radius, std = 100.0 * loss.change, 100.0 * loss.std
        pressure = 1e-3 * loss.change / self._car.radius_sensitivity
        return f"low pressure: radius {radius:+.2f} % (std {std:.2f} %) against calibration, about {pressure:+.0f} kPa"
