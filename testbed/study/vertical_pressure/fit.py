"""Figure 5 and Table 3: how well the quarter cars that were identified by class follow the multibody car.

One drive of its own at 230 and 130 kPa, 60 km/h, class B, as in the paper: hub acceleration of the front left wheel,
as it is, as the identified quarter car has it, and as the paper's own Table 3 would.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from estimators.quarter_car.quarter_car import QuarterCar, published_quarter_car, quarter_masses, ride
from models.identified import identified_by_class
from testbed.identify.published import known_case
from testbed.scenario import Scenario
from testbed.study.vertical_pressure.listening import known
from testbed.study.vertical_pressure.told import QUARTER_FIELDS

SHOWN = (3.0, 5.0)  # s of the drive
KMH, ROAD, PRESSURES = 60.0, "B", (230e3, 130e3)


def fit(seed: int) -> dict[str, Any]:
    """JSON values, by pressure in kPa."""
    car = known(Scenario(duration=1.0))
    identified = QuarterCar(
        *quarter_masses(car, "fl"), **{name: identified_by_class()["front"][ROAD][name] for name in QUARTER_FIELDS}
    )
    quarters = {"identified": identified, "table_3": published_quarter_car(car, "fl", ROAD)}
    found = {}
    for pressure in PRESSURES:
        case = known_case(ROAD, KMH, pressure, seed)["front"]
        part = slice(round(SHOWN[0] / case.step), round(SHOWN[1] / case.step), 2)
        entry: dict[str, Any] = {"time_s": (case.step * np.arange(len(case.measured))[part]).tolist()}
        entry["car"] = np.round(case.measured[part, 1], 3).tolist()
        for name, quarter in quarters.items():
            _, felt = ride(quarter, case.road, case.tyre_stiffness, case.step)
            entry[name] = np.round(felt[part, 1], 3).tolist()
        found[f"{1e-3 * pressure:g}"] = entry
    return found
