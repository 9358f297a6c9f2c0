"""The least error when both axles of a side roll over one road: `estimators.axles.bound`, with the study's prior.

The coherency between the axles is what the estimator measured in that drive: a bound for this road and car, not for
one on which the rear wheel repeats the front's exactly.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.axles.bound import SharedRoad, difference_std, pressure_std
from estimators.axles.calibration import from_document
from estimators.car import GRAVITY
from estimators.drive_log import WHEELS
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.tyre_law import TyreLaw
from models.identified import identified
from testbed.study.vertical_pressure.listening import Heard
from testbed.study.vertical_pressure.told import EXPECTED_STD

SIDES = {"left": (0, 2), "right": (1, 3)}  # places of the front and the rear wheel
MOST = 0.9999  # of the coherency


def bounds_of_axles(
    heard: Heard, spectrum: float, times: Sequence[float]
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Standard deviations at each time [s]: pressures [Pa], (times, 4); ln k_front - ln k_rear, (times, 2). None where
    no coherence was measured. spectrum: G at 1 rad/m [m^3/rad]."""
    car, speed = heard.told[0].car, heard.scenario.speed
    law, axles = TyreLaw.of(car), from_document(identified()["axles"]).axles
    pressures, differences = np.empty((len(times), len(WHEELS))), np.empty((len(times), len(SIDES)))
    for s, (side, wheels) in enumerate(SIDES.items()):
        measured = heard.said[0].get(f"est/axles/{side}/coherence")
        if measured is None:
            return None
        loads = [sum(quarter_masses(car, WHEELS[w])) * GRAVITY for w in wheels]
        front, rear = (
            float(law.stiffness_at(heard.pressure[0, w], speed, load)) for w, load in zip(wheels, loads, strict=True)
        )
        road = SharedRoad(axles, (front, rear), spectrum, speed, min(float(measured.value[-1]), MOST))
        slopes = [float(law.pressure_std(k, speed, load)) for k, load in zip((front, rear), loads, strict=True)]
        for t, seconds in enumerate(times):
            for i, w in enumerate(wheels):
                pressures[t, w] = pressure_std(road, seconds, slopes[i], EXPECTED_STD)[i]
            differences[t, s] = difference_std(road, seconds)
    return pressures, differences
