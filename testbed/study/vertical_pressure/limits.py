"""The least error of the pressure that any method could have in a drive: `quarter_car.bound`, in van Trees' form.

Road level unknown, both its slopes too but for their prior (`quarter_car.roughness`), prior of the pressure that of the
study (uniform, counted by its std), the identified quarter car of each axle, both accelerometers to 50 Hz.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.car import AXLES, GRAVITY
from estimators.drive_log import WHEELS
from estimators.quarter_car.bound import Setting, pressure_std
from estimators.quarter_car.quarter_car import QuarterCar, quarter_masses
from estimators.quarter_car.roughness import WAVINESS_STD
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.vertical_pressure.corner import from_document
from models.identified import identified
from testbed.study.vertical_pressure.listening import Heard
from testbed.study.vertical_pressure.told import EXPECTED_STD


def linear_quarter(axle: str) -> QuarterCar:
    """What is identified of an axle, without its belt."""
    quarter = from_document(identified()["vertical_pressure"])[axle].quarter
    unsprung = quarter.unsprung_mass + quarter.belt_mass
    return QuarterCar(quarter.sprung_mass, unsprung, quarter.spring_rate, 0.0, quarter.damping, 0.0)


def bounds(heard: Heard, spectrum: float, times: Sequence[float]) -> NDArray[np.float64]:
    """Standard deviation [Pa] at each time [s] for each wheel, (times, 4); spectrum: G at 1 rad/m [m^3/rad]."""
    car, speed = heard.told[0].car, heard.scenario.speed
    law = TyreLaw.of(car)
    found = np.empty((len(times), len(WHEELS)))
    for w, wheel in enumerate(WHEELS):
        load = sum(quarter_masses(car, wheel)) * GRAVITY
        stiffness = float(law.stiffness_at(heard.pressure[0, w], speed, load))
        setting = Setting(linear_quarter(AXLES[w // 2]), stiffness, spectrum, speed)
        slope = float(law.pressure_std(stiffness, speed, load))
        for t, seconds in enumerate(times):
            found[t, w] = pressure_std(
                setting, seconds, slope, waviness_std=WAVINESS_STD, pressure_prior_std=EXPECTED_STD
            )
    return found
