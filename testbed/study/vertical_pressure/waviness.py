"""Roads whose spectrum does not fall with slope -2: what ISO 8608's assumption would cost, and drives over them.

A road of waviness w has G(Omega) = G Omega^-w. A filter that believes in w = 2 settles where its spectrum is nearest to
the true one in the Kullback-Leibler sense (White, Econometrica 50, 1982),

    min over ln k, ln G of  integral of  ln M + S / M  over f,

M, S: the model's and the true spectrum of the hub (`quarter_car.response`). A steeper road has less at the wheel's hop
against what it has below, which looks like a softer tyre: rows `waviness_X.believer_bias_kpa`. What the estimators make
of it is driven: `METHOD.waviness_X_bias_kpa` and `_rmse_kpa` after `tasks.WAVY_LONG` seconds over isotropic roads of
one slope (`tasks.wavy_road`). `bound_known_waviness.rmse_kpa_Xs`: the bound of who is told the slopes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from estimators.car import GRAVITY
from estimators.quarter_car.bound import Setting, pressure_std
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.response import measured_spectrum
from estimators.quarter_car.road_shape import class_spectrum
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.scores.interval import mean_interval
from testbed.roads.profile import read_profile
from testbed.roads.spectrum import octave_means, periodogram
from testbed.scenario import Scenario
from testbed.study.study import StudyRow
from testbed.study.vertical_pressure.errors import BEST, error_and_std, of_kind, rmse
from testbed.study.vertical_pressure.limits import linear_quarter
from testbed.study.vertical_pressure.listening import known
from testbed.study.vertical_pressure.tasks import WAVINESSES
from testbed.study.vertical_pressure.told import EXPECTED, EXPECTED_STD

SPEED, ROAD = 60.0 / 3.6, "B"
BAND = (0.5, 28.0)  # Hz that the bank hears
NOISE = 2.0 * 0.5**2 / 1000.0  # (m/s^2)^2/Hz
FITTED = (0.08, 1.6)  # cycle/m, of which a road's waviness is told: 1.3 to 27 Hz at 60 km/h
_POINTS = 1000


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


def waviness_of(path: str) -> float:
    """Of a measured profile: slope of its spectrum's octaves within FITTED."""
    x, z = read_profile(path)
    n, power = periodogram(z, float(np.median(np.diff(x))))
    low, level = octave_means(n, power, *FITTED)
    return -float(np.polyfit(np.log(low), np.log(level), 1)[0])


def table(drives: Sequence[dict[str, Any]]) -> Iterator[StudyRow]:
    """See the module; believer and bound at 60 km/h, 180 kPa, class B."""
    car = known(Scenario(duration=1.0))
    law, load = TyreLaw.of(car), sum(quarter_masses(car, "fl")) * GRAVITY
    stiffness = float(law.stiffness_at(EXPECTED, SPEED, load))
    slope = float(law.pressure_std(stiffness, SPEED, load))
    place = float(np.log(stiffness)), float(np.log(class_spectrum(ROAD)))
    for waviness in WAVINESSES:
        pressure = float(law.pressure_of(np.exp(settled(*place, waviness)), SPEED, load))
        yield StudyRow(f"waviness_{waviness:g}.believer_bias_kpa", "kPa", None, 1e-3 * (pressure - EXPECTED))
    setting = Setting(linear_quarter("front"), stiffness, class_spectrum(ROAD), SPEED)
    for seconds in (2.0, 10.0, 60.0):
        std = pressure_std(setting, seconds, slope, pressure_prior_std=EXPECTED_STD)
        yield StudyRow(f"bound_known_waviness.rmse_kpa_{seconds:g}s", "kPa", None, 1e-3 * std)
    for method in BEST:
        for waviness in WAVINESSES:
            own = [d for d in of_kind(drives, "waviness") if d["task"]["waviness"] == waviness]
            error, _ = error_and_std(own, method, own[0]["time_s"][-1]) if own else (np.empty((0, 4)), None)
            if len(error):
                yield StudyRow.of(f"{method}.waviness_{waviness:g}_bias_kpa", "kPa", mean_interval(error.mean(axis=1)))
                yield StudyRow.of(f"{method}.waviness_{waviness:g}_rmse_kpa", "kPa", rmse(error))
