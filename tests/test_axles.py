"""Both axles over one road: response, bound, alignment, filter and alarm, each against something derived otherwise."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from estimators.axles.block import BINS, FREQUENCIES, SHARE, spectrum
from estimators.axles.bound import SharedRoad, difference_std, pressure_std
from estimators.axles.calibration import Identified
from estimators.axles.intake import SideIntake
from estimators.axles.likelihood import BAND, BANDS, LOSS, SLOPES, STATES, expect, score_block
from estimators.axles.parameters import NUMBERS
from estimators.axles.response import Axles, hub_responses
from estimators.axles.side import NOISE, Side
from estimators.quarter_car.bound import Setting, relative_stiffness_std
from estimators.quarter_car.quarter_car import QuarterCar, ride
from estimators.quarter_car.response import response
from estimators.quarter_car.road_shape import CORNER, class_spectrum, synthesised
from estimators.quarter_car.roughness import shape
from estimators.vertical_pressure.chain import Quarter
from estimators.vertical_pressure.intake import BLOCK

WHEELBASE, SPEED, LEVEL_B = 2.8, 20.0, class_spectrum("B")
POINT = Quarter(420.0, 58.0, 1e-3, 38e3, 3e3, 1e-4, 0.6, 0.005)  # no belt, no footprint: a plain quarter car
REAR_POINT = POINT._replace(sprung_mass=380.0, unsprung_mass=50.0)
STIFFNESS = (235e3, 250e3)
PLAIN = Axles(POINT, REAR_POINT, 0.0, WHEELBASE)
COUPLED = PLAIN._replace(coupling=5e-4)
ONES = np.ones(BINS)


def known(axles: Axles, told_std: float = 0.0) -> Identified:
    return Identified(axles, np.zeros((7, BINS)), np.zeros((7, BINS), complex), 0.0, 0.0, told_std, 0.0)


def responses(axles: Axles, speed: float = SPEED, ratio: float = 1.0) -> NDArray[np.complex128]:
    out = np.empty((2, BINS), complex)
    hub_responses(axles, *STIFFNESS, speed, ratio, FREQUENCIES, out)
    return out


def test_without_coupling_each_axle_is_the_quarter_car() -> None:
    found = responses(PLAIN)
    corner = CORNER * SPEED / (2.0 * np.pi)
    road = np.sqrt(SPEED / (2.0 * np.pi * (FREQUENCIES**2 + corner**2)))
    for axle, quarter in enumerate((POINT, REAR_POINT)):
        plain = QuarterCar(quarter.sprung_mass, quarter.unsprung_mass + 1e-3, 38e3, 0.0, 3e3, 0.0)
        wanted = response(plain, STIFFNESS[axle], FREQUENCIES)[:, 1] * road
        assert found[axle] == pytest.approx(wanted, rel=1e-3)  # contact and sidewall of the light belt in series


def test_coupled_axles_solve_the_four_mass_equations() -> None:
    """The same as a plain linear system of z_s, z_us, z_b of both axles, M z'' + C z' + K z = c_r z_r."""
    found = responses(COUPLED)
    body = np.linalg.inv([[1.0 / 420.0, 5e-4], [5e-4, 1.0 / 380.0]])
    for i in (0, 8, 15):
        w = 2.0 * np.pi * FREQUENCIES[i]
        A, b = np.zeros((6, 6), complex), np.zeros(6, complex)
        A[:2, :2] = -(w**2) * body
        for axle, k in enumerate(STIFFNESS):
            s, u, m = axle, 2 + axle, 4 + axle
            strut, side, contact = 38e3 + 1j * w * 3e3, 8.0 * k, 8.0 / 7.0 * k
            for p, q, stiff in ((s, u, strut), (u, m, side)):
                A[[p, q], [p, q]] += stiff
                A[[p, q], [q, p]] -= stiff
            A[u, u] -= w**2 * (58.0, 50.0)[axle]
            A[m, m] += contact - w**2 * 1e-3
            b[m] = contact * (np.exp(1j * w * WHEELBASE / SPEED) if axle == 0 else 1.0)
        z = np.linalg.solve(A, b)
        scale = -(w**2) * np.sqrt(SPEED / (2.0 * np.pi * (FREQUENCIES[i] ** 2 + (CORNER * SPEED / 2.0 / np.pi) ** 2)))
        assert found[0, i] == pytest.approx(scale * z[2] * np.exp(-1j * w * WHEELBASE / SPEED), rel=1e-6)
        assert found[1, i] == pytest.approx(scale * z[3], rel=1e-6)


def test_score_is_the_slope_of_the_log_likelihood_and_information_its_covariance() -> None:
    """Against differences of ln det S + Y^H S^-1 Y, and against the score's covariance over drawn blocks."""
    theta = np.array([*np.log(STIFFNESS), np.log(LEVEL_B), 0.01, 2.3, 1.7, *np.log([0.01, 0.03, 0.05, 0.1])])
    theta = np.concatenate([theta, np.linspace(-0.1, 0.1, NUMBERS)])
    rng = np.random.default_rng(1)
    H, slope = np.empty((2, BINS), complex), np.empty((SLOPES, 2, BINS), complex)
    score, J = np.empty(STATES), np.empty((STATES, STATES))
    flat = np.zeros((2, BINS), complex)

    def cost(at: NDArray[np.float64], Y: NDArray[np.complex128]) -> float:
        expect(COUPLED, at, SPEED, 1.0, flat + 1.0, flat, H, slope)
        return float(score_block(Y, H, slope, at, SPEED, ONES, NOISE, BAND, score, J))

    cost(theta, np.zeros((BINS, 2), complex))
    information = J.copy()
    lost, turn = np.exp(theta[LOSS + BAND]), np.exp(-2j * np.pi * FREQUENCIES * 0.01 / SPEED)
    wave = 2.0 * np.pi * FREQUENCIES / SPEED
    road = LEVEL_B * shape(wave, 2.3, 1.7) * wave**2
    S = road[:, None, None] * np.einsum("in,jn->nij", H, H.conj())
    S[:, 1, 0] *= (1.0 - lost) * turn
    S[:, 0, 1] = S[:, 1, 0].conj()
    root = np.linalg.cholesky(S + NOISE * np.eye(2))
    scores = []
    for _ in range(600):
        white = (rng.standard_normal((BINS, 2)) + 1j * rng.standard_normal((BINS, 2))) / np.sqrt(2.0)
        cost(theta, np.einsum("nij,nj->ni", root, white))
        scores.append(score.copy() / SHARE)
    found, scale = np.cov(np.array(scores).T), np.sqrt(np.diag(information))
    assert found / np.outer(scale, scale) * SHARE == pytest.approx(information / np.outer(scale, scale), abs=0.25)
    Y = np.einsum("nij,nj->ni", root, white)
    cost(theta, Y)
    told = score.copy()
    for i in range(STATES):
        step = 1e-5 * np.eye(STATES)[i]
        assert told[i] == pytest.approx(-(cost(theta + step, Y) - cost(theta - step, Y)) / 2e-5, rel=2e-3, abs=1e-3)


def test_information_of_a_block_is_the_bound_s_own_at_its_bins() -> None:
    """Compiled, term by term, against matrices and differences in numpy."""
    theta = np.array(
        [*np.log(STIFFNESS), np.log(LEVEL_B), 0.0, 2.0, 2.0, *np.full(BANDS, np.log(0.05)), *np.zeros(NUMBERS)]
    )
    H, slope = np.empty((2, BINS), complex), np.empty((SLOPES, 2, BINS), complex)
    score, J, flat = np.empty(STATES), np.empty((STATES, STATES)), np.zeros((2, BINS), complex)
    expect(COUPLED, theta, SPEED, 1.0, flat + 1.0, flat, H, slope)
    score_block(flat.T.copy(), H, slope, theta, SPEED, ONES, NOISE, BAND, score, J)
    road = SharedRoad(COUPLED, STIFFNESS, LEVEL_B, SPEED, 0.95)
    inverse = np.linalg.inv(road.matrix(np.zeros(LOSS), FREQUENCIES))
    shares = []
    for step in 1e-4 * np.eye(LOSS):
        shares.append(inverse @ (road.matrix(step, FREQUENCIES) - road.matrix(-step, FREQUENCIES)) / 2e-4)
    wanted = SHARE * np.array([[np.trace(p @ q, axis1=1, axis2=2).real.sum() for q in shares] for p in shares])
    scale = np.sqrt(np.diag(wanted))
    assert J[:LOSS, :LOSS] / np.outer(scale, scale) == pytest.approx(wanted / np.outer(scale, scale), abs=1e-4)


def test_bound_is_the_quarter_car_s_without_a_shared_road_and_the_known_figures_with_it() -> None:
    """Difference after 2 s for coherency 0.9, 0.98, 0.999: 2.7, 1.2, 0.3 %; 10.8 kPa a tyre after 10 s for 0.99."""
    twin = Axles(POINT, POINT, 0.0, WHEELBASE)
    alone = SharedRoad(twin, (230e3, 230e3), LEVEL_B, SPEED, 0.0, band=(0.5, 50.0), waviness_std=1e-9)
    quarter = QuarterCar(420.0, 58.0, 38e3, 0.0, 3e3, 0.0)
    setting = Setting(quarter, 230e3, LEVEL_B, SPEED, band=(0.5, 50.0))
    known_level, unknown = (relative_stiffness_std(setting, 2.0, level_std=s) for s in (0.0, np.inf))
    assert difference_std(alone, 2.0) == pytest.approx(np.sqrt(2.0) * known_level, rel=0.02)  # body adds 1 %
    common = np.sqrt(0.25 * difference_std(alone, 2.0) ** 2 + 0.5 * unknown**2)
    found, _ = pressure_std(alone, 2.0, 1.0)
    assert found < common * 1.02
    for c, wanted in ((0.9, 2.7), (0.98, 1.2), (0.999, 0.3)):
        shared = SharedRoad(
            twin, (230e3, 230e3), LEVEL_B, SPEED, c, noise_std=0.05, band=(0.5, 50.0), waviness_std=1e-9
        )
        assert 100.0 * difference_std(shared, 2.0) == pytest.approx(wanted, rel=0.15)


def rolled(seed: int, seconds: float, common: float = 1.0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Front and rear hub at 1 kHz of two plain quarter cars; the rear's road is the front's, a wheelbase later, mixed
    with one of its own."""
    rng = np.random.default_rng(seed)
    lag = round(2000.0 * WHEELBASE / SPEED)
    steps = round(2000.0 * seconds) | 1
    road = synthesised(LEVEL_B, SPEED, 5e-4, steps + lag, rng)
    own = synthesised(LEVEL_B, SPEED, 5e-4, steps, rng)
    there, here = road[lag:], common * road[:steps] + np.sqrt(1.0 - common**2) * own
    hubs = []
    for quarter, k, z in zip((POINT, REAR_POINT), STIFFNESS, (there, here), strict=True):
        plain = QuarterCar(quarter.sprung_mass, quarter.unsprung_mass + 1e-3, 38e3, 0.0, 3e3, 0.0)
        _, felt = ride(plain, z - z[0], k, 1e-3)
        hubs.append(felt[:, 1] + 9.81 + 0.5 * rng.standard_normal(len(felt)))
    return hubs[0], hubs[1]


def followed(front: NDArray[np.float64], rear: NDArray[np.float64]) -> Side:
    side = Side(known(PLAIN), np.log(np.array([240e3, 240e3])), np.full(2, 0.3))
    intake = SideIntake(WHEELBASE)
    for k in range(0, len(front) - BLOCK + 1, BLOCK):
        side.pass_time(BLOCK * 1e-3)
        window = intake.block(front[k : k + BLOCK], rear[k : k + BLOCK], np.full(BLOCK, SPEED))
        if window is not None:
            side.take(spectrum(window), SPEED, 1.0, ONES)
    return side


SECONDS = 10.0


@cache
def runs(common: float, count: int) -> NDArray[np.float64]:
    """Error of d, its stated std, error of ln k_f, its std, mean coherence, of each run."""
    found = []
    for seed in range(count):
        side = followed(*rolled(seed, SECONDS + 1.3, common))
        error = side.log_stiffness() - np.log(STIFFNESS)
        told = np.sqrt([side.difference_variance(), side.stiffness_variance()[0]])
        found.append([error[0] - error[1], told[0], error[0], told[1], float(side.coherence().mean())])
    return np.array(found)


def test_difference_reaches_its_bound_without_bias_on_a_road_that_is_shared() -> None:
    """Two plain quarter cars in time, against the bound in frequency: within 1.4, since coherence is measured too."""
    found = runs(0.99, 40)
    bound = difference_std(SharedRoad(PLAIN, STIFFNESS, LEVEL_B, SPEED, 0.99), SECONDS)
    assert 0.75 * bound < found[:, 0].std() < 1.4 * bound
    assert abs(found[:, 0].mean()) < 4.0 * found[:, 0].std() / np.sqrt(len(found))
    assert np.mean((found[:, 0] / found[:, 1]) ** 2) == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / len(found)))
    assert found[:, 4].mean() == pytest.approx(0.99, abs=0.01)
    assert abs(found[:, 2].mean()) < 4.0 * found[:, 2].std() / np.sqrt(len(found)) + 0.01  # the prior's pull
    assert np.mean((found[:, 2] / found[:, 3]) ** 2) < 1.0 + 4.0 * np.sqrt(2.0 / len(found))


def test_where_nothing_is_shared_it_says_no_more_than_single_wheels() -> None:
    found = runs(0.0, 25)
    alone = difference_std(SharedRoad(PLAIN, STIFFNESS, LEVEL_B, SPEED, 0.0), SECONDS)
    assert found[:, 1].mean() > 0.6 * alone
    assert np.mean((found[:, 0] / found[:, 1]) ** 2) < 1.0 + 4.0 * np.sqrt(2.0 / len(found))
    assert found[:, 4].mean() < 0.5
