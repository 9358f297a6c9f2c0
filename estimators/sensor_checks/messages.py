"""A sensor whose messages go missing, some or all.

Stamps of a sound sensor follow at an interval that is learnt; a longer gap is so many lost messages. CUSUM of the log
likelihood ratio of a loss share of `FAULTY` against one of `SOUND`, message by message,

    g <- max(g + ln(FAULTY / SOUND), 0) for a lost one,  max(g + ln((1 - FAULTY) / (1 - SOUND)), 0) for one that came,

alarms above h; its mean time between false alarms is at least exp(h) messages (Lorden, Ann. Math. Stat. 42, 1971), so h
= ln(messages between false alarms). A silence counts its messages as their time goes by, from when any other sensor
speaks in it: where all are silent at once it is the log, and nobody is accused."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

SOUND, FAULTY = 0.01, 0.1  # share of messages lost, declared
LOST, CAME = math.log(FAULTY / SOUND), math.log((1.0 - FAULTY) / (1.0 - SOUND))
LEARNT = 60  # intervals
SLACK = 1.5  # intervals up to which a gap holds no lost message
REGULAR = 1.6  # of the median: a sensor whose intervals scatter by more is not judged

Changes = list[tuple[float, bool]]
Spoken = Callable[[], NDArray[np.float64]]  # [s] at which other signals spoke lately, sorted; asked only in a gap


class MessageWatch:
    """One signal. between: messages of all that are watched between false alarms."""

    def __init__(self, between: float) -> None:
        self._limit = math.log(between)
        self._first: list[float] = []
        self._interval = math.nan
        self._last = math.nan
        self._g = 0.0
        self.accused = False

    def add(self, time: NDArray[np.float64], others: Spoken) -> Changes:
        """Good stamps in order, (n,). (time [s], lost or complete again) of every change."""
        found: Changes = []
        while math.isnan(self._interval) and len(time):
            wanted = LEARNT + 1 - len(self._first)
            self._first += time[:wanted].tolist()
            time = time[wanted:]
            self._learn()
        if not len(time):
            return found
        steps = np.diff(time, prepend=self._last)
        done = 0
        for i in np.flatnonzero(steps > SLACK * self._interval).tolist():
            self._came(time[done:i], found)
            self._gap(float(time[i]), float(time[i] - steps[i]), others, found)
            done = i
        self._came(time[done:], found)
        self._last = float(time[-1])
        return found

    def silent(self, clock: float, others: Spoken) -> Changes:
        """The same where a silence has lasted up to `clock` [s]."""
        if math.isnan(self._interval) or self.accused or clock <= self._due(self._last, self._last):
            return []
        due = self._due(self._last, self._since(self._last, clock, others))
        if due >= clock:
            return []
        self.accused = True
        return [(due, True)]

    def _since(self, last: float, before: float, others: Spoken) -> float:
        """[s] from which on messages of a gap are lost: an interval before another sensor first spoke in it, infinite
        if none did."""
        spoken = others()
        first = int(np.searchsorted(spoken, last + self._interval, side="right"))
        inside = first < len(spoken) and spoken[first] < before - self._interval
        return max(float(spoken[first]) - self._interval, last) if inside else math.inf

    def _due(self, last: float, since: float) -> float:
        """[s] at which a silence since `last` becomes an alarm."""
        return max(last, since) + (math.ceil((self._limit - self._g) / LOST) + 1.0) * self._interval

    def _came(self, time: NDArray[np.float64], found: Changes) -> None:
        """Messages without a gap between them."""
        if self.accused and len(time) and self._g + len(time) * CAME <= 0.0:
            self.accused = False
            found.append((float(time[max(math.ceil(self._g / -CAME), 1) - 1]), False))
        self._g = max(self._g + len(time) * CAME, 0.0)

    def _gap(self, time: float, last: float, others: Spoken, found: Changes) -> None:
        """Lost messages between those at `last` and at `time` [s]."""
        since = self._since(last, time, others)
        if not math.isfinite(since):
            return
        due = self._due(last, since)
        self._g = min(self._g + max(round((time - since) / self._interval) - 1, 0) * LOST, 2.0 * self._limit)
        if self._g > self._limit and not self.accused:
            self.accused = True
            found.append((min(due, time), True))

    def _learn(self) -> None:
        """The interval, once enough stamps have come."""
        if len(self._first) <= LEARNT:
            return
        steps = np.diff(np.array(self._first))
        usual = float(np.median(steps))
        self._last = self._first[-1]
        if usual > 0.0 and float(np.quantile(steps, 0.9)) < REGULAR * usual:
            self._interval = usual
        self._first = self._first[-LEARNT // 2 :]
