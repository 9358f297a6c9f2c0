"""Faults on a stream of signals or on a whole log: the same fault does the same to both, to the last bit.

Each fault is a stage; stages follow one another in the order in which the faults are given. Of tooth edges the value is
their running count, which goes on without a gap.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from estimators.arrival import arrival_times
from estimators.drive_log import WHEELS, DriveLog, Signal
from estimators.faults.chance import NANO, Chance
from estimators.faults.edge_line import CELL, EdgeLine
from estimators.faults.fault import Fault, parse_fault
from estimators.faults.kind import DelayFault, LossFault, SwapFault, ValueFault
from estimators.faults.line import DelayLine, Line, LossLine, Merge, ValueLine

Stream = tuple[NDArray[np.float64], NDArray[np.float64]]
_OPPOSITE = {"fl": "fr", "fr": "fl", "rl": "rr", "rr": "rl"}
EDGES = "/edges"


class _Lines:
    """A stage that changes each of its signals alone."""

    def __init__(self, fault: Fault, seed: int, teeth: Mapping[str, float]) -> None:
        self._lines = {name: _line(fault, name, seed, teeth) for name in fault.target.signals}

    def advance(self, streams: dict[str, Stream], until: float) -> None:
        for name, line in self._lines.items():
            if name in streams:
                streams[name] = line.advance(*streams[name], until)


class _Swap:
    """A stage that exchanges signals with those of the other side."""

    def __init__(self, fault: Fault) -> None:
        wheel, self._fault = fault.target.wheel, fault
        self._pairs = [(name, name.replace(f"/{wheel}/", f"/{_OPPOSITE[wheel]}/")) for name in fault.target.signals]
        self._merge = {name: Merge() for pair in self._pairs for name in pair}

    def advance(self, streams: dict[str, Stream], until: float) -> None:
        for one, other in self._pairs:
            if one not in streams or other not in streams:
                continue
            parts = {name: (self._merge[name].arrival(streams[name][0]), *streams[name]) for name in (one, other)}
            streams |= {one: self._mixed(parts[one], parts[other]), other: self._mixed(parts[other], parts[one])}

    def _mixed(self, own: tuple[NDArray, ...], foreign: tuple[NDArray, ...]) -> Stream:
        inside, theirs = ((p[1] >= self._fault.start) & (p[1] < self._fault.end) for p in (own, foreign))
        arrival, time, value = (np.concatenate([a[~inside], b[theirs]]) for a, b in zip(own, foreign, strict=True))
        order = np.argsort(arrival, kind="stable")
        return time[order], value[order]


def _line(fault: Fault, name: str, seed: int, teeth: Mapping[str, float]) -> Line:
    chance = Chance(seed, f"{fault.target.name} {fault.kind.name}", CELL if fault.target.turns else NANO)
    kind = fault.kind(fault.numbers, fault.start, chance, teeth.get(fault.target.wheel, 1.0))
    if isinstance(kind, ValueFault):
        return EdgeLine(fault, kind, kind.teeth) if name.endswith(EDGES) else ValueLine(fault, kind)
    if isinstance(kind, LossFault):
        return LossLine(fault, kind)
    assert isinstance(kind, DelayFault)
    return DelayLine(fault, kind)


class Injector:
    """Faults on a stream."""

    def __init__(self, faults: Iterable[str], seed: int, teeth: float | Mapping[str, float] = 48.0) -> None:
        """faults: texts. seed: of the drive, whole, >= 0. teeth: of the wheels' rings. ValueError in one line for a
        fault that is none."""
        rings = teeth if isinstance(teeth, Mapping) else dict.fromkeys(WHEELS, teeth)
        self.faults = tuple(parse_fault(text) for text in faults)
        self._stages = [_Swap(f) if issubclass(f.kind, SwapFault) else _Lines(f, seed, rings) for f in self.faults]
        self._touched = {name for fault in self.faults for name in touched(fault)}
        self._like: dict[str, Signal] = {}  # the last of each signal that came: its unit, frame and shape
        self._counted: dict[str, float] = {}  # of each edge signal: the last count that came in
        self._given: dict[str, float] = {}  # and that went out

    def update(self, signals: Mapping[str, Signal], until: float) -> dict[str, Signal]:
        """What arrived up to the clock `until` [s] and was not given before, as the faulty sensors say it. A signal
        that is not made of numbers stays as it is."""
        result, streams = dict(signals), {}
        for name in self._touched:
            if name in signals and signals[name].value.dtype.kind == "f":
                self._like[name] = signals[name]
            if name in self._like:
                streams[name] = self._stream(name, signals.get(name))
        for stage in self._stages:
            stage.advance(streams, until)
        for name, (time, value) in streams.items():
            like = self._like[name]
            if name.endswith(EDGES):
                total = np.cumsum(np.concatenate([[self._given.get(name, 0.0)], value[:, 0]]))
                self._given[name], value = float(total[-1]), total[1:, None]
            result[name] = Signal(time, value if like.value.ndim == 2 else value[:, 0], like.unit, like.frame)
        return result

    def _stream(self, name: str, signal: Signal | None) -> Stream:
        like = self._like[name]
        if signal is None:
            return np.empty(0), np.empty((0, 1 if like.value.ndim == 1 else like.value.shape[1]))
        value = signal.value[:, None] if like.value.ndim == 1 else signal.value
        if name.endswith(EDGES) and len(signal):
            count = np.concatenate([[self._counted.get(name, 0.0)], signal.value])
            self._counted[name] = float(count[-1])
            step = np.diff(count)
            value = np.where(np.isfinite(step), step, 1.0)[:, None]
        return signal.time, value


def touched(fault: Fault) -> list[str]:
    """Signals that a fault changes, those of the other side included."""
    names = list(fault.target.signals)
    if issubclass(fault.kind, SwapFault):
        wheel = fault.target.wheel
        names += [name.replace(f"/{wheel}/", f"/{_OPPOSITE[wheel]}/") for name in names]
    return names


def inject(log: DriveLog, faults: Iterable[str], seed: int = 0, teeth: float = 48.0) -> DriveLog:
    """The log of a car with these faults; notes and all that no sensor said stay. ValueError in one line for a fault
    that is none, or of a sensor that the log does not hold."""
    injector = Injector(faults, seed, teeth)
    for fault in injector.faults:
        held = [name in log and log[name].value.dtype.kind == "f" for name in touched(fault)]
        if not (all(held) if issubclass(fault.kind, SwapFault) and len(held) == 2 else any(held)):
            raise ValueError(f"fault {fault.text!r}: the log has no {' or '.join(touched(fault))}")
        column = fault.target.column
        values = [log[name].value for name in fault.target.signals if name in log]
        if column is not None and any(v.ndim == 1 or v.shape[1] <= column for v in values):
            raise ValueError(f"fault {fault.text!r}: {fault.target.signals[0]} has no such axis in the log")
    clocks = [arrival_times(signal.time)[-1] for signal in log.signals.values() if len(signal)]
    return DriveLog(injector.update(log.signals, float(max(clocks, default=0.0))), log.notes)
