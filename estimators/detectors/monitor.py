"""A detector at work: one sample at a time or over arrays, with the same result to the last bit.

What happens after an alarm is chosen:
    latch     the alarm stays on until `reset`
    clear     the alarm is on while the statistic is above the level; a CUSUM that wound up in a long change needs as
              long to come down
    restart   the statistic starts from 0 after the sample that alarmed, so that alarms can be counted
A sample that is NaN or infinite, and samples that never came, leave statistic and alarm as they were and are counted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.detectors.detector import Detector
from estimators.detectors.loops import ALARM_ON, ALARMS, CLEAR, LATCH, REFUSED, RESTART, USED, follow

AFTER_ALARM = {"latch": LATCH, "clear": CLEAR, "restart": RESTART}


@dataclass(frozen=True)
class Reading:
    """What a detector says after a sample: the statistic (>= 0, finite) and whether the alarm is on."""

    statistic: float
    alarm: bool


@dataclass(frozen=True, eq=False)
class Readings:
    """What a detector says after each sample: statistic and alarm, both of shape (n,)."""

    statistic: NDArray[np.float64]
    alarm: NDArray[np.bool_]


class Monitor:
    """The evolving state of a detector. after_alarm: latch, clear or restart."""

    def __init__(self, detector: Detector, after_alarm: str = "clear") -> None:
        if after_alarm not in AFTER_ALARM:
            raise ValueError(f"after_alarm is {after_alarm!r}, valid: {', '.join(AFTER_ALARM)}")
        self.detector = detector
        self._numbers = detector.numbers()
        self._after_alarm = AFTER_ALARM[after_alarm]
        self._state = np.zeros(detector.state_size)
        self._last = np.zeros(1)
        self._counts = np.zeros(4, dtype=np.int64)
        self.missing = 0
        """Samples that never came."""
        self.gaps = 0
        """Stretches of them."""

    def step(self, x: float, missing: int = 0) -> Reading:
        """Take one residual; missing: samples lost since the one before."""
        readings = self.run(np.array([x]), None if missing == 0 else np.array([missing]))
        return Reading(float(readings.statistic[0]), bool(readings.alarm[0]))

    def run(self, x: ArrayLike, missing: ArrayLike | None = None) -> Readings:
        """Take residuals of shape (n,). missing: samples lost before each, shape (n,) (see `missing_samples`).

        ValueError for another shape or a negative number of lost samples.
        """
        samples = np.ascontiguousarray(x, dtype=np.float64)
        if samples.ndim != 1:
            raise ValueError(f"residuals have shape {samples.shape}, want (n,)")
        if missing is not None:
            lost = np.asarray(missing)
            if lost.shape != samples.shape or lost.dtype.kind not in "iu" or (lost < 0).any():
                raise ValueError("missing samples: want a whole number at least 0 for each residual")
            self.missing += int(lost.sum())
            self.gaps += int(np.count_nonzero(lost))
        readings = Readings(np.empty(len(samples)), np.empty(len(samples), dtype=np.bool_))
        follow(
            self.detector.kind,
            self._numbers,
            self.detector.level,
            self._after_alarm,
            self._state,
            self._last,
            self._counts,
            samples,
            readings.statistic,
            readings.alarm,
        )
        return readings

    def reset(self) -> None:
        """Statistic 0, alarm off; the counts go on."""
        self._state[:] = 0.0
        self._last[:] = 0.0
        self._counts[ALARM_ON] = 0

    @property
    def statistic(self) -> float:
        """As it is now."""
        return float(self._last[0])

    @property
    def alarm(self) -> bool:
        """Whether the alarm is on."""
        return bool(self._counts[ALARM_ON])

    @property
    def alarms(self) -> int:
        """How often the alarm went on."""
        return int(self._counts[ALARMS])

    @property
    def used(self) -> int:
        """Samples that moved the statistic."""
        return int(self._counts[USED])

    @property
    def refused(self) -> int:
        """Samples that were NaN or infinite."""
        return int(self._counts[REFUSED])


def missing_samples(time: ArrayLike, period: float) -> NDArray[np.int64]:
    """Samples lost before each of those at `time` [s], shape (n,), when one is due every `period` [s].

    A stamp that is not finite or not after the last good one tells nothing: 0. At most 1e9 are counted at once.
    """
    stamps = np.asarray(time, dtype=np.float64)
    if not (np.isfinite(period) and period > 0.0):
        raise ValueError(f"period is {period:g}, valid: a number of seconds above 0")
    lost = np.zeros(len(stamps), dtype=np.int64)
    usable = np.flatnonzero(np.isfinite(stamps))
    latest = np.maximum.accumulate(stamps[usable])
    steps = np.diff(latest) / period
    lost[usable[1:]] = np.clip(np.rint(steps) - 1.0, 0.0, 1e9).astype(np.int64)
    return lost
