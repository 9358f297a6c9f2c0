"""What a road whose spectrum does not fall with slope -2 does to the stiffness: ISO 8608's assumption, and its price.

A road of waviness w has G(Omega) = G Omega^-w. A filter that believes in w = 2 settles where its spectrum is nearest to
the true one in the Kullback-Leibler sense (White, Econometrica 50, 1982),

    min over ln k, ln G of  integral of  ln M + S / M  over f,

M, S: the model's and the true spectrum of the hub (`quarter_car.response`). A steeper road has less at the wheel's hop
against what it has below, which looks like a softer tyre. The bound where w is not known: its derivative joins those of
ln k and ln G in `quarter_car.bound`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from estimators.car import GRAVITY
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.response import measured_spectrum
from estimators.quarter_car.road_shape import class_spectrum
from estimators.quarter_car.tyre_law import TyreLaw
from testbed.roads.profile import read_profile
from testbed.roads.spectrum import octave_means, periodogram
from testbed.scenario import Scenario
from testbed.study.study import StudyRow
from testbed.study.vertical_pressure.limits import linear_quarter
from testbed.study.vertical_pressure.listening import known
from testbed.study.vertical_pressure.told import EXPECTED, EXPECTED_STD

WAVINESSES = (1.8, 2.2, 2.5, 3.0)
SPEED, ROAD = 60.0 / 3.6, "B"
BAND = (0.5, 28.0)  # Hz that the bank hears
NOISE = 2.0 * 0.5**2 / 1000.0  # (m/s^2)^2/Hz
FITTED = (0.08, 1.6)  # cycle/m, of which a road's waviness is told: 1.3 to 27 Hz at 60 km/h
_POINTS, _STEP = 1000, 1e-4


def spectrum(
    log_stiffness: float, log_level: float, waviness: float, frequency: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """Of body and hub of the front left wheel, (n, 2, 2) [(m/s^2)^2/Hz]."""
    omega = 2.0 * np.pi * frequency / SPEED
    level = np.exp(log_level) * omega ** (2.0 - waviness)
    return measured_spectrum(linear_quarter("front"), float(np.exp(log_stiffness)), level, SPEED, NOISE, frequency)


def settled(log_stiffness: float, log_level: float, waviness: float) -> float:
    """ln k_t that a believer in slope -2 ends at."""
    f = np.linspace(*BAND, _POINTS)
    true = spectrum(log_stiffness, log_level, waviness, f)[:, 1, 1].real

    def distance(place: NDArray[np.float64]) -> float:
        model = spectrum(float(place[0]), float(place[1]), 2.0, f)[:, 1, 1].real
        return float(np.mean(np.log(model) + true / model))

    found = minimize(distance, [log_stiffness, log_level], method="Nelder-Mead", options={"xatol": 1e-5, "fatol": 1e-9})
    return float(found.x[0])


def unknown_waviness_std(log_stiffness: float, log_level: float, seconds: float, prior_std: float) -> float:
    """Least std of ln k_t with level and waviness unknown, prior_std: of ln k_t."""
    f = np.linspace(0.2, 50.0, _POINTS)
    at = np.array([log_stiffness, log_level, 2.0])

    def of(place: NDArray[np.float64]) -> NDArray[np.complex128]:
        return spectrum(float(place[0]), float(place[1]), float(place[2]), f)

    inverse = np.linalg.inv(of(at))
    slopes = [(of(at + e) - of(at - e)) / (2.0 * _STEP) for e in _STEP * np.eye(3)]
    shares = [inverse @ slope for slope in slopes]
    J = [[np.trapezoid(np.trace(p @ q, axis1=1, axis2=2).real, f) for q in shares] for p in shares]
    information = seconds * np.array(J) + np.diag([prior_std**-2.0, 0.0, 0.0])
    return float(np.sqrt(np.linalg.inv(information)[0, 0]))


def waviness_of(path: str) -> float:
    """Of a measured profile: slope of its spectrum's octaves within FITTED."""
    x, z = read_profile(path)
    n, power = periodogram(z, float(np.median(np.diff(x))))
    low, level = octave_means(n, power, *FITTED)
    return -float(np.polyfit(np.log(low), np.log(level), 1)[0])


def table() -> Iterator[StudyRow]:
    """`waviness_X.bias_kpa`, `bound_unknown_waviness.rmse_kpa_Xs`: at 60 km/h, 180 kPa, class B."""
    car = known(Scenario(duration=1.0))
    law, load = TyreLaw.of(car), sum(quarter_masses(car, "fl")) * GRAVITY
    stiffness = float(law.stiffness_at(EXPECTED, SPEED, load))
    slope = float(law.pressure_std(stiffness, SPEED, load))
    place = float(np.log(stiffness)), float(np.log(class_spectrum(ROAD)))
    for waviness in WAVINESSES:
        pressure = float(law.pressure_of(np.exp(settled(*place, waviness)), SPEED, load))
        yield StudyRow(f"waviness_{waviness:g}.bias_kpa", "kPa", None, 1e-3 * (pressure - EXPECTED))
    for seconds in (2.0, 10.0, 60.0):
        std = slope * unknown_waviness_std(*place, seconds, EXPECTED_STD / slope)
        yield StudyRow(f"bound_unknown_waviness.rmse_kpa_{seconds:g}s", "kPa", None, 1e-3 * std)
