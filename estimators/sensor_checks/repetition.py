"""A sensor that says the same number again and again: stuck, or dead at zero.

A sound sensor repeats its last number with a probability p, and n repeats come by chance once in about 1 / (p^n (1 -
p)) samples (`redundancy.frozen.run_for`, exact). p is what this sensor did so far, but not less than `LEAST`: some
repeat nearly always (a steering angle straight ahead), and are then not judged, since a run says nothing. Zero is no
excuse: an accelerometer at rest has noise. Source: own; run lengths as in `redundancy.frozen`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from estimators.redundancy.frozen import run_for

LEAST = 0.25  # p at the least: twice the share of a sound torque signal, the coarsest that is judged
MOST = 0.6  # p above which a sensor is not judged
KNOWN = 200.0  # samples that must have been seen
MARGIN = 1.5  # on the measured p


@dataclass(frozen=True)
class Change:
    """time [s] at which a sensor is found stuck (since `since` [s]) or moving again."""

    time: float
    stuck: bool
    since: float


class RepetitionWatch:
    """One scalar. between: samples of all that are watched between false alarms."""

    def __init__(self, between: float) -> None:
        self._between = between
        self._least = run_for(LEAST, between)
        self._last, self._since, self._run = math.nan, 0.0, 0
        self._seen = self._repeats = 0  # samples of the runs that have ended, and repeats among them
        self.stuck = False

    def add(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> list[Change]:
        """Finite samples in order, shape (n,). Stuck and moving again, as they happen."""
        found: list[Change] = []
        new = np.flatnonzero(np.diff(value, prepend=self._last) != 0.0)
        if not self.stuck and len(new) and len(value) > self._least:  # runs that are short need no look one by one
            gaps = np.diff(np.append(new, len(value)))
            quiet = new[0] + self._run < self._least and int(gaps[:-1].max(initial=0)) < self._least
            if quiet and not math.isnan(self._last):
                done = int(new[-1])
                self._seen += self._run + 1 + done
                self._repeats += self._run + done + 1 - len(new)
                self._last, self._since, self._run = float(value[done]), float(time[done]), 0
                time, value, new = time[done + 1 :], value[done + 1 :], new[:0]
        start = 0
        for end in [*new.tolist(), len(value)]:
            self._repeat(time[start:end], found)
            if end < len(value):
                self._begin(float(time[end]), float(value[end]), found)
            start = end + 1
        return found

    def _begin(self, time: float, value: float, found: list[Change]) -> None:
        """Another number."""
        if not math.isnan(self._last):
            self._seen += self._run + 1
            self._repeats += self._run
        if self.stuck:
            found.append(Change(time, False, self._since))
        self._last, self._since, self._run, self.stuck = value, time, 0, False

    def _repeat(self, time: NDArray[np.float64], found: list[Change]) -> None:
        """The same number again at these times."""
        if not self.stuck and self._run + len(time) >= self._least and self._seen >= KNOWN:
            p = max(LEAST, MARGIN * self._repeats / self._seen)
            longest = _longest(round(p, 2), self._between) if p < MOST else math.inf
            if self._run + len(time) >= longest:
                self.stuck = True
                found.append(Change(float(time[max(int(longest) - self._run - 1, 0)]), True, self._since))
        self._run += len(time)


@cache
def _longest(repeats: float, between: float) -> int:
    return run_for(repeats, between)
