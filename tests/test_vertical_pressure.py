"""The linear bank: its chain, filters and posterior against closed forms, and its estimates against the bound."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are
from scipy.signal import sosfreqz

from estimators.car import Car
from estimators.quarter_car.bound import Setting, relative_stiffness_std
from estimators.quarter_car.quarter_car import QuarterCar
from estimators.quarter_car.response import response, road_spectrum
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.vertical_pressure.anti_alias import HIGH_PASS, RATE, STEP, analogue, sections
from estimators.vertical_pressure.bank import LEVELS, SENSOR_VARIANCE, STIFFNESSES, AxleBank, at_rest, hear
from estimators.vertical_pressure.calibrate import LEAST_STD, calibrated, rescaled
from estimators.vertical_pressure.chain import continuous, sampled
from estimators.vertical_pressure.corner import expected_pressure, from_document, maker_corner, to_document
from estimators.vertical_pressure.identify import SETTLE, KnownDrive, identify
from estimators.vertical_pressure.innovations import filter_of, squares
from estimators.vertical_pressure.posterior import LOG_LEVEL, LOG_STIFFNESS, Posterior, moments
from estimators.vertical_pressure.riccati import steady_filter, steady_prediction
from estimators.vertical_pressure.vertical_pressure import VerticalPressure
from models.identified import identified

SPEED, STIFFNESS, LEVEL = 60.0 / 3.6, 220e3, 4e-6
CORNER = maker_corner(Car(), "front")
QUARTER, LOW = CORNER.quarter, analogue()


def in_band(frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    """The analogue low-pass."""
    A, B, C = LOW
    return np.array([C @ np.linalg.solve(2j * np.pi * f * np.eye(len(B)) - A, B) for f in frequency])


def drives(count: int, seconds: float, seed: int, level: float = LEVEL) -> NDArray[np.float64]:
    """Decimated hub accelerations that the chain itself makes, (count, n): driven by white noise, sampled exactly."""
    M, b, C = continuous(QUARTER, STIFFNESS, SPEED, *LOW)
    A, Q = sampled(M, b, STEP)
    rng = np.random.default_rng(seed)
    scale = np.sqrt(np.diag(Q))
    values, vectors = np.linalg.eigh(Q / np.outer(scale, scale))
    root = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)) * np.sqrt(level)
    steps = round(seconds / STEP)
    x = np.zeros((count, len(b)))
    out = np.empty((count, steps))
    for k in range(-300, steps):  # runs in
        x = x @ A.T + rng.standard_normal((count, len(b))) @ root.T
        if k >= 0:
            out[:, k] = x @ C[1]
    return out + np.sqrt(SENSOR_VARIANCE) * rng.standard_normal(out.shape)


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


def estimated(samples: NDArray[np.float64]) -> tuple[Posterior, float, float]:
    """Posterior over one wheel's drive under a flat prior; mean and std of ln k_t."""
    A, c, K, S = AxleBank(QUARTER).at(SPEED)
    x, summed = at_rest(), np.empty((len(STIFFNESSES), len(LEVELS)))
    hear(A, c, K, S, samples[:SETTLE], x, summed)
    posterior = Posterior(np.ones(len(LOG_STIFFNESS)))
    for k in range(SETTLE, len(samples) - 15, 16):
        hear(A, c, K, S, samples[k : k + 16].copy(), x, summed)
        posterior.take(summed, S, 16)
    return posterior, *moments(posterior.stiffness(), LOG_STIFFNESS)


def test_bank_reaches_the_bound_without_bias_and_knows_its_error() -> None:
    """On the chain's own drives: std after 20 s within 1.3 of the bound of the quarter car, NEES about 1."""
    seconds, count = 20.0, 80
    found = np.array([estimated(y)[1:] for y in drives(count, seconds + SETTLE * STEP, 2)])
    error = found[:, 0] - np.log(STIFFNESS)
    plain = QuarterCar(QUARTER.sprung_mass, 61.14, QUARTER.spring_rate, 0.0, QUARTER.damping, 0.0)
    bound = relative_stiffness_std(Setting(plain, STIFFNESS, LEVEL, SPEED, band=(0.2, 28.0)), seconds)
    assert error.std() < 1.3 * bound
    assert abs(error.mean()) < 4.0 * error.std() / np.sqrt(count)
    nees = np.mean((error / found[:, 1]) ** 2)
    assert nees == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / count))


@pytest.mark.parametrize("level", [1e-6, 2.7e-6, 6.4e-5])
def test_level_is_found_between_the_bank_s_nodes(level: float) -> None:
    posterior, _, _ = estimated(drives(1, 60.0, 3, level)[0])
    mean, std = moments(posterior.level(), LOG_LEVEL)
    assert std < 0.15
    assert abs(mean - np.log(level)) < 4.0 * std


def test_belief_follows_a_jump_of_the_stiffness_and_stays_normalised() -> None:
    posterior = Posterior(np.ones(len(LOG_STIFFNESS)))
    posterior.p[:] = 0.0
    posterior.p[90, 40] = 1.0
    for _ in range(20):
        posterior.pass_time(0.256)
    assert posterior.p.sum() == pytest.approx(1.0, abs=1e-12)
    assert posterior.stiffness()[10] > 1e-6
    assert posterior.stiffness().argmax() == 90


def test_belief_of_impossible_samples_is_no_nan() -> None:
    posterior = Posterior(np.ones(len(LOG_STIFFNESS)))
    S = np.ones((len(STIFFNESSES), len(LEVELS)))
    posterior.take(np.full(S.shape, 1e300), S, 16)
    posterior.take(np.full(S.shape, np.inf), S, 16)
    assert np.isfinite(posterior.p).all()
    assert posterior.p.sum() == pytest.approx(1.0)


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
    """A quarter car 5 % too heavy and too stiff in all parts: set right by the mean of the drives, to their scatter."""
    known = [KnownDrive(y, STIFFNESS, SPEED) for y in drives(16, 40.0, 6)]
    found = calibrated(rescaled(QUARTER, 1.05), known)
    assert found.quarter.unsprung_mass == pytest.approx(QUARTER.unsprung_mass, rel=0.02)
    assert found.quarter.damping / found.quarter.sprung_mass == pytest.approx(QUARTER.damping / QUARTER.sprung_mass)
    assert LEAST_STD <= found.stiffness_std < 0.03


def test_what_is_expected_of_the_tyres_is_what_is_said_before_anything_was_heard() -> None:
    car, tyres = Car(), {"pressure": 180e3, "pressure_std": 20e3}
    estimator = VerticalPressure(car)
    document = identified()["vertical_pressure"] | {"tyres": tyres}
    estimator.use_calibration(document)
    assert estimator.calibration() == document
    law, wheel = TyreLaw.of(car), estimator._wheels[0]
    mean, std = moments(wheel.posterior.stiffness(), law.pressure_of(np.exp(LOG_STIFFNESS), 20.0, wheel.load))
    assert mean == pytest.approx(180e3, rel=5e-3)
    assert std == pytest.approx(20e3, rel=0.02)
    assert expected_pressure(car, {}) == (car.pressure, 0.25 * car.pressure)
    with pytest.raises(ValueError, match="pressure_std"):
        expected_pressure(car, {"tyres": {"pressure": 1.0}})
    with pytest.raises(ValueError, match="pressure is -1"):
        expected_pressure(car, {"tyres": tyres | {"pressure": -1.0}})
