"""The interacting multiple model of unscented filters: readable reference, compiled bank, and what neither may do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filterpy.kalman import IMMEstimator
from numpy.typing import NDArray

from estimators.quarter_car.quarter_car import QuarterCar, ride
from estimators.quarter_car.road_shape import class_spectrum, synthesised
from estimators.unscented_imm.compiled_bank import CompiledImm
from estimators.unscented_imm.identify import KnownCase, identify
from estimators.unscented_imm.kernel import HIGHEST, LOWEST
from estimators.unscented_imm.markov import published, scaled
from estimators.unscented_imm.reference import ReferenceImm, quarter_step
from estimators.unscented_imm.settings import STIFFNESS, Settings, known_road, road_as_state

SPEED, TRUE_STIFFNESS, STEP = 60.0 / 3.6, 220e3, 1e-3
QUARTER = QuarterCar(466.7, 61.14, 38e3, 2e6, 3e3, 200.0)
QUARTERS = [QUARTER._replace(damping=c) for c in (3e3, 3.3e3, 2.8e3, 3.6e3)]
SPECTRA = [class_spectrum(c) for c in "ABCD"]
EQUAL = 1e-9  # relative: rounding of two orders of the same sums, over the steps compared


def driven(steps: int, seed: int = 1) -> tuple[NDArray, NDArray]:
    """Measured (steps, 2) and road heights (steps,) of a class B road."""
    rng = np.random.default_rng(seed)
    height = synthesised(class_spectrum("B"), SPEED, 0.5 * STEP, 2 * steps - 1, rng)
    _, felt = ride(QUARTER, height, TRUE_STIFFNESS, STEP)
    return felt + 0.5 * rng.standard_normal(felt.shape), height[::2]


def oracle(wheels: int = 1) -> Settings:
    return known_road([QUARTERS] * wheels, 250e3)


def blind(wheels: int = 1) -> Settings:
    return road_as_state([QUARTERS] * wheels, 250e3, SPECTRA, SPEED)


def heights(road: NDArray, wheels: int = 1, modes: int = 4) -> NDArray:
    return np.tile(road[:, None, None], (1, wheels, modes))


@pytest.mark.parametrize("given", [True, False])
def test_compiled_bank_equals_the_reference(given: bool) -> None:
    steps = 250
    settings = oracle() if given else blind()
    measured, road = driven(steps)
    reference, bank = ReferenceImm(settings), CompiledImm(settings)
    course = bank.run(measured[:, None], heights(road) if given else None)
    for k in range(steps):
        reference.step(measured[k], np.full(4, road[k]) if given else None)
        scale = np.sqrt(np.diag(reference.P))
        assert np.abs(course.mean[k, 0] - reference.x).max() <= EQUAL * np.abs(reference.x).max()
        assert (np.abs(course.mean[k, 0] - reference.x) <= EQUAL * scale).all()
        assert course.variance[k, 0] == pytest.approx(np.diag(reference.P), rel=EQUAL)
        assert course.probability[k, 0] == pytest.approx(reference.mu, abs=EQUAL)
    assert bank.repairs == 0
    for mode in range(4):
        P = bank.covariance(0, mode)
        scale = np.sqrt(np.diag(P))
        assert np.abs(P - reference.modes[mode].filter.P).max() <= EQUAL * np.outer(scale, scale).max()


def test_reference_mixes_as_filterpy_does_where_its_likelihoods_do_not_underflow() -> None:
    settings, (measured, road) = oracle(), driven(40)
    ours, donor = ReferenceImm(settings), ReferenceImm(settings)
    theirs = IMMEstimator([mode.filter for mode in donor.modes], np.full(4, 0.25), settings.transition)
    for k in range(40):
        ours.step(measured[k], np.full(4, road[k]))
        before = road[max(k - 1, 0)]
        for mode in donor.modes:  # filterpy's mixture cannot hand an input on to its filters
            mode.filter.fx = lambda x, dt, m=mode, r=before: _moved(m, x, dt, r)
            mode.filter.hx = lambda x, m=mode, r=road[k]: m.felt(x, r)
        theirs.predict()
        theirs.update(measured[k])
        assert ours.mu == pytest.approx(theirs.mu, rel=1e-9)
        assert ours.x == pytest.approx(theirs.x, rel=1e-9)
        assert pytest.approx(theirs.P, rel=1e-8, abs=1e-18) == ours.P


def _moved(mode, x, dt, road):
    return quarter_step(x, dt, mode._quarter, 1.0, road)


def test_modes_stay_apart_where_filterpy_s_likelihoods_all_underflow() -> None:
    """A knock of 60 standard deviations: exp(-1800) is 0 in filterpy, here one mode still explains it better."""
    settings, (measured, road) = oracle(), driven(60)
    measured[50] = [60.0, 200.0]
    reference, bank = ReferenceImm(settings), CompiledImm(settings)
    course = bank.run(measured[:51, None], heights(road[:51]))
    for k in range(51):
        reference.step(measured[k], np.full(4, road[k]))
    likelihoods = [mode.filter.likelihood for mode in reference.modes]
    assert max(likelihoods) < 1e-300
    assert reference.mu == pytest.approx(course.probability[50, 0], abs=1e-9)
    assert course.probability[50].max() - course.probability[49].max() > 0.05


@pytest.mark.parametrize(("step", "most"), [(1e-3, 0.04), (2.5e-4, 0.015)])
def test_oracle_finds_the_stiffness_up_to_the_error_of_its_euler_step(step: float, most: float) -> None:
    """Forward Euler, as published, reads 2.7 % low at 1 ms, four of its own stds; a finer step takes it away."""
    rng = np.random.default_rng(1)
    steps = round(4.0 / step)
    height = synthesised(class_spectrum("B"), SPEED, 0.5 * step, 2 * steps - 1, rng)
    _, felt = ride(QUARTER, height, TRUE_STIFFNESS, step)
    measured = felt + 0.5 * (1e-3 / step) ** 0.5 * rng.standard_normal(felt.shape)  # the same density of noise
    settings = known_road([[QUARTER] * 4], 250e3, step)
    settings = replace(settings, measured_variance=settings.measured_variance * 1e-3 / step)
    course = CompiledImm(settings).run(measured[:, None], heights(height[::2]))
    error = course.mean[-1, 0, STIFFNESS] / TRUE_STIFFNESS - 1.0
    assert course.variance[-1, 0, STIFFNESS] ** 0.5 < 0.01 * TRUE_STIFFNESS
    assert -most < error < 0.5 * most


def test_modes_follow_a_change_of_class() -> None:
    """Class A to D: the mode of D leads within half a second of the change."""
    rng = np.random.default_rng(4)
    smooth, rough = (synthesised(class_spectrum(c), SPEED, 0.5 * STEP, 4001, rng) for c in "AD")
    height = np.concatenate([smooth, rough[1:] - rough[0] + smooth[-1]])
    _, felt = ride(QUARTER, height, TRUE_STIFFNESS, STEP)
    measured = felt + 0.5 * rng.standard_normal(felt.shape)
    settings = road_as_state([[QUARTER] * 4], 250e3, SPECTRA, SPEED)
    probability = CompiledImm(settings).run(measured[:, None]).probability[:, 0]
    assert probability[1500:2000].mean(axis=0).argmax() == 0
    assert probability[2500:4000].mean(axis=0).argmax() == 3


def test_a_cut_of_the_stream_changes_nothing() -> None:
    measured, road = driven(300)
    whole = CompiledImm(oracle()).run(measured[:, None], heights(road))
    bank = CompiledImm(oracle())
    parts = [bank.run(measured[a:b, None], heights(road[a:b])) for a, b in ((0, 1), (1, 117), (117, 117), (117, 300))]
    assert np.concatenate([p.mean for p in parts]).tobytes() == whole.mean.tobytes()


def test_wheels_do_not_touch_one_another() -> None:
    (first, road), (second, other) = driven(200), driven(200, seed=2)
    given = np.tile(np.stack([road, other], axis=1)[..., None], (1, 1, 4))
    both = CompiledImm(oracle(2)).run(np.stack([first, second], axis=1), given)
    alone = CompiledImm(oracle()).run(second[:, None], heights(other))
    assert both.mean[:, 1].tobytes() == alone.mean[:, 0].tobytes()


def test_missing_samples_only_move_the_filters_on() -> None:
    """No sample: the variance grows, the modes go where the transition matrix says; one of two is still used."""
    measured, road = driven(400)
    bank = CompiledImm(oracle())
    bank.run(measured[:200, None], heights(road[:200]))
    before = bank.mu.copy(), bank.P[..., STIFFNESS, STIFFNESS].copy()
    bank.run(np.full((1, 1, 2), np.nan), heights(road[200:201]))
    assert bank.mu == pytest.approx(before[0] @ published(), abs=1e-12)
    assert (bank.P[..., STIFFNESS, STIFFNESS] > before[1]).any()
    one = measured[201:].copy()
    one[:, 0] = np.nan
    course = bank.run(one[:, None], heights(road[201:]))
    assert course.variance[-1, 0, STIFFNESS] < before[1].max()
    assert bank.repairs == 0


def test_one_sensor_alone_is_the_reference_with_the_other_s_noise_without_bound() -> None:
    measured, road = driven(100)
    lonely = measured.copy()
    lonely[:, 0] = np.nan
    course = CompiledImm(oracle()).run(lonely[:, None], heights(road))
    deaf = replace(oracle(), measured_variance=np.array([1e14, 0.25]))
    reference = ReferenceImm(deaf)
    for k in range(100):
        reference.step(measured[k], np.full(4, road[k]))
    assert course.mean[-1, 0] == pytest.approx(reference.x, rel=1e-6)
    assert course.probability[-1, 0] == pytest.approx(reference.mu, abs=1e-6)


@pytest.mark.parametrize("given", [True, False])
def test_covariances_stay_positive_definite_for_any_input(given: bool) -> None:
    """1e6 steps of noise, knocks, NaN, infinities and numbers beyond all bounds."""
    rng = np.random.default_rng(7)
    bank = CompiledImm(oracle() if given else blind())
    block = 5000
    for k in range(1_000_000 // block // 2):
        measured = rng.standard_normal((block, 1, 2)) * 10.0 ** rng.uniform(-3.0, 4.0, (block, 1, 1))
        wild = rng.random(measured.shape)
        measured[wild < 0.05] = np.nan
        measured[(wild > 0.05) & (wild < 0.06)] = np.inf
        measured[(wild > 0.06) & (wild < 0.07)] = -1e300
        road = np.cumsum(rng.standard_normal((block, 1, 4)), axis=0) * 10.0 ** rng.uniform(-4, 2) if given else None
        course = bank.run(measured, road)
        assert np.isfinite(course.mean).all()
        assert (course.variance > 0.0).all()
        assert course.probability.sum(axis=2) == pytest.approx(1.0, abs=1e-12)
        assert ((bank.x >= LOWEST[: bank.x.shape[2]]) & (bank.x <= HIGHEST[: bank.x.shape[2]])).all()
        for mode in range(4):
            P = bank.covariance(0, mode)
            scale = np.sqrt(np.diag(P))
            assert np.linalg.eigvalsh(P / np.outer(scale, scale)).min() > 0.0, k


def test_ordinary_driving_repairs_nothing() -> None:
    measured, road = driven(20_000)
    for settings, given in ((oracle(), heights(road)), (blind(), None)):
        bank = CompiledImm(settings)
        bank.run(measured[:, None], given)
        assert bank.repairs == 0


def test_transition_matrix_is_scaled_with_the_step() -> None:
    per_ms = published()
    assert scaled(per_ms, 1e-3, 1e-2) == pytest.approx(np.linalg.matrix_power(per_ms, 10), rel=1e-9)
    stay = 0.25 + 0.75 * 0.96**0.5  # closed form: eigenvalue 0.96 a millisecond
    assert np.diag(scaled(per_ms, 1e-3, 5e-4)) == pytest.approx(stay, rel=1e-9)
    lopsided = np.array([[0.9, 0.1], [0.4, 0.6]])
    assert scaled(scaled(lopsided, 1.0, 0.1), 0.1, 1.0) == pytest.approx(lopsided, rel=1e-9)


@pytest.mark.parametrize(
    ("matrix", "complaint"),
    [
        (np.array([[0.9, 0.2], [0.4, 0.6]]), "rows that sum to 1"),
        (np.array([[0.1, 0.9], [0.9, 0.1]]), "no generator"),
        (np.array([[1.1, -0.1], [0.4, 0.6]]), "at least 0"),
    ],
)
def test_what_is_no_transition_matrix_is_refused(matrix: NDArray, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        scaled(matrix, 1.0, 0.5)


def test_a_bank_that_needs_its_road_says_so() -> None:
    with pytest.raises(ValueError, match="heights that the modes are given"):
        CompiledImm(oracle()).run(np.zeros((3, 1, 2)))
    with pytest.raises(ValueError, match="finite"):
        CompiledImm(oracle()).run(np.zeros((3, 1, 2)), np.full((3, 1, 4), np.nan))
    with pytest.raises(ValueError, match="valid: 1 or 4"):
        known_road([QUARTERS[:3]], 250e3)


def test_identification_finds_the_quarter_car_that_drove() -> None:
    """Accelerations of a quarter car over a class D road: its four parameters, and no error left."""
    rng = np.random.default_rng(5)
    cases = []
    for stiffness in (180e3, 240e3):
        road = synthesised(class_spectrum("D"), SPEED, 1e-3, 2 * 1600 - 1, rng)
        _, felt = ride(QUARTER, road, stiffness, 2e-3)
        cases.append(KnownCase(road, stiffness, felt, 2e-3))
    found = identify(QUARTER.sprung_mass, QUARTER.unsprung_mass, cases, 1)
    assert found.quarter.damping == pytest.approx(QUARTER.damping, rel=0.01)
    assert found.quarter.quadratic_damping == pytest.approx(QUARTER.quadratic_damping, rel=0.05)
    assert found.quarter.spring_rate == pytest.approx(QUARTER.spring_rate, rel=0.01)
    assert found.errors.shape == (2, 2)
    assert found.errors.max() < 0.02
    with pytest.raises(ValueError, match="cases"):
        identify(400.0, 60.0, [], 1)
