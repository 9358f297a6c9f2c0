"""What the indirect tyre-pressure monitoring costs: processor time of its estimators over the time driven.

`itpms` (calibrated, so that all three of its monitors run), `vibration` and `wheel_radius` side by side in one `Bank`
on one recorded stream of sensors, second by second as in a drive, in one thread's processor time; the fastest
repetition counts. The stream is of class C at 80 km/h and is sensed before the clock starts.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

import numpy as np

from estimators.drive_log import Signal
from estimators.itpms.itpms import Itpms
from estimators.itpms.learning import BEND_STD, LEVEL_STD, SLIP, SLIP_STD
from estimators.itpms.mode_nodes import MODE_NODES, NODES
from estimators.itpms.speed_bins import Calibration
from estimators.runner import Bank
from testbed.notes import known_car
from testbed.scenario import Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of, needed
from testbed.simulation import Simulation

MEMBERS = ("itpms", "vibration", "wheel_radius")


def itpms_cpu_share(duration: float, repetitions: int) -> float:
    """Share of one core in real time [-]. duration: [s] of the drive."""
    simulation = Simulation(Scenario(duration=duration))
    car = known_car(simulation.vehicle, simulation.tyre, simulation.scenario)
    suite = SensorSuite(needed(sensor_settings({}), Bank(MEMBERS, car).reads), 0, simulation)
    stream = [suite.advance(motion_of(stretch, simulation.scenario.step)) for stretch in simulation.stretches()]
    learnt = {Itpms.name: nominal().document()}
    return min(_cost(Bank(MEMBERS, car, learnt), stream) for _ in range(repetitions + 1)) / duration


def nominal() -> Calibration:
    """What is known of a car that was never driven."""
    frequencies = [mode.everywhere(mode.expected()) for mode in MODE_NODES]
    level = np.vstack([*frequencies, np.zeros((3, len(NODES)))])
    nothing = tuple(np.zeros((4, mode.count, mode.count)) for mode in MODE_NODES)
    std = np.full((3, len(NODES)), LEVEL_STD)
    return Calibration(level, nothing, std, (SLIP, SLIP_STD), np.zeros(2), np.full(2, BEND_STD))


def _cost(bank: Bank, stream: Sequence[Mapping[str, Signal]]) -> float:
    """Processor time [s] of a bank on a stream."""
    begun = time.thread_time()
    for second, samples in enumerate(stream, 1):
        bank.update(samples, float(second))
    return time.thread_time() - begun
