"""From one wheel's tooth edges to its speed on an even clock, second by second.

    tracker = EdgeSpeed(teeth=48)
    tracker.add(times)             # edges as they come, in order (late and repeated ones refused before)
    samples = tracker.advance(end) # up to `end` [s] all edges have come: whole seconds, so that no cut changes a result

Standing, creeping and reversing: an edge says that a tooth passed, not which way, so after a stop (0.5 s without an
edge) the count begins anew and driving backwards reads as forwards.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_speed.resampling import INTEGRAL, RATE, REACH, resample
from estimators.wheel_speed.ring import Ring
from estimators.wheel_speed.tooth_count import DOUBLE, LAST, MISFITTING, MISSING, RESTARTS, count_teeth, fresh_state

TEETH = 48
WAIT = 0.1  # s for the edge that ends a sample's filter: one every 0.1 s is 1.7 km/h
COMPLAINTS = (
    (DOUBLE, "double edges dropped"),
    (MISFITTING, "edges that fit no tooth dropped"),
    (MISSING, "missing edges counted"),
    (RESTARTS, "tooth count lost"),
)


@dataclass(frozen=True)
class Samples:
    """first: index of the first sample, at first / RATE [s]; speed [rad/s]: shape (n,), NaN where it is not known;
    knots: angles known per turn (teeth), or, negative, per second (bus updates)."""

    first: int
    speed: NDArray[np.float64]
    knots: float

    @property
    def time(self) -> NDArray[np.float64]:
        """[s], shape (n,)."""
        return (self.first + np.arange(len(self.speed))) / RATE


class EdgeSpeed:
    """Running tracker of a wheel."""

    def __init__(self, teeth: int = TEETH) -> None:
        self.ring = Ring(teeth)
        self._state = fresh_state()
        self._waiting = np.empty(0)
        self._time, self._tooth, self._run = np.empty(0), np.empty(0), np.empty(0)
        self._next: int | None = None

    def add(self, time: NDArray[np.float64]) -> None:
        """Edge times [s], rising."""
        self._waiting = np.concatenate([self._waiting, time])

    def advance(self, end: float) -> tuple[Samples, list[str]]:
        """Samples that edges before `end` [s] decide, and complaints about those edges."""
        split = int(np.searchsorted(self._waiting, end))
        fresh, self._waiting = self._waiting[:split].copy(), self._waiting[split:]
        tooth, run, tally = np.empty(split), np.empty(split), np.zeros(4)
        changes = self.ring.changes
        kept = count_teeth(self._state, fresh, tooth, run, tally)
        self.ring.learn(fresh[:kept], tooth[:kept], run[:kept])
        self._time = np.concatenate([self._time, fresh[:kept]])
        self._tooth, self._run = np.concatenate([self._tooth, tooth[:kept]]), np.concatenate([self._run, run[:kept]])
        samples = self._samples(end)
        complaints = [text for k, text in COMPLAINTS if tally[k] > 0.0]
        return samples, complaints + ["another tooth ring than before"] * (self.ring.changes - changes)

    def _samples(self, end: float) -> Samples:
        last = math.floor((end - REACH - WAIT) * RATE + 1e-6)  # first one that is not yet decided
        first = self._next if self._next is not None else math.ceil((end - 1.0) * RATE)
        self._next = max(last, first)
        speed = np.empty(self._next - first)
        pitch = 2.0 * math.pi / self.ring.teeth
        angle = pitch * (self._tooth + self.ring.places()[self._tooth.astype(np.int64) % self.ring.teeth])
        whole = np.concatenate([[0], np.diff(self._run) == 0.0]).astype(np.int64) if len(angle) else np.empty(0, int)
        resample(self._time, angle, whole, first, speed, INTEGRAL)
        keep = max(int(np.searchsorted(self._time, self._next / RATE - REACH)) - 1, 0)
        self._time, self._tooth, self._run = self._time[keep:], self._tooth[keep:], self._run[keep:]
        return Samples(first, speed, float(self.ring.teeth))

    @property
    def last_edge(self) -> float:
        """Time of the last edge that was taken [s], -inf before the first."""
        return float(self._state[LAST])
