"""A sensor whose messages go missing, some or all.

Stamps of a sound sensor follow at an interval that is learnt; a longer gap is so many lost messages. CUSUM of the log
likelihood ratio of a loss share of `FAULTY` against one of `SOUND`, message by message,

    g <- max(g + ln(FAULTY / SOUND), 0) for a lost one,  max(g + ln((1 - FAULTY) / (1 - SOUND)), 0) for one that came,

alarms above h; its mean time between false alarms is at least exp(h) messages (Lorden, Ann. Math. Stat. 42, 1971, eq.
8), so h = ln(messages between false alarms). A silence counts its messages as their time goes by. Where all sensors
are silent at once it is the log, and nobody is accused."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

SOUND, FAULTY = 0.01, 0.1  # share of messages lost, declared
LOST, CAME = math.log(FAULTY / SOUND), math.log((1.0 - FAULTY) / (1.0 - SOUND))
LEARNT = 60  # intervals
SLACK = 1.5  # intervals up to which a gap holds no lost message
REGULAR = 1.6  # of the median: a sensor whose intervals scatter by more is not judged


class MessageWatch:
    """One signal. between: messages of all that are watched between false alarms."""

    def __init__(self, between: float) -> None:
        self._limit = math.log(between)
        self._first: list[float] = []
        self._interval = math.nan
        self._last = math.nan
        self._g = 0.0
        self.accused = False

    def _due(self, last: float) -> float:
        """Time [s] at which a silence since `last` becomes an alarm, infinite if none can."""
        if math.isnan(self._interval) or self.accused:
            return math.inf
        return last + (math.ceil((self._limit - self._g) / LOST) + 1.0) * self._interval

    def add(self, time: NDArray[np.float64], others: NDArray[np.float64]) -> list[tuple[float, bool]]:
        """Good stamps in order, (n,); others: [s] at which other signals spoke, sorted. (time [s], lost or complete
        again) of every change."""
        found: list[tuple[float, bool]] = []
        if math.isnan(self._interval):
            self._first += time.tolist()
            if len(self._first) > LEARNT:
                self._learn()
            if len(time):
                self._last = float(time[-1])
            return found
        if not len(time):
            return found
        steps = np.diff(time, prepend=self._last)
        lost = np.where(steps > SLACK * self._interval, np.rint(steps / self._interval) - 1.0, 0.0)
        done = 0
        for i in np.flatnonzero(lost > 0.0).tolist():
            self._came(time[done:i], found)
            self._gap(float(time[i]), float(steps[i]), float(lost[i]), others, found)
            done = i
        self._came(time[done:], found)
        self._last = float(time[-1])
        return found

    def silent(self, clock: float, others: NDArray[np.float64]) -> list[tuple[float, bool]]:
        """The same where a silence has lasted up to `clock` [s]."""
        due = self._due(self._last)
        if clock <= due or not spoke(others, self._last, due, self._interval):
            return []
        self.accused = True
        return [(due, True)]

    def _came(self, time: NDArray[np.float64], found: list[tuple[float, bool]]) -> None:
        """Messages without a gap between them."""
        if self.accused and self._g + len(time) * CAME <= 0.0:
            self.accused = False
            found.append((float(time[min(math.ceil(self._g / -CAME), len(time)) - 1]), False))
        self._g = max(self._g + len(time) * CAME, 0.0)

    def _gap(
        self, time: float, step: float, lost: float, others: NDArray[np.float64], found: list[tuple[float, bool]]
    ) -> None:
        """Lost messages before the one at `time` [s]."""
        due = self._due(time - step)
        if due <= time and spoke(others, time - step, due, self._interval):
            self.accused = True
            found.append((due, True))
        if not spoke(others, time - step, time, self._interval):
            return
        self._g = min(self._g + lost * LOST, 2.0 * self._limit)
        if self._g > self._limit and not self.accused:
            self.accused = True
            found.append((time, True))

    def _learn(self) -> None:
        steps = np.diff(np.array(self._first))
        usual = float(np.median(steps))
        if usual > 0.0 and float(np.quantile(steps, 0.9)) < REGULAR * usual:
            self._interval = usual
        self._first = self._first[-LEARNT // 2 :]


def spoke(others: NDArray[np.float64], after: float, before: float, apart: float) -> bool:
    """Whether anyone else spoke inside a gap, `apart` [s] from its beginning."""
    first = int(np.searchsorted(others, after + apart, side="right"))
    return first < len(others) and bool(others[first] <= before)
