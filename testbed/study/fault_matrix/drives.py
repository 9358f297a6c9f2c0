"""The drives on which the faults begin: ordinary driving as in `sensor-faults`, with all sensors and all monitors.

A drive is heard twice: once sound, to its end, by all monitors; and from each fault's beginning on by copies of those
monitors that hear a signal that the fault changes (the others hear nothing new)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from estimators.car import Car
from estimators.drive_log import WHEELS
from estimators.estimator import Estimator
from estimators.registry import registered
from testbed.notes import drive_notes
from testbed.scenario import Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of, needed
from testbed.simulation import Simulation
from testbed.study.sensed import Stretch
from testbed.truth import attitude

QUIET = ("vibration",)  # tells frequencies and has no alarm


@dataclass(frozen=True)
class Heard:
    """stretches: a second each; off: how far each wheel's rolling is off the car's speed at the most [m/s]; car and
    calibrations: what the estimators are told before."""

    stretches: Sequence[Stretch]
    off: Mapping[str, float]
    car: Car
    calibrations: Mapping[str, Mapping[str, object]]

    def monitors(self) -> dict[str, Estimator]:
        """All of the project, at the start of this drive."""
        found = {name: kind(self.car) for name, kind in registered().items() if name not in QUIET}
        for name, monitor in found.items():
            if name in self.calibrations:
                monitor.use_calibration(self.calibrations[name])
        return found


def heard(asked: Scenario) -> Heard:
    """The whole drive. ValueError where it cannot be driven to its end."""
    simulation = Simulation(asked)
    notes = drive_notes(simulation, None, None)
    reads = {signal for kind in registered().values() for signal in kind.reads}
    settings = needed(sensor_settings(asked.sensors, asked.active_steering), reads | {"engine/torque"})
    suite = SensorSuite(settings, asked.seed, simulation, car_seed=asked.car_seed)
    stretches, off = [], np.zeros(len(WHEELS))
    for stretch in simulation.stretches():
        stretches.append(suite.advance(motion_of(stretch, asked.step, asked.active_steering)))
        yaw = attitude(stretch["quaternion"])[:, 2]
        forward = stretch["velocity"][:, 0] * np.cos(yaw) + stretch["velocity"][:, 1] * np.sin(yaw)
        rolling = stretch["rim_speed"] * simulation.nominal_radius
        off = np.maximum(off, np.abs(rolling - forward[:, None]).max(axis=0))
    return Heard(stretches, dict(zip(WHEELS, off.tolist(), strict=True)), Car.from_notes(notes), notes["calibrations"])
