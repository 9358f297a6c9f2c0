"""A drive as its sensors tell it, second by second, with the truth of its motion: for studies that branch off it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import Signal
from testbed.scenario import Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of
from testbed.simulation import Simulation
from testbed.truth import attitude

Stretch = Mapping[str, Signal]
EVERY = 0.05  # s between two rows of the truth


@dataclass(frozen=True)
class SensedDrive:
    """stretches: what the sensors said, a second each, with the signals asked for; of the truth every EVERY: time [s],
    speed over ground [m/s], forward speed along the car's x axis [m/s], yaw rate [rad/s], (n,)."""

    stretches: list[Stretch]
    time: NDArray[np.float64]
    speed: NDArray[np.float64]
    forward: NDArray[np.float64]
    yaw_rate: NDArray[np.float64]


def sensed(asked: Scenario, signals: Sequence[str]) -> SensedDrive:
    """The whole drive. ValueError where it cannot be driven to its end."""
    simulation = Simulation(asked)
    suite = SensorSuite(
        sensor_settings(asked.sensors, asked.active_steering), asked.seed, simulation, car_seed=asked.car_seed
    )
    every = round(EVERY / asked.step)
    stretches: list[Stretch] = []
    rows: list[NDArray[np.float64]] = []
    for stretch in simulation.stretches():
        said = suite.advance(motion_of(stretch, asked.step, asked.active_steering))
        stretches.append({name: said[name] for name in signals})
        kept = slice(every - 1, None, every)
        velocity, angles = stretch["velocity"][kept], attitude(stretch["quaternion"][kept])
        ahead = np.stack([np.cos(angles[:, 2]), np.sin(angles[:, 2])], axis=1)
        rows.append(
            np.column_stack([
                stretch["time"][kept], np.linalg.norm(velocity, axis=1), (velocity[:, :2] * ahead).sum(axis=1),
                stretch["gyro"][kept, 2],
            ])
        )  # fmt: skip
    return SensedDrive(stretches, *np.concatenate(rows).T)
