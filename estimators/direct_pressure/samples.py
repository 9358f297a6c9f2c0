"""What a wheel's sensors said, merged into events in time order, and what was wrong with it.

An event is taken up once the clock is `LATENCY` past it, a pressure after the others of the same instant; so the result
does not depend on how the stream is cut. Real sensors speak once in a minute: what counts as silence is a
multiple of the sensor's own interval.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.arrival import Intake
from estimators.drive_log import Signal
from estimators.grid import LATENCY

LONGEST_GAP = 300.0  # s; a stamp further ahead needs a second one to be believed
UNKNOWN = 10.0  # s of silence that is worth a flag while a sensor's interval is not known
LEAST_SILENCE, INTERVALS = 1.0, 5.0  # s, and intervals, of silence that is worth a flag

Complaint = tuple[float, str]


@dataclass(frozen=True, eq=False)
class Events:
    """In time order. time [s]; kind: as in `monitor`; value; all of shape (n,)."""

    time: NDArray[np.float64]
    kind: NDArray[np.int64]
    value: NDArray[np.float64]


class Source:
    """One sensor's signal. lowest, highest: beyond it a value is no tyre's; without: what its silence means; steepest:
    step by which a value may differ from a level that follows it at that rate [1/s]."""

    def __init__(
        self, name: str, lowest: float, highest: float, without: str = "",
        steepest: tuple[float, float] = (np.inf, np.inf),
    ) -> None:  # fmt: skip
        self.name, self._lowest, self._highest = name, lowest, highest
        self._step, self._rate = steepest
        self._used: tuple[float, float] | None = None  # time [s], level
        self._without = without and f", {without}"
        self._intake = Intake(LONGEST_GAP)
        self._time, self._value = np.empty(0), np.empty(0)
        self._taken = -np.inf  # horizon up to which samples were taken up
        self._last: float | None = None
        self._interval: float | None = None
        self._silent = False
        self.first = np.inf
        """Of the first usable sample [s]."""

    def add(self, signal: Signal) -> list[Complaint]:
        """Keep the usable samples; complaints about the others."""
        good, refused = self._intake.accept(signal.time)
        complaints = [(time, f"{self.name}: {why}, sample refused") for time, why in refused]
        if signal.value.dtype.kind != "f" or signal.value.ndim != 1:
            shape = "text" if signal.value.dtype.kind != "f" else f"of shape {signal.value.shape}"
            text = f"{self.name}: value is {shape}, want (n,), not used"
            return complaints + [(float(t), text) for t in signal.time[good]]
        time, value = signal.time[good], signal.value[good]
        finite = np.isfinite(value)
        inside = finite & (value >= self._lowest) & (value <= self._highest)
        wild = inside & self._jumps(time, value, inside)
        inside &= ~wild
        late = inside & (time <= self._taken)
        span = f"{self._lowest:g} to {self._highest:g}"
        for wrong, why in (
            (~finite, "not a finite number"),
            (wild, "jumps as no tyre's does, sample refused"),
            (finite & ~inside & ~wild, f"out of range ({span}), sample refused"),
            (late, "handed over too late"),
        ):
            complaints += [(float(t), f"{self.name}: {why}") for t in time[wrong]]
        kept = inside & ~late
        self._time = np.concatenate([self._time, time[kept]])
        self._value = np.concatenate([self._value, value[kept]])
        return complaints

    def _jumps(
        self, time: NDArray[np.float64], value: NDArray[np.float64], inside: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Values that are further off than their sensor can have gone."""
        wild = np.zeros(len(time), dtype=bool)
        if np.isinf(self._step):
            return wild
        for i in np.flatnonzero(inside).tolist():
            if self._used is None:
                self._used = (float(time[i]), float(value[i]))
            passed, off = float(time[i]) - self._used[0], float(value[i]) - self._used[1]
            most = self._rate * max(passed, 0.0)
            wild[i] = abs(off) > self._step + most
            if not wild[i]:
                self._used = (max(float(time[i]), self._used[0]), self._used[1] + min(max(off, -most), most))
        return wild

    def take(self, horizon: float) -> tuple[NDArray[np.float64], NDArray[np.float64], list[Complaint]]:
        """Samples up to `horizon` [s] in time order, and complaints about silences among them."""
        due = self._time <= horizon
        time, value = self._time[due], self._value[due]
        self._time, self._value = self._time[~due], self._value[~due]
        self._taken = max(self._taken, horizon)
        complaints: list[Complaint] = []
        for stamp in time.tolist():
            self._watch(stamp, complaints)
            if self._last is not None and self.first < np.inf:
                step = stamp - self._last
                usual = step if self._interval is None else self._interval
                self._interval = usual + 0.1 * (min(step, 3.0 * usual) - usual)
            self._last, self._silent, self.first = stamp, False, min(self.first, stamp)
        self._watch(horizon, complaints)
        return time, value, complaints

    def first_waiting(self) -> float:
        """Time of the earliest sample that waits [s], infinite if none does."""
        return float(self._time[0]) if len(self._time) else np.inf

    def expect(self, time: float) -> None:
        """Another sensor of the car has spoken at `time` [s]: so should this one."""
        if self._last is None:
            self._last = time

    def _watch(self, clock: float, complaints: list[Complaint]) -> None:
        if self._last is None or self._silent:
            return
        limit = UNKNOWN if self._interval is None else max(LEAST_SILENCE, INTERVALS * self._interval)
        if clock - self._last > limit:
            self._silent = True
            complaints.append((self._last + limit, f"{self.name}: no usable sample for {limit:.3g} s{self._without}"))


def merged(*sources: tuple[int, NDArray[np.float64], NDArray[np.float64]]) -> Events:
    """Events of (kind, time, value) of some sensors; of one instant in the order given."""
    time = np.concatenate([source[1] for source in sources])
    kind = np.repeat([source[0] for source in sources], [len(source[1]) for source in sources])
    order = np.argsort(time, kind="stable")
    return Events(time[order], kind[order], np.concatenate([source[2] for source in sources])[order])


class Turning:
    """Of a wheel's speed at 100 Hz what `standing` needs: where it begins or ends to turn, and one sample a second."""

    def __init__(self, slowest: float) -> None:
        """slowest: [rad/s], up to which a wheel stands."""
        self._slowest = slowest
        self._stood: bool | None = None
        self._second = -np.inf

    def thinned(
        self, time: NDArray[np.float64], value: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Those of the samples in time order, shape (n,), that tell something new."""
        if len(time) == 0:
            return time, value
        stands, second = np.abs(value) <= self._slowest, np.floor(time)
        before = np.concatenate([[stands[0] if self._stood is None else self._stood], stands[:-1]])
        told = (stands != before) | (second != np.concatenate([[self._second], second[:-1]]))
        self._stood, self._second = bool(stands[-1]), float(second[-1])
        return time[told], value[told]


def horizon_of(until: float) -> float:
    """Time up to which every sample that is in order has been handed over [s]."""
    return until - LATENCY
