"""Runs estimators on a stream (`Bank`) or on a whole log (`run`) and gives their words as signals.

`est/METHOD/name` and `est/METHOD/name/std` are the estimates, `alarm/METHOD` the alarms (text "wheels: message"), and
`est/METHOD/flags` what a reader must know of the input (text). Names without an event are absent.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from estimators.arrival import arrival_times
from estimators.car import Car
from estimators.drive_log import DriveLog, Signal
from estimators.effective_steering import given, inputs
from estimators.estimator import Alarm, Flag, Outputs
from estimators.registry import check_declaration, select

FLUSH = 0.5  # [s] by which the clock runs on at the end of a log, so that the last samples count


class Bank:
    """Some estimators side by side on one stream. alarms, flags: all so far, by estimator.

    names: estimators, all if None. calibrations: per name, as an earlier bank gave them. ValueError for an unknown
    name.
    """

    def __init__(
        self, names: Iterable[str] | None, car: Car, calibrations: Mapping[str, Mapping[str, Any]] | None = None
    ) -> None:
        kinds = select(names)
        for kind in kinds.values():
            check_declaration(kind)
        self._members = {name: kind(car) for name, kind in kinds.items()}
        self._car = car
        self.alarms: dict[str, list[Alarm]] = {name: [] for name in kinds}
        self.flags: dict[str, list[Flag]] = {name: [] for name in kinds}
        for name in select(calibrations or ()):
            if name in self._members:
                self._members[name].use_calibration((calibrations or {})[name])

    @property
    def names(self) -> tuple[str, ...]:
        """The members, sorted."""
        return tuple(self._members)

    @property
    def reads(self) -> frozenset[str]:
        """Signals that some member reads."""
        return frozenset().union(*(inputs(member.reads, self._car) for member in self._members.values()))

    def update(self, samples: Mapping[str, Signal], until: float) -> dict[str, Signal]:
        """Feed what arrived before `until` [s]; new estimates, alarms and flags as signals."""
        said: dict[str, Signal] = {}
        for name, member in self._members.items():
            outputs = member.update(given(samples, member.reads, self._car), until)
            self.alarms[name] += outputs.alarms
            self.flags[name] += outputs.flags
            said.update(_signals(name, outputs))
        return said

    def calibrations(self) -> dict[str, dict[str, Any]]:
        """What the members learnt of this car, by name; JSON values."""
        learnt = {name: member.calibration() for name, member in self._members.items()}
        return {name: document for name, document in learnt.items() if document is not None}

    def missing(self, names: Iterable[str]) -> dict[str, list[str]]:
        """Members that can say nothing with only the signals `names`, and what each lacks: what it requires, and
        all of those of which it requires any if there is none."""
        present = set(names)
        lacks = {name: [s for s in member.requires if s not in present] for name, member in self._members.items()}
        for name, member in self._members.items():
            if not present.intersection(member.requires_any):
                lacks[name] += member.requires_any
        return {name: signals for name, signals in lacks.items() if signals}


def _signals(name: str, outputs: Outputs) -> dict[str, Signal]:
    said: dict[str, Signal] = {}
    for quantity, estimate in outputs.estimates.items():
        said[f"est/{name}/{quantity}"] = Signal(estimate.time, estimate.value, estimate.unit)
        said[f"est/{name}/{quantity}/std"] = Signal(estimate.time, estimate.std, estimate.unit)
    if outputs.alarms:
        texts = [f"{' '.join(a.wheels)}: {a.text}" if a.wheels else a.text for a in outputs.alarms]
        said[f"alarm/{name}"] = Signal([a.time for a in outputs.alarms], texts)
    if outputs.flags:
        said[f"est/{name}/flags"] = Signal([f.time for f in outputs.flags], [f.text for f in outputs.flags])
    return said


def run(log: DriveLog, names: Iterable[str] | None = None, stretch: float = 1.0) -> dict[str, Signal]:
    """Run the named estimators (all if None) over a log, cut into stretches [s]; estimates, alarms and flags as
    signals.
    """
    return run_bank(Bank(names, Car.from_notes(log.notes), calibrations_of(log.notes)), log, stretch)


def calibrations_of(notes: Mapping[str, Any]) -> Mapping[str, Mapping[str, Any]]:
    """What the estimators of a recorded drive started from, by name; nothing where the notes are silent. ValueError in
    one line if it makes no sense."""
    found = notes.get("calibrations", {})
    if not isinstance(found, Mapping) or not all(isinstance(entry, Mapping) for entry in found.values()):
        raise ValueError(f"notes['calibrations'] is {found!r}, valid: a calibration by estimator name")
    return found


def run_bank(bank: Bank, log: DriveLog, stretch: float = 1.0) -> dict[str, Signal]:
    """Feed a whole log to a bank in the order in which its samples arrived; ValueError if `stretch` [s] is not above
    0.
    """
    if not (np.isfinite(stretch) and stretch > 0.0):
        raise ValueError(f"stretch is {stretch}, valid: a number of seconds above 0")
    visible = {name: signal for name, signal in log.visible().items() if len(signal)}
    stretches = {name: np.floor(arrival_times(s.time) / stretch).astype(np.int64) for name, s in visible.items()}
    pieces: dict[str, list[Signal]] = {}
    every = np.unique(np.concatenate(list(stretches.values()))) if stretches else np.empty(0, dtype=np.int64)
    for number in every.tolist():
        samples = {}
        for name, signal in visible.items():
            first, last = np.searchsorted(stretches[name], (number, number + 1))
            if last > first:
                samples[name] = Signal(signal.time[first:last], signal.value[first:last], signal.unit, signal.frame)
        _collect(pieces, bank.update(samples, (number + 1) * stretch))
    if len(every):
        _collect(pieces, bank.update({}, (int(every[-1]) + 1) * stretch + FLUSH))
    return {name: _joined(parts) for name, parts in sorted(pieces.items())}


def _collect(pieces: dict[str, list[Signal]], said: Mapping[str, Signal]) -> None:
    for name, signal in said.items():
        pieces.setdefault(name, []).append(signal)


def _joined(parts: list[Signal]) -> Signal:
    """One signal of many, in time order; events at one time in the order of their texts."""
    time = np.concatenate([part.time for part in parts])
    value = np.concatenate([part.value for part in parts])
    order = sorted(range(len(time)), key=lambda i: (time[i], value[i])) if value.dtype.kind == "O" else slice(None)
    return Signal(time[order], value[order], parts[0].unit, parts[0].frame)
