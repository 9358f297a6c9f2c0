"""A fault of a wheel's speed on its tooth edges, so that edges and bus speed tell of the same faulty turning.

The ring's angle in pitches, N(t), has the slope omega / pitch. Between two edges omega is that of the pitch before the
first of them, at most pitch / silence, and 0 after `TIMEOUT` of silence. Inside the fault's time

    N'(t) = N'(start) + integral |omega'| / pitch dt,     omega' = faulty(t, omega)

and an edge comes whenever N' passes a whole number: the sensor does not see direction. Pieces end at edges and at cells
of 10 ms, in which random faults are constant; edges so come out up to a cell late. Exact for a steady wheel; otherwise
N' is off by the change of omega over one pitch.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.faults.fault import Fault
from estimators.faults.kind import ValueFault
from estimators.faults.line import Line, Times, Values

CELL = 0.01  # s: the usual period of the bus speed
TIMEOUT = 0.5  # s without an edge after which a wheel stands, as brake controllers reckon
FASTEST = 1000.0  # rad/s that a sensor can report


class EdgeLine(Line):
    """Values are the counts that edges add, shape (n, 1)."""

    def __init__(self, fault: Fault, kind: ValueFault, teeth: float) -> None:
        self._fault, self._kind, self._pitch = fault, kind, 2.0 * math.pi / teeth
        self._known: Times = np.empty(0)  # the last two edges, and those of the open cell
        self._done: float | None = None  # [s] up to which the fault's edges are made
        self._count = 0.0  # N'

    def advance(self, time: Times, value: Values, until: float) -> tuple[Times, Values]:
        start, end = self._fault.start, self._fault.end
        before, after = time < start, time >= end
        believed = time <= until  # an edge cannot come before its stamp
        self._take(time[before & believed], observed=True)
        self._take(time[~before & ~after & believed], observed=False)
        made = self._made(min(until, end))
        times = np.concatenate([time[before], made, time[after]])
        return times, np.concatenate([value[before], np.ones((len(made), 1)), value[after]])

    def _take(self, time: Times, observed: bool) -> None:
        """Keeps edges that follow on the ones before."""
        last = self._known[-1] if len(self._known) else -np.inf
        clock = np.maximum.accumulate(np.concatenate([[last], time]))
        fresh = time[time > clock[:-1]]
        known = np.concatenate([self._known, fresh])
        if observed and len(fresh):
            if len(known) > 1:
                self._kind.observe(self._pitch / np.diff(known[-(len(fresh) + 1) :])[:, None])
            known = known[-2:]
        self._known = known

    def _made(self, until: float) -> Times:
        """Edges of the whole cells up to `until` [s] that were not made before."""
        start, end = self._fault.start, self._fault.end
        if self._done is None:
            if until < start or not len(self._known):
                return np.empty(0)
            self._done = start if self._known[0] < start else float(self._known[0])
            self._count = self._phase(self._done)
        last = end if until >= end else math.floor(until / CELL + 1e-9) * CELL
        if not last > self._done:
            return np.empty(0)
        cells = np.arange(math.floor(self._done / CELL + 1e-9) + 1, math.ceil(last / CELL - 1e-9)) * CELL
        inside = self._known[(self._known > self._done) & (self._known < last)]
        marks = np.unique(np.concatenate([[self._done], cells, inside, [last]]))
        speed = self._kind.faulty(marks[:-1], self._speed(marks[:-1])[:, None])[:, 0]
        speed = np.minimum(np.abs(np.where(np.isfinite(speed), speed, 0.0)), FASTEST)
        count = np.cumsum(np.concatenate([[self._count], speed * np.diff(marks) / self._pitch]))
        edges = np.arange(math.floor(self._count) + 1.0, math.floor(count[-1]) + 1.0)
        piece = np.searchsorted(count, edges, side="left") - 1
        share = (edges - count[piece]) / (count[piece + 1] - count[piece])
        self._done, self._count = last, float(count[-1])
        self._known = np.concatenate([self._known[self._known < last][-2:], self._known[self._known >= last]])
        return marks[piece] + share * np.diff(marks)[piece]

    def _speed(self, time: Times) -> Times:
        """Speed of the sound wheel [rad/s] at these times [s]."""
        last = np.searchsorted(self._known, time, side="right") - 1
        turning = last >= 1
        gap = self._known[np.maximum(last, 1)] - self._known[np.maximum(last, 1) - 1] if len(self._known) > 1 else 1.0
        silence = time - self._known[np.maximum(last, 0)]
        return np.where(turning & (silence < TIMEOUT), self._pitch / np.maximum(gap, silence), 0.0)

    def _phase(self, time: float) -> float:
        """Share of a pitch that has gone by at a time since the last edge."""
        at = np.array([time])
        silence = time - self._known[max(int(np.searchsorted(self._known, time, side="right")) - 1, 0)]
        return float(min(self._speed(at)[0] * silence / self._pitch, 0.999))
