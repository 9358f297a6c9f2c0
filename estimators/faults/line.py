"""One fault on one signal: samples in, as they arrive, samples out, however the stream is cut.

Values are (n, k), a scalar's k is 1. Held-up samples come out in the order of their new stamps, once the clock has
reached them. Left out: what the receiver makes of it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from estimators.faults.fault import Fault
from estimators.faults.kind import DelayFault, LossFault, ValueFault

Times = NDArray[np.float64]
Values = NDArray[np.float64]


class Line(ABC):
    """State of one fault on one signal."""

    @abstractmethod
    def advance(self, time: Times, value: Values, until: float) -> tuple[Times, Values]:
        """time: [s] (n,), value: SI (n, k) of what arrived up to the clock `until` [s] and was not given before."""


class ValueLine(Line):
    """Another value: all columns, or one."""

    def __init__(self, fault: Fault, kind: ValueFault) -> None:
        self._fault, self._kind = fault, kind

    def advance(self, time: Times, value: Values, until: float) -> tuple[Times, Values]:
        before, inside = time < self._fault.start, (time >= self._fault.start) & (time < self._fault.end)
        column = self._fault.target.column
        chosen = slice(None) if column is None else slice(column, column + 1)
        if column is not None and column >= value.shape[1]:
            return time, value
        if before.any():
            self._kind.observe(value[before][:, chosen])
        if inside.any():
            value = np.array(value)
            value[inside, chosen] = self._kind.faulty(time[inside], value[inside][:, chosen])
        return time, value


class LossLine(Line):
    """Fewer samples."""

    def __init__(self, fault: Fault, kind: LossFault) -> None:
        self._fault, self._kind = fault, kind

    def advance(self, time: Times, value: Values, until: float) -> tuple[Times, Values]:
        inside = (time >= self._fault.start) & (time < self._fault.end)
        kept = ~(inside & self._kind.lost(time))
        return time[kept], value[kept]


class Merge:
    """The order in which samples of several sources arrive: by the largest stamp that each source has reached."""

    def __init__(self) -> None:
        self._clock = -np.inf

    def arrival(self, time: Times) -> Times:
        """Clock [s] at the arrival of each sample of one source."""
        clock = np.maximum.accumulate(np.concatenate([[self._clock], time]))
        self._clock = float(clock[-1])
        return clock[1:]


class DelayLine(Line):
    """Samples held up; what has not come by the end of the log never does."""

    def __init__(self, fault: Fault, kind: DelayFault) -> None:
        self._fault, self._kind = fault, kind
        self._merge = Merge()
        self._held: tuple[Times, Values] | None = None

    def advance(self, time: Times, value: Values, until: float) -> tuple[Times, Values]:
        arrival = self._merge.arrival(time)
        late = (time >= self._fault.start) & (time < self._fault.end)
        moved = np.where(late, np.rint((time + self._kind.seconds) * 1e9) / 1e9, time)
        arrival = np.where(late, moved, arrival)
        if self._held is not None and len(self._held[0]):
            held, values = self._held
            moved, value = np.concatenate([held, moved]), np.concatenate([values, value])
            arrival, late = np.concatenate([held, arrival]), np.concatenate([np.ones(len(held), bool), late])
        order = np.argsort(arrival, kind="stable")
        moved, value, waits = moved[order], value[order], (late & (arrival > until))[order]
        self._held = moved[waits], value[waits]
        return moved[~waits], value[~waits]
