"""A repetition: one drive and every cell of the matrix once on it, or one physical event.

Row of a drive: hours, false: accusations by alarms on the sound drive; trials. Row of an event: as of `events.run`."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from estimators.accusation import Accusation
from estimators.effective_steering import given
from testbed.scenario import Scenario
from testbed.study.fault_matrix import events
from testbed.study.fault_matrix.drives import heard
from testbed.study.fault_matrix.faults import LONG, cells
from testbed.study.fault_matrix.trial import said_by, trial

WARM_UP, EVERY = 24, 4  # s from the start to the first place at which faults begin, and between two
SMALL_WARM_UP, SMALL_SHARE = 13, 24  # of the cells every so manieth


def run(task: dict[str, Any]) -> dict[str, Any]:
    """See the module. ValueError where the car cannot drive it."""
    asked = Scenario.from_notes(task["scenario"])
    if task["event"]:
        return events.run(next(e for e in events.EVENTS if e.name == task["event"]), asked)
    drive = heard(asked)
    seconds = len(drive.stretches)
    places = [SMALL_WARM_UP] if task["small"] else list(range(WARM_UP, seconds - LONG, EVERY))
    monitors, random = drive.monitors(), np.random.default_rng(asked.seed + 1)
    waiting = list(cells())[:: SMALL_SHARE if task["small"] else 1]
    due = {place: [waiting[i] for i in range(len(waiting)) if i % len(places) == k] for k, place in enumerate(places)}
    sound, kept = list[Accusation](), {}
    for number, stretch in enumerate(drive.stretches):
        if number in due:
            kept[number] = {name: copy.deepcopy(monitor) for name, monitor in monitors.items()}
        for name, monitor in monitors.items():
            sound += said_by(name, monitor.update(given(stretch, monitor.reads, drive.car), number + 1.0))
    trials = [
        trial(kept[place], drive.stretches, place, place + float(random.random()), cell, sound, random, asked.seed)
        for place, chosen in due.items() for cell in chosen
    ]  # fmt: skip
    false = [{"time": a.time, "accused": a.accused, "by": a.by} for a in sound if not a.flag]
    return {"manoeuvre": asked.manoeuvre, "hours": seconds / 3600.0, "false": false, "trials": trials}
