"""Physical events that look like faults: a skidding wheel, two wheels on ice, a driven wheel that spins, a flat tyre, a
kerb. No sensor is faulty; who is accused all the same?

Right is to name a wheel that in truth turns otherwise than it rolls (the signals do not tell a slip from a sensor that
lies, so naming its speed is right), and the flat tyre. Everything else is a false accusation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from estimators.accusation import LOW, Accusation
from estimators.effective_steering import given
from testbed.brake_pull import BrakePull
from testbed.scenario import Scenario
from testbed.study.fault_matrix.drives import heard
from testbed.study.fault_matrix.trial import said_by
from testbed.study.study import run_seed
from testbed.tyre.inflation import PressureSet

SLIPS = 1.0  # m/s between a wheel's rolling and the car's speed, from which on it is off
DURATION, BEGINS = 32.0, 20.0  # s
SMALL_DURATION = 6.0
KMH = 1.0 / 3.6
ROADS = ("A", "B", "C")
PURPOSE = 7  # of the seeds
RIGHT = "right"


@dataclass(frozen=True)
class Event:
    """name: of its row; fields: of the scenario; flat: the tyre that loses its air."""

    name: str
    fields: dict[str, Any] = field(default_factory=dict)
    flat: str = ""


EVENTS = (
    Event("wheel skids", {"speed": 22.0, "brake_pulls": {"rl": BrakePull(3000.0, BEGINS, BEGINS + 0.8)}}),
    Event("braking, one side on ice", {"manoeuvre": "brake", "speed": 22.0, "friction": "0.9/0.1"}),
    Event("driven wheel spins", {"manoeuvre": "stops", "speed": 50.0 * KMH, "friction": "0.9/0.1", "road": "flat"}),
    Event("tyre goes flat", {"speed": 22.0, "pressure_sets": {"rl": PressureSet(0.0, BEGINS, 2.0)}}, "rl"),
    Event("kerb", {"speed": 20.0 * KMH, "road": "flat",
                   "obstacles": ("cleat@120:height=70,length=9000,side=right",)}),
)  # fmt: skip


def scenario(event: Event, seed: int, number: int, small: bool) -> Scenario:
    """Of repetition `number`."""
    own = run_seed(seed, number, PURPOSE + EVENTS.index(event))
    random = np.random.default_rng(own)
    drawn: dict[str, Any] = {"road": str(random.choice(ROADS)), "payload": float(random.uniform(0.0, 300.0))}
    return Scenario(duration=SMALL_DURATION if small else DURATION, seed=own, **drawn | event.fields)


def run(event: Event, asked: Scenario) -> dict[str, Any]:
    """accused: [who, by whom, `RIGHT` or ""] of every alarm, each pair once, in the order in which they came."""
    drive = heard(asked)
    monitors, said = drive.monitors(), list[Accusation]()
    for number, stretch in enumerate(drive.stretches):
        for name, monitor in monitors.items():
            outputs = monitor.update(given(stretch, monitor.reads, drive.car), number + 1.0)
            said += [a for a in said_by(name, outputs) if not a.flag]
    right = {f"wheel/{wheel}" for wheel, off in drive.off.items() if off > SLIPS}
    right |= {LOW + event.flat, f"wheel/{event.flat}"} if event.flat else set()
    once = dict.fromkeys((a.accused, a.by) for a in sorted(said))
    return {"event": event.name, "accused": [[who, by, RIGHT if who in right else ""] for who, by in once]}
