"""A drive as the monitors hear it: cells of 10 ms of the four steering angles, and what the estimator says."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.estimator import Alarm
from estimators.grid import LATENCY, Grid
from estimators.steering_actuator.steering_actuator import CHANNELS, STEP, SteeringActuator
from testbed.scenario import Scenario
from testbed.study.sensed import sensed


class Heard(NamedTuple):
    """demand, angle (of the motor), pinion, wheel: [rad], (n,) each, from the beginning on, NaN where missing; alarms
    of the estimator, if one listened."""

    demand: NDArray[np.float64]
    angle: NDArray[np.float64]
    pinion: NDArray[np.float64]
    wheel: NDArray[np.float64]
    alarms: tuple[Alarm, ...] = ()

    @property
    def error_deg(self) -> NDArray[np.float64]:
        """delta_M - delta_Md (1.4) [deg], (n,)."""
        return np.degrees(self.angle - self.demand)


def heard(asked: Scenario, listener: SteeringActuator | None = None) -> Heard:
    """The whole drive. ValueError where the car cannot drive it."""
    drive = sensed(asked, SteeringActuator.reads)
    grid, parts, alarms = Grid(CHANNELS, STEP), [], list[Alarm]()
    for number, stretch in enumerate(drive.stretches):
        grid.add(stretch)
        parts.append(grid.close(number + 1.0 + LATENCY)[0])
        if listener is not None:
            alarms += listener.update(stretch, number + 1.0).alarms
    index = np.concatenate([cells.index for cells in parts])
    values = np.full((int(index[-1]) + 1, len(CHANNELS)), np.nan)
    values[index] = np.concatenate([cells.value for cells in parts])
    demand, angle, pinion, wheel = (np.ascontiguousarray(column) for column in values.T)
    return Heard(demand, angle, pinion, wheel, tuple(alarms))
