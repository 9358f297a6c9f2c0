"""Has one tyre of a side lost pressure? The front-rear difference of each block against what this car had.

x = (d - reference) / sqrt(variance + (PER_ACCELERATION a)^2), bounded by `LARGEST`, so that no single block decides,
goes into a two-sided CUSUM (`estimators.detectors`) with drift `DRIFT`: what a block may be off without a loss. A fall
of d = ln k_f - ln k_r names the front wheel, a rise the rear one. Accelerating and braking move d by some per cent
(load, torque on the hub), which is therefore less certain then. The reference is the mean over the first `LEARNING`
seconds of this drive that say something, or what was learnt on an earlier one; then it follows with `MEMORY`, but not
while the CUSUM is above half its threshold. Blind: an equal loss front and rear.

Threshold: one false alarm in 100 h of rolling for both sides together. Windows overlap, so the run length is not that
of independent samples; it was set on sound drives of tuning cars (0 to 16 of seed 101 of `itpms_fusion.cars`, 2.4 h, a
good third of it in town): `estimators.detectors.empirical_threshold` on the record of x extrapolates to 9.6, peaks over
threshold (`estimators.scores.tail`, maxima of 10 s) to 12.4 and 11.9 with the largest 10 and 5 %, the largest statistic
seen was 8.5; 13 is taken. DRIFT and LARGEST are the quickest at that rate for 15 % lost in the same cars.
"""

from __future__ import annotations

import math

from estimators.detectors import CusumMean, Monitor

FALSE_ALARMS_PER_HOUR = 0.01
DRIFT = 0.85
THRESHOLD = 13.0
LARGEST = 3.0
PER_ACCELERATION = 0.02  # of d per m/s^2
LEARNING = 12.0  # s
MEMORY = 300.0  # s
DAY = 0.012  # std of d from one day to another: unequal warmth, load
FRONT_LOST, REAR_LOST = "front", "rear"


def cusum(threshold: float) -> CusumMean:
    """The detector of one side."""
    return CusumMean(DRIFT, threshold, "both")


class Watch:
    """One side's. reference: of d, None while it is being learnt."""

    def __init__(self, reference: tuple[float, float] | None = None) -> None:
        """reference: d and its std as learnt before."""
        self._monitor = Monitor(cusum(THRESHOLD))
        self.reference: float | None = None if reference is None else reference[0]
        self._information = 0.0 if reference is None else 1.0 / (reference[1] ** 2 + DAY**2)
        self._sum, self._listened = 0.0, 0.0
        self._told = reference
        self.alarmed = False
        self.moved = False
        """Whether the CUSUM is above half its threshold: something has changed."""

    @property
    def learnt(self) -> tuple[float, float] | None:
        """d and its std of a sound car, for another drive; None while it is not known, or after an alarm."""
        if self.reference is None or self.alarmed:
            return None
        return self._told or (self.reference, self._information**-0.5)

    @property
    def statistic(self) -> float:
        """Of the CUSUM."""
        return self._monitor.statistic

    def step(self, d: float, variance: float, acceleration: float, seconds: float) -> str | None:
        """A block's d and variance, acceleration [m/s^2]; seconds: from block to block. What is lost, when it is
        noticed: `FRONT_LOST`, `REAR_LOST`."""
        whole = variance + (PER_ACCELERATION * acceleration) ** 2
        if not math.isfinite(whole):
            return None
        if self.reference is None:
            self._sum += d / whole
            self._information += 1.0 / whole
            self._listened += seconds
            if self._listened >= LEARNING:
                self.reference = self._sum / self._information
            return None
        x = (d - self.reference) / math.sqrt(whole + 1.0 / self._information)
        reading = self._monitor.step(min(max(x, -LARGEST), LARGEST))
        self.moved = reading.statistic >= 0.5 * THRESHOLD
        if not self.moved:
            self._information = self._information * math.exp(-seconds / MEMORY) + 1.0 / whole
            self.reference += (d - self.reference) / whole / self._information
            self._told = None
        if not reading.alarm or self.alarmed:
            return None
        self.alarmed = True
        return FRONT_LOST if x < 0.0 else REAR_LOST
