"""Faults of the motor's angle sensor as its own control hears them, millisecond by millisecond.

The same faults, of the same random numbers, as the log's sensor has them; there is one sensor. What changes a number is
an affine map of it, read off its own definition at 0 and 1; where it says its last value, or nothing, the control
goes on with what it had.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from estimators.faults import parse_fault
from estimators.faults.chance import Chance
from estimators.faults.kind import LossFault, ValueFault
from estimators.faults.kinds.stuck import Stuck
from testbed.steering.active_steering import LoopFault
from testbed.steering.servo import PERIOD

SENSOR = "steering/motor_angle"


def loop_fault(faults: Iterable[str], seed: int, duration: float) -> LoopFault:
    """faults: texts, as of a drive, those of other sensors left out; seed: of the drive; duration [s]. ValueError in
    one line for a kind that the control cannot be fed with."""
    time = np.arange(round(duration / PERIOD) + 1, dtype=np.float64) * PERIOD
    scale, offset, hold = np.ones(len(time)), np.zeros(len(time)), np.zeros(len(time))
    for text in faults:
        fault = parse_fault(text)
        if fault.target.name != SENSOR:
            continue
        kind = fault.kind(fault.numbers, fault.start, Chance(seed, f"{SENSOR} {fault.kind.name}"), 1.0)
        inside = np.flatnonzero((time >= fault.start) & (time < fault.end))
        at = time[inside]
        if isinstance(kind, Stuck):
            hold[inside] = 1.0
        elif isinstance(kind, ValueFault):
            base, unit = (kind.faulty(at, np.full((len(at), 1), value))[:, 0] for value in (0.0, 1.0))
            scale[inside] *= unit - base
            offset[inside] = base + (unit - base) * offset[inside]
        elif isinstance(kind, LossFault):
            hold[inside[kind.lost(at)]] = 1.0
        else:
            raise ValueError(f"fault {text!r}: a {fault.kind.name} cannot act inside the loop; valid: another kind")
    return LoopFault(scale, offset, hold)
