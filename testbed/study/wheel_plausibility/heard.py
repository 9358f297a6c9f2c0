"""A case as the estimator hears it: cells of 20 ms, and the truth to judge them by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.grid import LATENCY, Grid
from estimators.wheel_plausibility.kernel import STEP
from estimators.wheel_plausibility.wheel_plausibility import CHANNELS, WheelPlausibility
from testbed.scenario import Scenario
from testbed.study.sensed import sensed


@dataclass(frozen=True)
class Heard:
    """index (n,), end [s] of each cell, value (n, channels) as `kernel.follow` takes them; truth: forward speed of the
    car's middle line and speed over ground [m/s], yaw rate [rad/s], (n,)."""

    index: NDArray[np.int64]
    end: NDArray[np.float64]
    value: NDArray[np.float64]
    forward: NDArray[np.float64]
    speed: NDArray[np.float64]
    yaw_rate: NDArray[np.float64]


def heard(asked: Scenario) -> Heard:
    """The whole drive. ValueError where the car cannot drive it."""
    drive = sensed(asked, WheelPlausibility.reads)
    grid, parts = Grid(CHANNELS, STEP), []
    for number, stretch in enumerate(drive.stretches):
        grid.add(stretch)
        parts.append(grid.close(number + 1.0 + LATENCY)[0])
    centre = np.concatenate([cells.centre for cells in parts])
    truth = [np.interp(centre, drive.time, column) for column in (drive.forward, drive.speed, drive.yaw_rate)]
    index = np.concatenate([cells.index for cells in parts])
    return Heard(index, centre + 0.5 * STEP, np.concatenate([cells.value for cells in parts]), *truth)
