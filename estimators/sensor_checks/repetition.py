"""A sensor that says the same number again and again: stuck, or dead at zero.

A sound sensor repeats its last number with a probability p, and n repeats come by chance once in about 1 / (p^n (1 -
p)) samples (`redundancy.frozen.run_for`, exact). p is what this sensor did so far, but not less than `LEAST`: some
repeat nearly always (a steering angle straight ahead), and are then not judged, since a run says nothing. Zero is no
excuse: an accelerometer at rest has noise. Source: own; run lengths as in `redundancy.frozen`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.redundancy.frozen import run_for

LEAST = 0.25  # p at the least: twice the share of a sound torque signal, the coarsest that is judged
MOST = 0.6  # p above which a sensor is not judged
KNOWN = 200.0  # samples that must have been seen
MARGIN = 1.5  # on the measured p


class RepetitionWatch:
    """One scalar. between: samples of all that are watched between false alarms."""

    def __init__(self, between: float) -> None:
        self._between = between
        self._last, self._since, self._run = math.nan, 0.0, 0
        self._seen = self._repeats = 0.0  # before the present run
        self.stuck = False

    def add(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> list[tuple[float, bool, float]]:
        """Finite samples in order, shape (n,). (time [s], stuck or moving again, since [s]) of every change."""
        found: list[tuple[float, bool, float]] = []
        if not len(time):
            return found
        new = np.flatnonzero(np.diff(value, prepend=self._last) != 0.0)
        ends = np.append(new, len(value))
        self._close(time, int(ends[0]), found)
        for k, first in enumerate(new.tolist()):
            if self.stuck:
                self.stuck = False
                found.append((float(time[first]), False, self._since))
            self._seen += 1.0 + (0.0 if math.isnan(self._last) else self._run)
            self._repeats += self._run
            self._last, self._since, self._run = float(value[first]), float(time[first]), 0
            self._close(time[first + 1 :], int(ends[k + 1]) - first - 1, found)
        return found

    def _close(self, time: NDArray[np.float64], repeats: int, found: list[tuple[float, bool, float]]) -> None:
        """The run goes on by so many repeats, at these times."""
        longest = self._longest()
        if repeats and longest and not self.stuck and self._run + repeats >= longest:
            self.stuck = True
            found.append((float(time[max(longest - self._run - 1, 0)]), True, self._since))
        self._run += repeats

    def _longest(self) -> int:
        """Repeats that are too many, 0 while that is not known."""
        if self._seen < KNOWN or math.isnan(self._last):
            return 0
        p = max(LEAST, MARGIN * self._repeats / self._seen)
        return run_for(round(p, 2), self._between) if p < MOST else 0
