"""Signals that say the same number again and again: a stuck sensor, told from repetition alone.

A sound moving sensor repeats its last number with a probability p at each update that could have changed it (noise,
pitch errors of the ring and quantisation see to that), so a run of n repeats comes by chance once in about 1 / (p^n (1
- p)) updates; the exact mean is (1 - p^n) / (p^n (1 - p)) (Feller, An Introduction to Probability Theory, XIII.7). n is
the least for which that is at least one in `HOURS` over all watched signals. A wheel's speed can only change with the
next tooth: while it is unchanged an update counts only as often as a tooth has gone by. Zero is a standing wheel's
number and no fault. Source: own; p measured on simulated drives over classes A to D, see `REPEATS`."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.arrival import Intake
from estimators.drive_log import Signal

REPEATS = 0.25  # p: the largest measured share is 0.10, of a wheel at 10 km/h on class A
HOURS = 1000.0  # between false alarms of all watched signals together: a hundredth of what the comparisons are allowed
RATE = 100.0  # Hz at the most of what is watched: the bus speed


def run_for(repeats: float, updates: float) -> int:
    """Least n whose runs come by chance once in `updates` or less often. repeats: p, 0 < p < 1."""
    if not (0.0 < repeats < 1.0 and updates >= 1.0):
        raise ValueError(f"repeats {repeats}, updates {updates}; valid: between 0 and 1, and 1 or more")
    n = 1
    while (1.0 - repeats**n) / (repeats**n * (1.0 - repeats)) < updates:
        n += 1
    return n


LONGEST = run_for(REPEATS, 4.0 * RATE * 3600.0 * HOURS)


@dataclass(frozen=True)
class Change:
    """time [s] at which a signal is found stuck (since `since` [s]) or moving again."""

    time: float
    stuck: bool
    since: float


class FrozenWatch:
    """One wheel speed. pitch: angle of a tooth [rad]."""

    def __init__(self, pitch: float) -> None:
        self._pitch = pitch
        self._intake = Intake()
        self._last = math.nan
        self._since = 0.0
        self._time = 0.0
        self._updates = 0.0
        self.stuck = False

    def add(self, signal: Signal) -> list[Change]:
        """Take samples as they arrived."""
        if signal.value.ndim != 1 or signal.value.dtype.kind != "f":
            return []
        good, _ = self._intake.accept(signal.time)
        time, value = signal.time[good], signal.value[good]
        finite = np.isfinite(value)
        return self._follow(time[finite], value[finite])

    def _follow(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> list[Change]:
        found = []
        moving = np.flatnonzero(np.diff(value, prepend=self._last) == 0.0)
        ends = set((np.flatnonzero(np.diff(value, prepend=self._last) != 0.0)).tolist())
        busy = sorted({*moving.tolist(), *ends}) if self.stuck or len(moving) else sorted(ends)[-1:]
        for i in busy:
            now, said = float(time[i]), float(value[i])
            if said != self._last:
                if self.stuck:
                    found.append(Change(now, False, self._since))
                self._last, self._since, self._updates, self.stuck = said, now, 0.0, False
            else:
                teeth = abs(said) * (now - self._time) / self._pitch
                self._updates += min(1.0, teeth)
                if self._updates >= LONGEST and not self.stuck:
                    self.stuck = True
                    found.append(Change(now, True, self._since))
            self._time = now
        return found
