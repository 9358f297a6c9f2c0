"""The linear bank: its chain, filters and posterior against closed forms, and its estimates against the bound."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are, solve_toeplitz
from scipy.signal import sosfreqz

from estimators.axles.response import Axles, hub_responses
from estimators.car import Car
from estimators.quarter_car.bound import Setting, relative_stiffness_std
from estimators.quarter_car.quarter_car import QuarterCar
from estimators.quarter_car.response import response, road_spectrum
from estimators.quarter_car.roughness import WAVINESS_STD, shape
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.vertical_pressure.anti_alias import HIGH_PASS, RATE, STEP, analogue, sections
from estimators.vertical_pressure.bank import (
    LEVELS,
    LONG,
    NODES,
    SENSOR_VARIANCE,
    AxleBank,
    design,
    heard_by,
)
from estimators.vertical_pressure.calibrate import LEAST_STD, calibrated, rescaled
from estimators.vertical_pressure.chain import continuous, sampled
from estimators.vertical_pressure.corner import expected_pressure, from_document, maker_corner, to_document
from estimators.vertical_pressure.hub_spectrum import POINTS, Beside, autocovariance, hub_gain
from estimators.vertical_pressure.identify import SETTLE, KnownDrive, identify
from estimators.vertical_pressure.innovations import ERROR_UNIT, filter_of, squares
from estimators.vertical_pressure.posterior import (
    FINE_SHORT,
    LEVEL_DRIFT,
    LOG_LEVEL,
    LOG_STIFFNESS,
    ROAD_JUMPS,
    SHAPE,
    SHORT_DRIFT,
    STIFFNESS_DRIFT,
    STIFFNESS_JUMPS,
    Posterior,
    moments,
)
from estimators.vertical_pressure.prediction import MEMORY, predictors
from estimators.vertical_pressure.riccati import steady_filter, steady_prediction
from estimators.vertical_pressure.vertical_pressure import VerticalPressure
from models.identified import identified

SPEED, STIFFNESS, LEVEL = 60.0 / 3.6, 220e3, 4e-6
CORNER = maker_corner(Car(), "front")
QUARTER, LOW = CORNER.quarter, analogue()
ALONE = Beside(QUARTER, 0.0, 2.8, 1.6)


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


def test_autocovariance_is_that_of_the_chain_and_its_prediction_that_of_the_kalman_filter() -> None:
    """r(n) = C A^n P C' of the state space; error variance of a long memory S of the Riccati equation, of a second's
    within 1.5 % of it. The footprint's floor is in the first and not in the second."""
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
    # coherency vanishes on wide tracks; against the response of `axles`, whose footprint is exact
    beside = Beside(QUARTER._replace(sprung_mass=500.0, footprint=1e-3), 8e-4, 2.8, 100.0)
    short = QUARTER._replace(footprint=1e-3)
    out = np.empty((2, len(frequency)), complex)
    hub_responses(Axles(short, beside.quarter, 8e-4, 2.8), STIFFNESS, STIFFNESS, SPEED, 1.0, frequency, out)
    road = SPEED / (2.0 * np.pi * (frequency**2 + (0.127 * SPEED / 2.0 / np.pi) ** 2))
    found = hub_gain(short, beside, k, SPEED, frequency)[0]
    assert found == pytest.approx(np.abs(out[0]) ** 2 / road, rel=0.01)


def test_road_of_two_slopes_meets_at_its_break_and_is_iso_s_with_two() -> None:
    omega = np.array([0.2, 0.9999999, 1.0000001, 4.0, 20.0])
    assert shape(omega, 2.0, 2.0) == pytest.approx(omega**-2.0)
    bent = shape(omega, 1.5, 3.0)
    assert bent[1] == pytest.approx(bent[2], rel=1e-5)
    assert bent[0] / bent[1] == pytest.approx(0.2**-1.5, rel=1e-5)
    assert bent[4] / bent[3] == pytest.approx(5.0**-3.0)
    assert bent[3] == pytest.approx(4.0**-2.0)


def over_road(count: int, seconds: float, seed: int, long: float, short: float) -> NDArray[np.float64]:
    """Decimated hub accelerations over a road of two slopes, (count, n): circulant embedding of `autocovariance`."""
    half = autocovariance(
        QUARTER, ALONE, np.array([STIFFNESS]), SPEED, np.array([long]), np.array([short]), POINTS // 2
    )[0, 0, 0]
    n = round(seconds / STEP)
    r = np.zeros(n + POINTS)
    r[: len(half)] = half
    r[-len(half) + 1 :] = half[:0:-1]
    power = np.maximum(np.fft.rfft(r).real, 0.0)
    white = np.fft.rfft(np.random.default_rng(seed).standard_normal((count, len(r))))
    out = np.sqrt(LEVEL) * np.fft.irfft(white * np.sqrt(power), len(r))[:, :n]
    return out + np.sqrt(SENSOR_VARIANCE) * np.random.default_rng(seed + 1).standard_normal(out.shape)


def estimated(samples: NDArray[np.float64]) -> tuple[Posterior, float, float]:
    """Posterior over one wheel's drive under a flat prior; mean and std of ln k_t."""
    filters, log_variance = AxleBank(QUARTER, ALONE).at(SPEED)
    posterior = Posterior(np.ones(len(LOG_STIFFNESS)))
    for k in range(SETTLE, len(samples) - 15, 16):
        posterior.pass_time(16 * STEP)
        posterior.take(heard_by(filters, samples[k - MEMORY : k + 16].copy()), log_variance, 16)
    return posterior, *moments(posterior.stiffness(), LOG_STIFFNESS)


def test_bank_reaches_the_bound_without_bias_and_knows_its_error() -> None:
    """On the chain's own drives: std after 20 s within 1.3 of the bound with unknown level and slopes, NEES about 1."""
    seconds, count = 20.0, 40
    found = np.array([estimated(y)[1:] for y in drives(count, seconds + SETTLE * STEP, 2)])
    error = found[:, 0] - np.log(STIFFNESS)
    plain = QuarterCar(QUARTER.sprung_mass, 61.14, QUARTER.spring_rate, 0.0, QUARTER.damping, 0.0)
    setting = Setting(plain, STIFFNESS, LEVEL, SPEED, band=(0.2, 28.0))
    bound = relative_stiffness_std(setting, seconds, waviness_std=WAVINESS_STD)
    assert error.std() < 1.3 * bound
    assert abs(error.mean()) < 4.0 * error.std() / np.sqrt(count)
    nees = np.mean((error / found[:, 1]) ** 2)
    assert nees == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / count))


@pytest.mark.parametrize(("long", "short"), [(1.7, 1.7), (2.5, 2.5), (2.0, 3.2)])
def test_on_a_road_of_other_slopes_it_is_as_right_as_on_iso_s(long: float, short: float) -> None:
    """Of the last one, much as the measured road, a believer in slope -2 has k_t a factor 2 too low."""
    count = 8
    runs = [estimated(y) for y in over_road(count, 25.0, 5, long, short)]
    error = np.array([mean for _, mean, _ in runs]) - np.log(STIFFNESS)
    std = np.array([std for _, _, std in runs])
    assert abs(error.mean()) < 4.0 * std.mean() / np.sqrt(count)
    assert np.mean((error / std) ** 2) < 1.0 + 4.0 * np.sqrt(2.0 / count)
    slopes = [moments(posterior.road().sum(axis=1), FINE_SHORT) for posterior, _, _ in runs]
    assert abs(np.mean([mean for mean, _ in slopes]) - short) < 4.0 * np.mean([s for _, s in slopes]) / np.sqrt(count)


@pytest.mark.parametrize("level", [1e-6, 2.7e-6, 6.4e-5])
def test_level_is_found_between_the_bank_s_nodes(level: float) -> None:
    posterior, _, _ = estimated(drives(1, 30.0, 3, level)[0])
    mean, std = moments(posterior.road().sum(axis=0), LOG_LEVEL)
    assert std < 0.3
    assert abs(mean - np.log(level)) < 4.0 * std


@pytest.mark.parametrize("speed", [11.1, 25.0])
def test_likelihood_between_the_nodes_is_that_of_filters_designed_there(speed: float) -> None:
    """Over a minute of samples, of all that is within 30 nats of the best: within `most`, a tenth of a posterior's std
    on a slope of as many nats."""
    most, count = 3.0, 3744
    samples = drives(1, 62.0, 8)[0][: MEMORY + count].copy()
    filters, log_variance = design(QUARTER, ALONE, speed)
    posterior = Posterior(np.ones(len(LOG_STIFFNESS)))
    posterior.take(heard_by(filters, samples), log_variance, count)
    rows = np.arange(2, len(LOG_STIFFNESS), 5)  # as far from nodes as can be
    covariance = autocovariance(QUARTER, ALONE, np.exp(LOG_STIFFNESS[rows]), speed, LONG, FINE_SHORT[1::2], MEMORY)
    flat = covariance.reshape(-1, MEMORY + 1)
    place = 22  # of LOG_LEVEL: a node
    white = np.array([QUARTER.hub_error * ERROR_UNIT * speed + SENSOR_VARIANCE / np.exp(LOG_LEVEL[place])])
    own, variance = np.empty((len(flat), 1, MEMORY + 1)), np.empty((len(flat), 1))
    predictors(flat, white, own, variance)
    nu = np.lib.stride_tricks.sliding_window_view(samples, MEMORY + 1)[:, ::-1] @ own[:, 0].T
    direct = -0.5 * count * (np.log(np.sum(nu**2, axis=0)) + variance[:, 0])  # at the best level of each
    direct = direct.reshape(len(rows), len(LONG), -1).transpose(1, 2, 0)
    j = place // 11
    found = -0.5 * count * (posterior._summed[..., j] + posterior._variance[..., j])[:, 1::2, rows]
    near = direct > direct.max() - 30.0
    assert near.sum() > 4
    assert np.abs(found - direct)[near].max() < most


def test_belief_is_bayes_on_the_grid_and_moves_as_stated() -> None:
    """Both kernels against numpy."""
    rng = np.random.default_rng(4)
    posterior = Posterior(rng.random(len(LOG_STIFFNESS)))
    posterior.p[:] = rng.random(SHAPE)
    posterior.p /= posterior.p.sum()
    before, dt = posterior.p.copy(), 0.256
    posterior.pass_time(dt)
    moved = before.copy()
    for axis, drift, cells in (
        (2, STIFFNESS_DRIFT, LOG_STIFFNESS),
        (1, SHORT_DRIFT, FINE_SHORT),
        (3, LEVEL_DRIFT, LOG_LEVEL),
    ):
        padded = np.pad(before, [(int(a == axis),) * 2 for a in range(4)], mode="edge")
        share = 0.5 * drift**2 * dt / (cells[1] - cells[0]) ** 2
        moved += share * np.diff(padded, 2, axis=axis)
    k, road = STIFFNESS_JUMPS * dt, ROAD_JUMPS * dt
    new_k = posterior._prior[:, None] * before.sum(axis=2, keepdims=True)
    new_road = before.sum(axis=(0, 1, 3))[:, None] * posterior._road[:, :, None, :]
    wanted = (1.0 - k) * (1.0 - road) * moved + k * (1.0 - road) * new_k + road * new_road
    assert posterior.p == pytest.approx(wanted, rel=1e-9)
    assert posterior.p.sum() == pytest.approx(1.0, abs=1e-12)
    before = posterior.p.copy()
    summed, log_variance = 16.0 * rng.lognormal(0.0, 0.5, NODES) * 3e-6, 0.1 * rng.standard_normal(NODES)
    posterior.take(summed, log_variance, 16)
    log_s, log_v = posterior._summed, posterior._variance
    assert log_s[:, ::2, ::5] == pytest.approx(np.log(summed).transpose(1, 2, 0, 3))  # at the nodes
    j = np.minimum(np.arange(len(LOG_LEVEL)) // 11, len(LEVELS) - 2)
    share = np.minimum(np.arange(len(LOG_LEVEL)) / 11 - j, 1.0)
    s = (1.0 - share) * np.exp(log_s[..., j]) + share * np.exp(log_s[..., j + 1])
    v = (1.0 - share) * log_v[..., j] + share * log_v[..., j + 1]
    plain = -0.5 * (s * np.exp(-LOG_LEVEL) + 16.0 * (v + LOG_LEVEL))
    wanted = before * np.exp(np.maximum(plain - plain.max(), -64.0))
    assert posterior.p == pytest.approx(wanted / wanted.sum(), rel=1e-7, abs=1e-300)


def test_belief_follows_a_jump_of_the_stiffness_and_stays_normalised() -> None:
    posterior = Posterior(np.ones(len(LOG_STIFFNESS)))
    posterior.p[:] = 0.0
    posterior.p[1, 5, 45, 20] = 1.0
    for _ in range(20):
        posterior.pass_time(0.256)
    assert posterior.p.sum() == pytest.approx(1.0, abs=1e-12)
    assert posterior.stiffness()[10] > 1e-6
    assert posterior.stiffness().argmax() == 45


def test_belief_of_impossible_samples_is_no_nan() -> None:
    posterior = Posterior(np.ones(len(LOG_STIFFNESS)))
    S = np.zeros(NODES)
    for value in (1e300, np.inf, 0.0):
        posterior.take(np.full(NODES, value), S, 16)
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
    mean, std = moments(wheel.posterior.stiffness(), law.pressure_of(np.exp(LOG_STIFFNESS), 20.0, wheel.load))
    assert mean == pytest.approx(180e3, rel=5e-3)
    assert std == pytest.approx(20e3, rel=0.02)
    assert expected_pressure(car, {}) == (car.pressure, 0.25 * car.pressure)
    with pytest.raises(ValueError, match="pressure_std"):
        expected_pressure(car, {"tyres": {"pressure": 1.0}})
    with pytest.raises(ValueError, match="pressure is -1"):
        expected_pressure(car, {"tyres": tyres | {"pressure": -1.0}})
