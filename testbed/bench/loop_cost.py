"""What the simulation loop costs beside MuJoCo itself: wall time of a loop step / of a bare `mj_step`.

Loop: `Simulation.stretches` at 1 kHz as a drive has it: tyres, suspension, driver, inflation, trace, poses, the road
window following the car. Bare: `mj_step` of the same model from the same running state, called from compiled code too,
with the forces that the loop last wrote (`xfrc_applied`, `qfrc_applied`) held. Both alternate every second of the drive
and the median of their ratios counts, so that what else the machine does falls on both alike.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from dataclasses import dataclass

import mujoco

from estimators.compiled import compiled
from testbed.native import address, call
from testbed.scenario import Scenario
from testbed.simulation import STRETCH, Simulation

HELD = 100  # bare steps from one state: the forces are held, so the car must not go far from it


@compiled
def bare_steps(step, model, data, count):
    """`count` times mj_step(model, data), all by address."""
    for _ in range(count):
        call(step, model, data)


def bare_drive(simulation: Simulation, duration: float) -> None:
    """The bare steps of a drive of `duration` [s], all close to the simulation's present state."""
    data = mujoco.MjData(simulation.model)
    for _ in range(round(duration / STRETCH)):
        _bare_seconds(simulation, data, address("mj_step"), round(STRETCH / simulation.scenario.step))


@dataclass(frozen=True)
class LoopCost:
    """Medians over the repetitions: wall time [s] of a loop step and of a bare one, and of their ratio [-]."""

    loop_step: float
    bare_step: float
    ratio: float


def _bare_seconds(simulation: Simulation, data: mujoco.MjData, function: int, steps: int) -> float:
    """Wall time [s] of bare steps, begun anew from the simulation's state every HELD steps."""
    model, seconds = simulation.model, 0.0
    for _ in range(steps // HELD):
        mujoco.mj_copyData(data, model, simulation.data)
        begun = time.perf_counter()
        bare_steps(function, model._address, data._address, HELD)
        seconds += time.perf_counter() - begun
    return seconds


def _pairs(simulation: Simulation) -> Iterator[tuple[float, float]]:
    """Wall times [s] per step, loop and bare, second by second of the drive."""
    data = mujoco.MjData(simulation.model)
    function, steps = address("mj_step"), round(STRETCH / simulation.scenario.step)
    stretches = simulation.stretches()
    while True:
        begun = time.perf_counter()
        stretch = next(stretches, None)
        if stretch is None or len(stretch.rows) < steps:
            return
        loop = time.perf_counter() - begun
        yield loop / steps, _bare_seconds(simulation, data, function, steps) / steps


def loop_cost(repetitions: int) -> LoopCost:
    """repetitions: seconds of drive measured; one more goes before them unmeasured."""
    _, *pairs = _pairs(Simulation(Scenario(duration=(repetitions + 1) * STRETCH)))
    loop, bare = zip(*pairs, strict=True)
    return LoopCost(statistics.median(loop), statistics.median(bare), statistics.median(a / b for a, b in pairs))
