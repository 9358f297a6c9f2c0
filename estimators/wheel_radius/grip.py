"""A change of the road's grip: the slip of both sides jumps together while the car pulls.

Figure 5 of Persson et al. 2002: the slope 1/k of the slip curve differs between asphalt, gravel and snow. A pressure
loss moves one side, or both over minutes; a new surface moves both at once, in the direction of the traction.
Statistic:
two-sided CUSUM of the mean of both sides' innovations, signed as the traction and over their measured std, one sample a
second; its threshold is exact for `FALSE_PER_HOUR`. An alarm is not told to anybody: it makes the filters forget 1/k,
and a false one costs only confidence. Both tyres of an axle that burst together look the same until the torque changes.
"""

from __future__ import annotations

from estimators.detectors import CusumMean, Monitor, design_cusum_mean, samples_between
from estimators.wheel_radius.longitudinal import Longitudinal
from estimators.wheel_radius.noise import NoiseLevel

SHIFT = 2.0  # [std] to find
FALSE_PER_HOUR = 0.1
DRIFT, THRESHOLD = 1.0, 4.800829318  # of the CUSUM, as `designed` gives it
LEAST_TRACTION = 0.02  # [-] below which no surface shows
FIRST_STD = 1e-3  # of the slip [-] before it is measured


def designed() -> CusumMean:
    """The detector for SHIFT with one false alarm in 1 / FALSE_PER_HOUR hours at a sample a second."""
    found = design_cusum_mean(SHIFT, samples_between(FALSE_PER_HOUR, 1.0), "both").detector
    assert isinstance(found, CusumMean)
    return found


class Grip:
    """Watches both sides of a car."""

    def __init__(self) -> None:
        self._monitor = Monitor(CusumMean(DRIFT, THRESHOLD, "both"), "restart")
        self._noise = NoiseLevel(FIRST_STD**2)
        self.changes = 0

    def step(self, left: Longitudinal, right: Longitudinal) -> None:
        """After both have taken a cell."""
        if left.surprise is None or right.surprise is None:
            return
        traction = 0.5 * (left.surprise[1] + right.surprise[1])
        if abs(traction) < LEAST_TRACTION:
            return
        jump = 0.5 * (left.surprise[0] + right.surprise[0])
        if traction < 0.0:
            jump = -jump
        std = self._noise.variance**0.5
        if self._monitor.step(jump / std).alarm:
            left.forget_slope()
            right.forget_slope()
            self.changes += 1
        self._noise.add(jump, 0.0)
