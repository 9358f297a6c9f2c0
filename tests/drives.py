"""Short drives for the tests: the trace of a scenario, all rows together."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS
from testbed.scenario import Scenario
from testbed.simulation import Simulation
from testbed.trace import column


class Driven:
    """A finished drive: `driven["load"]` is a column of its trace, `simulation` its end state."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self.rows = np.concatenate([stretch.rows for stretch in simulation.stretches()])

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return column(self.rows, name)


def drive(vehicle: Any = None, tyre: Any = None, **fields: Any) -> Driven:
    """Drives a scenario of these fields (SI)."""
    return Driven(Simulation(Scenario(**fields), vehicle=vehicle, tyre=tyre))


def settled(vehicle: Any = None, tyre: Any = None, **fields: Any) -> Simulation:
    """A car on a flat road, settled at its speed, with its clock at zero."""
    return Simulation(Scenario(**{"road": "flat", "duration": 1.0, **fields}), vehicle=vehicle, tyre=tyre)


def everywhere(pressure: float) -> dict[str, float]:
    """The same pressure [Pa] in all four tyres."""
    return dict.fromkeys(WHEELS, pressure)
