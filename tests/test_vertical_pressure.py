"""The linear bank's chain, its filters and its identification against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are, solve_toeplitz
from scipy.signal import sosfreqz

from estimators.axles.response import Axles, hub_responses
from estimators.car import Car
from estimators.quarter_car.quarter_car import QuarterCar
from estimators.quarter_car.response import response, road_spectrum
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.vertical_pressure import hub_spectrum
from estimators.vertical_pressure.anti_alias import HIGH_PASS, RATE, STEP, sections
from estimators.vertical_pressure.bank import (
    SENSOR_VARIANCE,
)
from estimators.vertical_pressure.calibrate import LEAST_STD, calibrated, rescaled
from estimators.vertical_pressure.chain import continuous, sampled
from estimators.vertical_pressure.corner import expected_pressure, from_document, to_document
from estimators.vertical_pressure.hub_spectrum import BLIND, Beside, autocovariance, hub_gain
from estimators.vertical_pressure.identify import SETTLE, KnownDrive, identify
from estimators.vertical_pressure.innovations import ERROR_UNIT, filter_of, squares
from estimators.vertical_pressure.posterior import (
    LOG_STIFFNESS,
    moments,
)
from estimators.vertical_pressure.prediction import MEMORY, predictors
from estimators.vertical_pressure.riccati import steady_filter, steady_prediction
from estimators.vertical_pressure.vertical_pressure import VerticalPressure
from models.identified import identified
from tests.chain_drives import ALONE, LEVEL, LOW, QUARTER, SPEED, STIFFNESS, drives, in_band


def test_low_pass_is_flat_to_its_edge_and_its_digital_form_is_the_analogue_one() -> None:
    frequency = np.array([1.0, 5.0, 10.0, 20.0, 27.0])
    assert np.abs(in_band(frequency)) == pytest.approx(1.0, abs=0.012)  # 0.1 dB
    assert np.abs(in_band(np.array([45.0, 60.0, 120.0]))).max() < 10.0 ** (-44.0 / 20.0)
    _, digital = sosfreqz(sections(), frequency, fs=RATE)
    assert np.abs(digital) == pytest.approx(np.abs(in_band(frequency)), rel=4e-3)


@pytest.mark.parametrize("speed", [8.0, 16.7, 50.0])
def test_sampling_is_the_matrix_exponential_and_keeps_the_stationary_covariance(speed: float) -> None:
    """exp(A dt) by scipy; P = A P A' + Q for the P of the continuous Lyapunov equation."""
    from scipy.linalg import solve_continuous_lyapunov

    M, b, _ = continuous(QUARTER, STIFFNESS, speed, *LOW)
    A, Q = sampled(M, b, STEP)
    assert np.abs(A - expm(M * STEP)).max() < 1e-9 * np.abs(A).max()
    P = solve_continuous_lyapunov(M, -np.outer(b, b))
    scale = np.sqrt(np.diag(P))
    assert np.abs((P - A @ P @ A.T - Q) / np.outer(scale, scale)).max() < 1e-7


def test_chain_is_the_quarter_car_behind_footprint_and_both_filters() -> None:
    """With a light belt the hub's spectrum is `response` times the road's, the cams' and the filter."""
    frequency = np.array([0.8, 2.0, 6.0, 11.0, 20.0, 27.0])
    quarter = QUARTER._replace(unsprung_mass=60.0, belt_mass=1e-3)
    M, b, C = continuous(quarter, STIFFNESS, SPEED, *LOW)
    n = len(b)
    gain = np.array([C[1] @ np.linalg.solve(2j * np.pi * f * np.eye(n) - M, b) for f in frequency])
    plain = QuarterCar(quarter.sprung_mass, 60.001, quarter.spring_rate, 0.0, quarter.damping, 0.0)
    length = quarter.footprint * (STIFFNESS / 250e3) ** -quarter.softer
    cams = np.cos(np.pi * frequency * length / SPEED)
    wanted = np.abs(response(plain, STIFFNESS, frequency)[:, 1] * cams * in_band(frequency)) ** 2
    road = road_spectrum(frequency, 1.0, SPEED) * frequency**2 / (frequency**2 + HIGH_PASS**2)
    assert 2.0 * np.abs(gain) ** 2 == pytest.approx(wanted * road, rel=5e-3)  # the delay's Pade form


def test_steady_filter_solves_the_riccati_equation() -> None:
    M, b, C = continuous(QUARTER, STIFFNESS, SPEED, *LOW)
    A, Q = sampled(M, b, STEP)
    c, R = C[1:].copy(), np.array([[5e3]])
    P = steady_prediction(A, c, Q, R)
    K, S = steady_filter(A, c, Q, R)
    scale = np.sqrt(np.diag(P))
    residual = A @ P @ A.T - A @ P @ c.T @ np.linalg.solve(S, c @ P @ A.T) + Q - P
    assert np.abs(residual / np.outer(scale, scale)).max() < 1e-8  # states of 1 s and of 1 ms in one matrix
    assert np.abs(np.linalg.eigvals(A - A @ K @ c)).max() < 1.0
    small = np.array([[0.9, 0.1], [0.0, 0.7]]), np.array([[1.0, 0.5]]), np.diag([1.0, 2.0]), np.array([[0.3]])
    assert steady_prediction(*small) == pytest.approx(solve_discrete_are(small[0].T, small[1].T, *small[2:]), rel=1e-9)


def test_innovations_of_the_right_filter_are_white_with_their_variance() -> None:
    A, c, K, S = filter_of(QUARTER._replace(hub_error=1e-9), STIFFNESS, SPEED, LEVEL, SENSOR_VARIANCE, LOW, STEP)
    found = np.array([squares(A, c, K, S, y)[SETTLE:] for y in drives(10, 40.0, 1)]) / LEVEL
    assert found.mean() == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / found.size))


def test_autocovariance_is_that_of_the_chain_and_its_prediction_that_of_the_kalman_filter(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """r(n) = C A^n P C' of the state space; error variance of a long memory S of the Riccati equation, of a second's
    within 1.5 % of it. Without the footprint's floor, which only the first has; the second has its Pade form."""
    monkeypatch.setattr(hub_spectrum, "BLIND", 0.0)
    from scipy.linalg import solve_continuous_lyapunov

    M, b, C = continuous(QUARTER, STIFFNESS, SPEED, *LOW)
    A, P = expm(M * STEP), solve_continuous_lyapunov(M, -np.outer(b, b))
    wanted = [C[1] @ np.linalg.matrix_power(A, n) @ P @ C[1] for n in range(256)]
    slope = np.array([2.0])
    found = autocovariance(QUARTER, ALONE, np.array([STIFFNESS]), SPEED, slope, slope, 255)[0, 0]
    assert found[0] == pytest.approx(wanted, abs=0.015 * wanted[0])
    _, _, _, S = filter_of(QUARTER, STIFFNESS, SPEED, LEVEL, SENSOR_VARIANCE, LOW, STEP)
    white = np.array([QUARTER.hub_error * ERROR_UNIT * SPEED + SENSOR_VARIANCE / LEVEL])
    filters, log_variance = np.empty((1, 1, MEMORY + 1)), np.empty((1, 1))
    predictors(found[:, : MEMORY + 1].copy(), white, filters, log_variance)
    assert np.exp(log_variance[0, 0]) == pytest.approx(S, rel=0.015)
    r = found[0, : MEMORY + 1] + white[0] * np.eye(MEMORY + 1)[0]
    plain = np.concatenate([[1.0], -solve_toeplitz(r[:MEMORY], r[1:])])  # Yule-Walker, solved at once
    assert filters[0, 0] * np.exp(0.5 * log_variance[0, 0]) == pytest.approx(plain, abs=1e-8)


def test_gain_beside_the_other_axle_solves_the_equations_of_both() -> None:
    frequency, k = np.array([2.0, 7.0, 13.0, 24.0]), np.array([STIFFNESS])
    assert hub_gain(QUARTER, ALONE, k, SPEED, frequency)[0] == pytest.approx(
        hub_gain(QUARTER, ALONE._replace(later=-1.0), k, SPEED, frequency)[0]
    )
    # tracks so wide that they have nothing in common, no footprint: the response of `axles`
    beside = Beside(QUARTER._replace(sprung_mass=500.0, footprint=1e-3), 8e-4, 2.8, 100.0)
    short = QUARTER._replace(footprint=1e-3)
    out = np.empty((2, len(frequency)), complex)
    hub_responses(Axles(short, beside.quarter, 8e-4, 2.8), STIFFNESS, STIFFNESS, SPEED, 1.0, frequency, out)
    road = SPEED / (2.0 * np.pi * (frequency**2 + (0.127 * SPEED / 2.0 / np.pi) ** 2))
    found = hub_gain(short, beside, k, SPEED, frequency)[0]
    assert found == pytest.approx((1.0 + BLIND) * np.abs(out[0]) ** 2 / road, rel=1e-3)


def test_identification_finds_the_quarter_car_from_wrong_starts() -> None:
    """From the chain's own drives, the maker's numbers 10 % off: found, at one optimum."""
    known = [KnownDrive(y, STIFFNESS, SPEED) for y in drives(6, 60.0, 4)]
    wrong = QUARTER._replace(unsprung_mass=1.1 * QUARTER.unsprung_mass, damping=0.9 * QUARTER.damping)
    found = identify(wrong, known)
    assert max(found.costs) - min(found.costs) < 1e-5
    assert found.quarter.unsprung_mass == pytest.approx(QUARTER.unsprung_mass, rel=0.08)
    assert found.quarter.damping == pytest.approx(QUARTER.damping, rel=0.08)
    with pytest.raises(ValueError, match="decimated samples"):
        identify(wrong, [])


def test_documents_there_and_back_and_what_is_wrong_with_them() -> None:
    document = identified()["vertical_pressure"]
    assert to_document(from_document(document)) == document
    with pytest.raises(ValueError, match="valid: front, rear"):
        from_document({"front": document["front"]})
    with pytest.raises(ValueError, match="damping is -1"):
        from_document(document | {"rear": document["rear"] | {"damping": -1.0}})
    with pytest.raises(ValueError, match="all of them"):
        from_document(document | {"rear": {}})


def test_scale_is_found_that_likelihood_of_an_unknown_road_leaves_open() -> None:
    """A quarter car 20 % too heavy and too stiff in all parts: set right by the mean of the drives, to four times their
    scatter of 6 % of stiffness each, the road being unknown."""
    known = [KnownDrive(y, STIFFNESS, SPEED) for y in drives(16, 40.0, 6)]
    found = calibrated(rescaled(QUARTER, 1.2), ALONE, known)
    assert found.quarter.unsprung_mass == pytest.approx(QUARTER.unsprung_mass, rel=0.06)
    assert found.quarter.damping / found.quarter.sprung_mass == pytest.approx(QUARTER.damping / QUARTER.sprung_mass)
    assert LEAST_STD <= found.stiffness_std < 0.05


def test_what_is_expected_of_the_tyres_is_what_is_said_before_anything_was_heard() -> None:
    car, tyres = Car(), {"pressure": 180e3, "pressure_std": 20e3}
    estimator = VerticalPressure(car)
    document = identified()["vertical_pressure"] | {"tyres": tyres}
    estimator.use_calibration(document)
    assert estimator.calibration() == document
    law, wheel = TyreLaw.of(car), estimator._wheels[0]
    mean, std = moments(wheel.posterior.stiffness(), law.pressure_of(np.exp(LOG_STIFFNESS), 20.0, wheel.load(1.0)))
    assert mean == pytest.approx(180e3, rel=5e-3)
    assert std == pytest.approx(20e3, rel=0.02)
    assert expected_pressure(car, {}) == (car.pressure, 0.25 * car.pressure)
    with pytest.raises(ValueError, match="pressure_std"):
        expected_pressure(car, {"tyres": {"pressure": 1.0}})
    with pytest.raises(ValueError, match="pressure is -1"):
        expected_pressure(car, {"tyres": tyres | {"pressure": -1.0}})
