"""The bound beside the reported deviation: Cramer-Rao's without drift, held up by drift and silence."""

from __future__ import annotations

import math

import numpy as np
import pytest

from estimators.car import Car
from estimators.quarter_car.bound import Setting, relative_stiffness_std
from estimators.quarter_car.quarter_car import QuarterCar
from estimators.quarter_car.roughness import WAVINESS_STD
from estimators.vertical_pressure import limit
from estimators.vertical_pressure.corner import maker_corner
from estimators.vertical_pressure.limit import Limit
from estimators.vertical_pressure.posterior import LOG_LEVEL, LOG_STIFFNESS, STIFFNESS_DRIFT

QUARTER = maker_corner(Car(), "front").quarter
LOG_K = math.log(270e3)
UNSPRUNG = QUARTER.unsprung_mass + QUARTER.belt_mass
LINEAR = QuarterCar(QUARTER.sprung_mass, UNSPRUNG, QUARTER.spring_rate, 0.0, QUARTER.damping, 0.0)
SETTING = Setting(LINEAR, math.exp(LOG_K), 64e-6, 30.0)
FLAT = np.ones(len(LOG_STIFFNESS))
BINNED = 0.01  # of the std: J_1 is worked out at ln k_t rounded to a tenth
LEARNT = 5e-3  # the slope of long waves does not drift and is learnt ever on
BLOCK = 0.25


def heard(seconds: float) -> Limit:
    """After that time on the road."""
    known = Limit(FLAT)
    for _ in range(round(seconds / BLOCK)):
        known.pass_time(BLOCK)
        known.hear(BLOCK, QUARTER, LOG_K)
    return known


def test_without_drift_it_is_the_bound_with_the_prior_s_information(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limit, "_Q", np.zeros((4, 4)))
    priors = {
        "level_std": float(np.ptp(LOG_LEVEL)) / math.sqrt(12.0),
        "stiffness_std": float(np.std(LOG_STIFFNESS)),
        "waviness_std": WAVINESS_STD,
    }
    for seconds in (2.0, 10.0, 60.0):
        bound = relative_stiffness_std(SETTING, seconds, **priors)
        assert heard(seconds).std() == pytest.approx(bound, rel=BINNED)


def test_with_drift_it_settles_where_what_is_heard_balances_what_changes() -> None:
    """Scalar Riccati equation q = P^2 J_1, with J_1 between known and unknown road."""
    hour, two = heard(3600.0).std(), heard(7200.0).std()
    assert two == pytest.approx(hour, rel=LEARNT)
    J = SETTING.information
    known, unknown = J[0, 0], 1.0 / np.linalg.inv(J)[0, 0]
    assert (STIFFNESS_DRIFT**2 / known) ** 0.25 < hour < (1.0 + BINNED) * (STIFFNESS_DRIFT**2 / unknown) ** 0.25


def test_unheard_it_grows_as_the_tyre_drifts() -> None:
    known = heard(60.0)
    before = known.std()
    known.pass_time(100.0)
    assert known.std() == pytest.approx(math.hypot(before, STIFFNESS_DRIFT * 10.0), rel=1e-9)
