"""One trial: a fault begins on a drive, and what the monitors say of it.

delay [s]: to the first accusation of the faulty sensor, alarm or flag; `first`: who is accused first, and by whom;
wrong: others that alarms accuse within the watched time; low: tyres called low. A monitor that said the same on the
sound drive within that time is not counted."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from estimators.accusation import LOW, Accusation, of_alarm, of_flag, opposite, same, sensor_of
from estimators.drive_log import WHEELS
from estimators.effective_steering import given, inputs
from estimators.estimator import Estimator, Outputs
from estimators.faults import Injector
from estimators.faults.injector import touched
from testbed.study.fault_matrix.faults import Cell
from testbed.study.sensed import Stretch


def said_by(monitor: str, outputs: Outputs) -> list[Accusation]:
    """Every accusation in what a monitor said."""
    return [
        *(accusation for alarm in outputs.alarms for accusation in of_alarm(monitor, alarm)),
        *(accusation for flag in outputs.flags for accusation in of_flag(monitor, flag)),
    ]


def trial(
    monitors: Mapping[str, Estimator], stretches: Sequence[Stretch], first: int, start: float, cell: Cell,
    sound: Sequence[Accusation], random: np.random.Generator, seed: int,
) -> dict[str, Any]:  # fmt: skip
    """The cell's row. monitors: after stretch first - 1; start [s] lies in stretch `first`, of a second each; sound:
    accusations of the drive without a fault."""
    wheel, sign = WHEELS[int(random.integers(4))], "-" if random.random() < 0.5 else ""
    injector = Injector([cell.text(wheel, sign, start)], seed)
    changed = set(touched(injector.faults[0]))
    faulty = {cell.sensor.name.format(wheel=wheel)} | {name for s in changed if (name := sensor_of(s))}
    if cell.kind == "swap":
        faulty.add(cell.sensor.name.format(wheel=opposite(wheel)))
    listening = {name: copy.deepcopy(m) for name, m in monitors.items() if changed & inputs(m.reads, m.car)}
    injector.update(stretches[first - 1], float(first))
    said: list[Accusation] = []
    for number in range(first, min(first + cell.sensor.watch + 1, len(stretches))):
        wrong = injector.update(stretches[number], number + 1.0)
        for name, monitor in listening.items():
            said += said_by(name, monitor.update(given(wrong, monitor.reads, monitor.car), number + 1.0))
    known = {(a.accused, a.by) for a in sound if first <= a.time <= first + cell.sensor.watch + 1}
    told = sorted(a for a in said if start <= a.time <= start + cell.sensor.watch and (a.accused, a.by) not in known)
    right = [a for a in told if same(a.accused, faulty)]
    alarms = [a for a in told if not a.flag]
    return {
        "cell": cell.name,
        "delay": right[0].time - start if right else None,
        "by": sorted({a.by + (" (flag)" if a.flag else "") for a in right[:1]}),
        "first": [told[0].accused, told[0].by] if told else [],
        "isolated": bool(told) and same(told[0].accused, faulty),
        "told": told[0].time - start if told else None,
        "wrong": sorted({(a.accused, a.by) for a in alarms if not same(a.accused, faulty) and LOW not in a.accused}),
        "low": sorted({(a.accused, a.by) for a in alarms if LOW in a.accused}),
    }
