"""Estimator `steering_actuator`: does the motor of an active front steering do what is demanded of it?

After Razavi, Lund 2006 (seed 004), whose monitors compare motor angle and demand (`residuals`, `published`); here the
demand goes through an identified model of the servo, and the pinion's angle says whether the motor's is true
(`calibration`). Cells of 10 ms, estimates each SAY cells:

    position_residual   delta_M - delta_Md, the thesis' (1.4) [rad of motor]
    servo_error, pinion_error   see `calibration` [rad of motor], with what they may be when nothing is wrong
    servo_evidence, pinion_evidence   largest detector's statistic over its threshold

Alarms say who is accused, by how much and since when (`accusation`), at FALSE_ALARMS_PER_HOUR altogether. A car without
these signals gets not a word. Without a calibration only the first is said. After a silence of GAP cells all sums begin
anew. Left out: which of pinion and steering wheel errs.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.drive_log import Signal
from estimators.estimator import Alarm, Estimate, Estimator, Outputs
from estimators.grid import Cells, Channel, Grid
from estimators.steering_actuator.accusation import PINION, SERVO, Accusation
from estimators.steering_actuator.calibration import Calibration
from estimators.steering_actuator.pinion import BLOCK, Pinion
from estimators.steering_actuator.residuals import GAP, STEP
from estimators.steering_actuator.servo_model import CAUSES, SAID, new_state, simulate
from estimators.steering_actuator.watching import BACK, Said, Told, Watching

FALSE_ALARMS_PER_HOUR = 0.01
SAY = 10  # cells
RESOLUTION = np.radians(0.5)  # rad of motor: std of a cell's residual beside the servo's own, declared
DEMAND, ANGLE, PINION_ANGLE, WHEEL = range(4)
CHANNELS = tuple(
    Channel(f"steering/{name}") for name in ("motor_demand", "motor_angle", "pinion_angle", "angle")
)  # fmt: skip

Array = NDArray[np.float64]
Rows = dict[str, list[tuple[Array, Array, Array]]]


class SteeringActuator(Estimator):
    """See the module's text."""

    name = "steering_actuator"
    reads = tuple(channel.signal for channel in CHANNELS)
    requires = reads[:2]

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._grid = Grid(CHANNELS, STEP)
        self._begins: float | None = None  # [s], first stamp of a signal that only active steering has
        self._next: int | None = None
        self._pinion: Pinion | None = None
        self._pinion_heard: int | None = None  # cell from which on
        self._state = new_state()
        self._calibration: Calibration | None = None
        self._servo: Watching | None = None
        self._pinion_watching: Watching | None = None
        self._pinion_until = 0  # cell until which its offset is not learnt
        self._accusation = Accusation(FALSE_ALARMS_PER_HOUR)

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """As `Calibration.as_json` gives it."""
        found = Calibration.from_json(document)
        self._calibration = found
        self._servo = Watching(found.servo_watch)
        if found.ratios is not None and found.pinion_watch is not None:
            self._pinion, self._pinion_watching = Pinion(found.ratios), Watching(found.pinion_watch)

    def calibration(self) -> dict[str, Any] | None:
        """What it was given: nothing is learnt while it watches."""
        return None if self._calibration is None else self._calibration.as_json()

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        given = self._of_active_steering(samples)
        if self._begins is None:
            return Outputs()
        flags = self._grid.add(given)
        cells, more = self._grid.close(until)
        flags += more
        rows: Rows = {}
        alarms: list[Alarm] = []
        for first, values in self._stretches(cells):
            told = self._watch(first, values, rows)
            new, ended = self._accusation.take(told, first + len(values), self._pinion_heard)
            alarms += new
            flags += ended
        estimates = {name: _joined(name, parts) for name, parts in rows.items()}
        return Outputs({n: e for n, e in estimates.items() if len(e.time)}, tuple(alarms), tuple(sorted(flags)))

    def _of_active_steering(self, samples: Mapping[str, Signal]) -> dict[str, Signal]:
        """The samples from the first one on that only active steering has."""
        given = {name: samples[name] for name in self.reads if name in samples}
        if self._begins is None:
            stamps = [
                float(signal.time[0]) for name, signal in given.items() if name != self.reads[WHEEL] and len(signal)
            ]
            if not stamps:
                return {}
            self._begins = min(stamps)
            if (wheel := given.get(self.reads[WHEEL])) is not None:
                given[self.reads[WHEEL]] = wheel.between(self._begins, np.inf)
        return given

    def _stretches(self, cells: Cells) -> list[tuple[int, Array]]:
        """(first cell, values (n, channels)) without holes but NaN; a new one after a silence."""
        index, found = cells.index, []
        if not len(index):
            return []
        start = index[0] if self._next is None else self._next
        cuts = np.flatnonzero(np.diff(np.concatenate([[start - 1], index])) > GAP)
        bounds = [*([0] if 0 not in cuts else []), *cuts.tolist(), len(index)]
        for begin, end in pairwise(bounds):
            first = int(index[begin]) if begin in cuts or self._next is None else self._next
            if begin in cuts:
                found.append((first, np.full((0, len(CHANNELS)), np.nan)))  # marks the silence
            values = np.full((int(index[end - 1]) + 1 - first, len(CHANNELS)), np.nan)
            values[index[begin:end] - first] = cells.value[begin:end]
            found.append((first, values))
            self._next = first + len(values)
        return found

    def _watch(self, first: int, values: Array, rows: Rows) -> list[tuple[int, Told]]:
        if not len(values):
            self._silence()
            return []
        cell = first + np.arange(len(values))
        demand, angle, pinion, wheel = (np.ascontiguousarray(values[:, i]) for i in range(4))
        residual = angle - demand
        _keep(rows, "position_residual", cell, residual, np.full(len(cell), RESOLUTION))
        calibration, told = self._calibration, list[tuple[int, Told]]()
        if calibration is None or self._servo is None:
            return told
        model = np.empty((len(cell), SAID))
        simulate(calibration.servo, self._state, demand, model)
        said = self._servo.take(first, angle - model[:, 0], model[:, CAUSES])
        _keep_said(rows, "servo", cell, angle - model[:, 0], said)
        told += [(SERVO, alarm) for alarm in said.alarms]
        told += self._watch_pinion(first, pinion, wheel, angle, rows)
        return sorted(told, key=lambda pair: (pair[1].cell, pair[0], pair[1].kind))

    def _watch_pinion(
        self, first: int, pinion: Array, wheel: Array, angle: Array, rows: Rows
    ) -> list[tuple[int, Told]]:
        check, watching, told = self._pinion, self._pinion_watching, list[tuple[int, Told]]()
        if check is None or watching is None:
            return told
        raw, causes = check.raw(pinion, wheel, angle)
        if self._pinion_heard is None and np.isfinite(raw).any():
            self._pinion_heard = first + int(np.argmax(np.isfinite(raw)))
        last, begin = first + len(raw), first
        while begin < last:
            end = min((begin // BLOCK + 1) * BLOCK, last)
            span = slice(begin - first, end - first)
            error, unsure = check.piece(raw[span])
            said = watching.take(begin, error, causes[span], unsure)
            _keep_said(rows, "pinion", np.arange(begin, end), error, said)
            if said.alarms:
                self._pinion_until = said.alarms[-1].cell + BACK
                told += [(PINION, alarm) for alarm in said.alarms]
            check.learn(raw[span], causes[span], end % BLOCK == 0, self._pinion_until >= end)
            begin = end
        return told

    def _silence(self) -> None:
        self._state = new_state()
        if self._pinion is not None:
            self._pinion.forget()
        for watching in (self._servo, self._pinion_watching):
            if watching is not None:
                watching.restart()


def _keep_said(rows: Rows, name: str, cell: NDArray[np.int64], error: Array, said: Said) -> None:
    _keep(rows, f"{name}_error", cell, error, said.s)
    _keep(rows, f"{name}_evidence", cell, np.where(np.isfinite(error), said.evidence, np.nan), np.zeros(len(cell)))


def _keep(rows: Rows, name: str, cell: NDArray[np.int64], value: Array, std: Array) -> None:
    kept = (cell % SAY == SAY - 1) & np.isfinite(value) & np.isfinite(std)
    rows.setdefault(name, []).append(((cell[kept] + 0.5) * STEP, value[kept], std[kept]))


def _joined(name: str, parts: list[tuple[Array, Array, Array]]) -> Estimate:
    time, value, std = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Estimate(time, value, std, "" if name.endswith("evidence") else "rad")
