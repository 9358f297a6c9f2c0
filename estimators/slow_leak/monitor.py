"""Finds tyres that slowly lose pressure, from direct sensors' days' values: one day at a time, or a record at once.

    monitor = SlowLeakMonitor(tyres=6)
    for day, pressure in ...:                    # whole days, rising; [Pa] at one temperature, NaN where missing
        said = monitor.step(day, pressure)       # said[i].event: "alarm" on the day on which tyre i is found to leak

    leaks = find_leaks(days, pressures)          # the same over arrays: start, rate with interval, alarm, end

A leak is a loss beyond that of the vehicle's other tyres, by more than `Model.tolerated`: natural loss, weather, height
and what temperature normalisation leaves are common to all tyres, and a tyre alone, or with one other only, has only
its own natural loss to be compared with (`Model.tolerated_alone`), which is slower. Equal leaks in most tyres are not
seen. One day's state is in `recursion`, values of a day in `days`. False alarms: one in `BETWEEN_FALSE_ALARMS` watched
days of a tyre, exact (integral equation) for one that loses what is tolerated, rarer for a better one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.slow_leak import recursion
from estimators.slow_leak.numbers import MODEL, OTHERS, Model
from estimators.slow_leak.rate import Line, line_of

EVENTS = ("", "alarm", "step up", "step down", "over", "no others", "outlier")
LATEST_DAY = 10_000_000


@dataclass(frozen=True)
class TyreDay:
    """relative: pressure less what is common [Pa], NaN if not known; statistic: the CUSUM [std]; leaking: whether the
    alarm is on; event: one of `EVENTS`."""

    relative: float
    statistic: float
    leaking: bool
    event: str


@dataclass(frozen=True, eq=False)
class Leak:
    """tyre: its column. start, alarm, end: days; end is that of the record while it goes on. ending: "step up", "over"
    or "record". at_alarm: line through the days from start to alarm; whole: to the end. None for too few days."""

    tyre: int
    start: int
    alarm: int
    end: int
    ending: str
    at_alarm: Line | None
    whole: Line | None


@dataclass(frozen=True, eq=False)
class Watched:
    """said: what `recursion` said, shape (n, tyres, 6); days: shape (n,). leaks: in order of alarm."""

    days: NDArray[np.int64]
    said: NDArray[np.float64]
    leaks: tuple[Leak, ...]

    @property
    def watched(self) -> NDArray[np.int64]:
        """Days on which each tyre's CUSUM took a value, shape (tyres,)."""
        return np.isfinite(self.said[:, :, recursion.X]).sum(axis=0)

    def steps(self, tyre: int) -> list[tuple[int, str]]:
        """Day and kind of each new level of a tyre."""
        event = self.said[:, tyre, recursion.EVENT]
        return [
            (int(day), EVENTS[int(kind)])
            for day, kind in zip(self.days, event, strict=True)
            if kind in (recursion.STEP_UP, recursion.STEP_DOWN)
        ]


class SlowLeakMonitor:
    """The state of one vehicle's tyres. ValueError unless there is at least one."""

    def __init__(self, tyres: int, model: Model = MODEL) -> None:
        if tyres < 1:
            raise ValueError(f"tyres is {tyres}, valid: a whole number from 1")
        self.model = model
        self._compare = tyres > OTHERS
        self._tolerated = model.tolerated if self._compare else model.tolerated_alone
        self._memory = np.zeros((tyres, recursion.SIZE))
        self._memory[:, [recursion.LEVEL, recursion.HELD]] = np.nan
        self._last = -LATEST_DAY - 1

    def run(self, days: ArrayLike, pressure: ArrayLike) -> NDArray[np.float64]:
        """Takes whole days, shape (n,), rising and after those before; pressure [Pa], shape (n, tyres), NaN or infinite
        where missing. What `recursion` says, shape (n, tyres, 6). ValueError for other shapes or order."""
        given, table = np.asarray(days), np.array(pressure, dtype=np.float64)
        tyres = len(self._memory)
        if given.ndim != 1 or table.shape != (len(given), tyres):
            raise ValueError(
                f"pressure has shape {table.shape} beside days {given.shape}, valid: (n, {tyres}) and (n,)"
            )
        if len(given) == 0:
            return np.empty((0, tyres, recursion.SAID))
        if given.dtype.kind not in "iu" or np.abs(given.astype(np.float64)).max() > LATEST_DAY:
            raise ValueError(f"days hold {given[0]}, valid: whole numbers up to {LATEST_DAY}")
        numbers = given.astype(np.int64)
        if numbers[0] <= self._last or (np.diff(numbers) <= 0).any():
            raise ValueError(f"days begin with {numbers[0]} after {self._last}, valid: each later than the one before")
        self._last = int(numbers[-1])
        table[~np.isfinite(table)] = np.nan
        said = np.empty((len(numbers), tyres, recursion.SAID))
        recursion.follow(
            self._memory, numbers.astype(np.float64), table, self._tolerated, self._compare, self.model, said
        )
        return said

    def step(self, day: int, pressure: ArrayLike) -> list[TyreDay]:
        """Takes one day: pressure [Pa], shape (tyres,)."""
        said = self.run(np.array([day]), np.asarray(pressure, dtype=np.float64)[None])[0]
        return [
            TyreDay(
                float(row[recursion.RELATIVE]), float(row[recursion.STATISTIC]), bool(memory[recursion.ON]),
                EVENTS[int(row[recursion.EVENT])],
            )
            for row, memory in zip(said, self._memory, strict=True)
        ]  # fmt: skip


def find_leaks(days: ArrayLike, pressure: ArrayLike, model: Model = MODEL) -> Watched:
    """The leaks of a vehicle's record; arguments as of `SlowLeakMonitor.run`."""
    table = np.asarray(pressure, dtype=np.float64)
    if table.ndim != 2:
        raise ValueError(f"pressure has shape {table.shape}, valid: (days, tyres)")
    said = SlowLeakMonitor(table.shape[1], model).run(days, table)
    numbers = np.asarray(days, dtype=np.int64)
    leaks = [leak for tyre in range(table.shape[1]) for leak in _leaks(numbers, said[:, tyre], tyre)]
    return Watched(numbers, said, tuple(sorted(leaks, key=lambda leak: (leak.alarm, leak.tyre))))


def _leaks(days: NDArray[np.int64], said: NDArray[np.float64], tyre: int) -> list[Leak]:
    """Of one tyre."""
    event, found = said[:, recursion.EVENT], []
    for first in np.flatnonzero(event == recursion.ALARM):
        start = int(said[first, recursion.SINCE])
        ends = np.flatnonzero((event == recursion.STEP_UP) | (event == recursion.OVER))
        after = ends[ends > first]
        last = int(after[0]) if len(after) else len(days) - 1
        ending = EVENTS[int(event[last])] if len(after) else "record"
        relative = said[:, recursion.RELATIVE].copy()
        usual = event != recursion.OUTLYING  # also the first day of a step
        whole = (days >= start) & usual & (np.arange(len(days)) < last + (ending == "record"))
        early = whole & (np.arange(len(days)) <= first)
        found.append(
            Leak(
                tyre, start, int(days[first]), int(days[last]), ending,
                line_of(days[early], relative[early]), line_of(days[whole], relative[whole]),
            )
        )  # fmt: skip
    return found
