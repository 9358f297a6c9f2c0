"""Which wheels have lost pressure: a threshold on the loss that best explains the three observable contrasts.

For every set of one, two or three wheels the common loss x of the set is fitted (generalised least squares); a set and
its complement differ in the sign, and only x < 0, a loss, counts. The set with the least misfit wins, each further
wheel costing `PER_WHEEL` of misfit. Sets of no more wheels whose misfit is within `DISTINCT` of it could be meant as
well: at constant speed only the diagonal contrast is known, which cannot tell fl from rr. Two questions are kept
apart:

Is there a loss at all? The significance -x / std, once a second, is averaged (`Ewma`, memory about 1 / (1 - FORGETTING)
seconds) and compared with THRESHOLD, which gives FALSE_PER_HOUR on sound tyres. The significance is neither Gaussian
nor independent (the greatest of 14 fits; errors that last a drive), so the threshold is the empirical one of
`estimators.detectors.empirical_threshold`, see `thresholds`.
Does it matter? -x must exceed LEVEL of the nominal pressure times the car's radius sensitivity (15 %: 0.15 % of radius
for the default car). UN R141 asks for -20 %, FMVSS 138 for -25 %: on a car of the mean sensitivity 15 % leaves a margin
for noise; on a car 40 % less sensitive a loss of 25 % just reaches it. This only makes alarms rarer.

Other wheels are announced once they have been meant for NAMING_TIME. Equal loss in all four is invisible.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.detectors import Monitor
from estimators.drive_log import WHEELS
from estimators.estimator import Alarm
from estimators.wheel_radius.thresholds import THRESHOLD, alarm_detector
from estimators.wheel_radius.wheel_change import CONTRASTS

LEVEL = 0.15
NAMING_TIME = 10.0  # [s]
RELEASE = 60.0  # [s] without a loss after which the same wheels alarm anew
PER_WHEEL = 4.0  # misfit (chi-square) that a further wheel must explain
DISTINCT = 9.0  # misfit by which another set must be worse to be ruled out: 3 standard deviations
_SETS = tuple(wheels for size in (1, 2, 3) for wheels in combinations(range(4), size))


@dataclass(frozen=True)
class Loss:
    """The wheels (indices of fl fr rl rr) and their common radius change [-] (negative), with its std; every set that
    could be meant, the likeliest first."""

    wheels: tuple[int, ...]
    change: float
    std: float
    candidates: tuple[tuple[int, ...], ...] = ()

    @property
    def significance(self) -> float:
        """The loss in its standard deviations, 0 if there is none."""
        return -self.change / self.std if self.std > 0.0 else 0.0

    @property
    def certain(self) -> tuple[int, ...]:
        """Wheels that are in every candidate."""
        return tuple(w for w in self.wheels if all(w in candidate for candidate in self.candidates))


def likeliest_loss(contrasts: NDArray[np.float64], covariance: NDArray[np.float64]) -> Loss:
    """Of all sets, the one whose common loss explains contrasts (3,) with covariance (3, 3) best."""
    weight = np.linalg.inv(covariance)
    fits: list[tuple[float, Loss]] = []
    for wheels in _SETS:
        shape = CONTRASTS[:, wheels].sum(axis=1)
        information = float(shape @ weight @ shape)
        change = float(shape @ weight @ contrasts) / information
        rest = contrasts - change * shape
        if change < 0.0:
            fits.append((float(rest @ weight @ rest), Loss(wheels, change, information**-0.5)))
    if not fits:
        return Loss((), 0.0, 0.0)
    fits.sort(key=lambda fit: fit[0] + PER_WHEEL * len(fit[1].wheels))
    least, best = fits[0]
    near = [loss.wheels for misfit, loss in fits if misfit < least + DISTINCT and len(loss.wheels) <= len(best.wheels)]
    return Loss(best.wheels, best.change, best.std, tuple(near))


class LowPressureAlarm:
    """Watches the likeliest loss over time."""

    def __init__(self, car: Car) -> None:
        self._car = car
        self.level = LEVEL * car.pressure * car.radius_sensitivity
        self._candidates: frozenset[tuple[int, ...]] = frozenset()
        self._since = 0.0  # these candidates
        self._monitor = Monitor(alarm_detector(), "clear")
        self._announced: frozenset[tuple[int, ...]] = frozenset()
        self._last_loss = -np.inf
        self.nearness = 0.0
        """The smaller of statistic over threshold and loss over level [-]: above 1 there is an alarm."""

    def step(self, time: float, contrasts: NDArray[np.float64], covariance: NDArray[np.float64]) -> Alarm | None:
        """An alarm if one is due at `time` [s]."""
        loss = likeliest_loss(contrasts, covariance)
        reading = self._monitor.step(loss.significance)
        self.nearness, significant = min(reading.statistic / THRESHOLD, -loss.change / self.level), reading.alarm
        if not (significant and -loss.change > self.level):
            self._candidates = frozenset()
            if time - self._last_loss > RELEASE:
                self._announced = frozenset()
            return None
        self._last_loss = time
        meant = frozenset(loss.candidates)
        if meant != self._candidates:
            self._candidates, self._since = meant, time
        if meant == self._announced or (self._announced and time - self._since < NAMING_TIME):
            return None
        self._announced = meant
        return Alarm(time, self._text(loss), tuple(WHEELS[i] for i in loss.certain))

    def _text(self, loss: Loss) -> str:
        radius, std = 100.0 * loss.change, 100.0 * loss.std
        pressure = 1e-3 * loss.change / self._car.radius_sensitivity
        names = [" and ".join(WHEELS[i] for i in wheels) for wheels in loss.candidates]
        which = f" in {' or '.join(names)}" if len(names) > 1 else ""
        size = f"radius {radius:+.2f} % (std {std:.2f} %) against calibration, about {pressure:+.0f} kPa"
        return f"low pressure{which}: {size}"
