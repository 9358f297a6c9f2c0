"""Claims about the slip kernel: against its plain twin, closed forms, an independent evaluator, and by symmetry."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest

from models.slip_coefficients import SLIP_NAMES
from models.tir import ODD
from models.tyre_properties import TyreProperties, load_tyre, tyre_names
from testbed.tyre import magic_formula
from testbed.tyre.magic_formula import slip_forces, slip_stiffness
from testbed.tyre.reference import cornering_stiffness, longitudinal_slip_stiffness, reference_slip_forces

ROUNDING = 1e-12  # of load (or load times radius): the two transcriptions differ by the order of operations alone
SPEED = 20.0  # m/s, where the fade of the offsets is within 0.1 % of one


@pytest.fixture(params=tyre_names())
def tyre(request: pytest.FixtureRequest) -> TyreProperties:
    return load_tyre(request.param)


@pytest.fixture
def book() -> TyreProperties:
    return load_tyre("book-205-60r15")


def without_offsets(tyre: TyreProperties) -> TyreProperties:
    """The same tyre without shifts of its curves, where slopes and peaks have closed forms."""
    shifts = (*ODD, "phx1", "phx2", "pvx1", "pvx2", "pex4", "rhy1", "rhy2")
    return dataclasses.replace(tyre, **dict.fromkeys(shifts, 0.0))


def random_inputs(tyre: TyreProperties, count: int, seed: int) -> list[tuple[float, ...]]:
    """kappa, tan_alpha, gamma, fz, pressure, v_x, mu, side; slips with the long tails of a Cauchy distribution."""
    rng = np.random.default_rng(seed)
    return [
        (0.1 * rng.standard_cauchy(), 0.1 * rng.standard_cauchy(), rng.normal(0.0, 0.1), rng.uniform(0.0, 25e3),
         rng.uniform(0.0, 2.0 * tyre.p0), rng.normal(0.0, 10.0), rng.uniform(0.05, 1.2), rng.choice((-1.0, 1.0)))
        for _ in range(count)
    ]  # fmt: skip


def test_index_constants_follow_the_list_of_names():
    for place, name in enumerate(SLIP_NAMES):
        assert getattr(magic_formula, name.upper()) == place


def test_kernel_equals_the_equations_written_out(tyre):
    q = tyre.slip_array()
    for inputs in random_inputs(tyre, 1500, seed=1):
        scale = max(inputs[3], 1.0) * np.array([1.0, 1.0, tyre.r0])
        difference = np.subtract(slip_forces(q, *inputs), reference_slip_forces(tyre, *inputs))
        assert np.all(np.abs(difference) <= ROUNDING * scale), inputs


def test_kernel_equals_the_equations_with_every_coefficient_in_play(tyre):
    """The sets hold zeros; here every coefficient is at work, so that a wrong index cannot hide."""
    rng = np.random.default_rng(2)
    coefficients = [name for name in SLIP_NAMES if name not in ("fz0", "p0", "r0")]
    changed = {n: getattr(tyre, n) * rng.uniform(0.9, 1.1) + rng.uniform(0.005, 0.02) for n in coefficients}
    full = dataclasses.replace(tyre, **changed)
    for inputs in random_inputs(full, 500, seed=3):
        scale = max(inputs[3], 1.0) * np.array([1.0, 1.0, full.r0])
        difference = np.subtract(slip_forces(full.slip_array(), *inputs), reference_slip_forces(full, *inputs))
        assert np.all(np.abs(difference) <= ROUNDING * scale), inputs


def test_an_independent_evaluator_gives_the_same_forces(book):
    """Expected values of a public C++ MF 6.1.2 evaluator's unit test, with its scaling factors folded in (A_mu = 10).

    Fz 4 kN, alpha .05, kappa .06, gamma .07: Fx 3902.7354, Fy -2511.1272 N, Mz -15.647495 N m. It takes the angles
    themselves where the book has tan alpha and sin gamma, and the paper's alpha_eq, which leaves up to 0.5 % in Mz.
    """
    digressive = {axis: 10.0 * mu / (1.0 + 9.0 * mu) for axis, mu in (("x", 1.28), ("y", 1.38))}
    factors = dict.fromkeys(("pdx1", "pdx2"), 1.28) | dict.fromkeys(("pkx1", "pkx2"), 1.22)
    factors |= dict.fromkeys(("pdy1", "pdy2", "qdz6", "qdz7", "qdz8", "qdz9"), 1.38) | {"pky1": 1.28, "rby1": 1.08}
    factors |= dict.fromkeys(("pky6", "pky7"), 1.18) | dict.fromkeys(("pvy3", "pvy4"), 1.18 * digressive["y"])
    factors |= dict.fromkeys(("pvy1", "pvy2"), digressive["y"]) | dict.fromkeys(("qdz1", "qdz2"), 0.86)
    factors |= dict.fromkeys(("qbz1", "qbz2", "qbz9"), 1.28 / 1.38) | {"pvx2": digressive["x"]}
    scaled = dataclasses.replace(book, **{name: getattr(book, name) * factor for name, factor in factors.items()})
    scaled = dataclasses.replace(scaled, pcy1=1.337, pvx1=2.20283e-5 * digressive["x"])
    fx, fy, mz = slip_forces(scaled.slip_array(), 0.06, 0.05, math.asin(0.07), 4000.0, book.p0, 1e3, 1.0, 1.0)
    assert fx == pytest.approx(3902.7354, rel=1e-5)
    assert fy == pytest.approx(-2511.1272, rel=1e-4)
    assert mz == pytest.approx(-15.647495, rel=6e-3)


@pytest.mark.parametrize("share", [0.3, 0.75, 1.0, 1.25])
@pytest.mark.parametrize("fz", [1000.0, 4000.0, 9000.0])
def test_slope_at_zero_slip_is_the_slip_stiffness(tyre, fz, share):
    plain, step = without_offsets(tyre), 1e-6
    pressure = share * tyre.p0
    q = plain.slip_array()
    kx, ky = slip_stiffness(q, fz, pressure)

    def force(kappa: float, tan_alpha: float) -> tuple[float, float, float]:
        return slip_forces(q, kappa, tan_alpha, 0.0, fz, pressure, SPEED, 1.0, 1.0)

    slope_x = (force(step, 0.0)[0] - force(-step, 0.0)[0]) / (2.0 * step)
    slope_y = (force(0.0, step)[1] - force(0.0, -step)[1]) / (2.0 * step)
    finite_difference = 1e-6  # relative error of a central difference with this step
    assert slope_x == pytest.approx(kx, rel=finite_difference)
    assert slope_y == pytest.approx(-ky, rel=finite_difference)


def test_slip_stiffness_is_that_of_the_equations_and_positive(tyre):
    q = tyre.slip_array()
    for fz in (1e-3, 100.0, 4000.0, 12e3, 60e3):
        for pressure in (0.5 * tyre.p0, tyre.p0, 2.0 * tyre.p0):
            dfz, dpi = min(fz / tyre.fz0 - 1.0, 2.0), pressure / tyre.p0 - 1.0
            kx, ky = slip_stiffness(q, fz, pressure)
            assert kx == pytest.approx(longitudinal_slip_stiffness(tyre, fz, dfz, dpi), rel=ROUNDING)
            assert ky == pytest.approx(-cornering_stiffness(tyre, fz, dpi, 0.0), rel=ROUNDING)
            assert min(kx, ky) > 0.0


def test_largest_force_is_friction_times_load(tyre):
    plain, slips = without_offsets(tyre), np.linspace(0.0, 0.5, 5001)
    q = plain.slip_array()
    for mu in (1.0, 0.3):
        fx = max(slip_forces(q, s, 0.0, 0.0, plain.fz0, plain.p0, SPEED, mu, 1.0)[0] for s in slips)
        fy = min(slip_forces(q, 0.0, s, 0.0, plain.fz0, plain.p0, SPEED, mu, 1.0)[1] for s in slips)
        grid = 1e-4  # the peak is flat: a step of 1e-4 in slip misses less
        assert fx == pytest.approx(mu * plain.pdx1 * plain.fz0, rel=grid)
        assert fy == pytest.approx(-mu * plain.pdy1 * plain.fz0, rel=grid)


def test_signs_are_those_of_iso_8855(tyre):
    q = tyre.slip_array()
    driving = slip_forces(q, 0.03, 0.0, 0.0, tyre.fz0, tyre.p0, SPEED, 1.0, 1.0)
    leftward = slip_forces(q, 0.0, 0.03, 0.0, tyre.fz0, tyre.p0, SPEED, 1.0, 1.0)
    leaning_right = slip_forces(q, 0.0, 0.0, 0.1, tyre.fz0, tyre.p0, SPEED, 1.0, 1.0)
    assert driving[0] > 0.0
    assert leftward[1] < 0.0 < leftward[2]  # the trail turns the wheel into its direction of motion
    assert leaning_right[1] < 0.0  # camber thrust points where the tyre leans


def test_book_pressure_figures(book):
    """A quarter less pressure at 4 kN: Kx +11 %, Ky +15 % (rounded figures)."""
    q, rounding = book.slip_array(), 0.006
    nominal, low = slip_stiffness(q, 4000.0, book.p0), slip_stiffness(q, 4000.0, 0.75 * book.p0)
    assert low[0] / nominal[0] - 1.0 == pytest.approx(0.11, abs=rounding)
    assert low[1] / nominal[1] - 1.0 == pytest.approx(0.15, abs=rounding)


def test_slip_is_frozen_below_half_the_nominal_pressure(tyre):
    q = tyre.slip_array()
    half, flat = (slip_forces(q, 0.03, 0.04, 0.02, tyre.fz0, p, SPEED, 1.0, 1.0) for p in (0.5 * tyre.p0, 0.0))
    assert half == flat
    assert half != slip_forces(q, 0.03, 0.04, 0.02, tyre.fz0, 0.6 * tyre.p0, SPEED, 1.0, 1.0)


def test_mirrored_pair_gives_no_net_side_force_straight_ahead(tyre):
    q = tyre.slip_array()
    left = slip_forces(q, 0.01, 0.0, -0.01, tyre.fz0, tyre.p0, SPEED, 1.0, 1.0)
    right = slip_forces(q, 0.01, 0.0, 0.01, tyre.fz0, tyre.p0, SPEED, 1.0, -1.0)
    assert abs(left[1]) > 1.0  # there is something to cancel [N]
    assert right == (left[0], -left[1], -left[2])


def test_mirror_is_the_set_with_its_asymmetric_coefficients_reversed(tyre):
    mirrored = dataclasses.replace(tyre, **{name: -getattr(tyre, name) for name in ODD})
    for inputs in random_inputs(tyre, 200, seed=4):
        expected = slip_forces(mirrored.slip_array(), *inputs[:-1], 1.0)
        scale = max(inputs[3], 1.0)
        assert np.allclose(slip_forces(tyre.slip_array(), *inputs[:-1], -1.0), expected, rtol=0.0, atol=1e-12 * scale)


def test_reversing_is_the_same_tyre_seen_from_the_other_end(tyre):
    q = tyre.slip_array()
    for kappa, tan_alpha, gamma, fz, pressure, v_x, mu, side in random_inputs(tyre, 200, seed=5):
        ahead = slip_forces(q, kappa, tan_alpha, gamma, fz, pressure, abs(v_x), mu, side)
        back = slip_forces(q, -kappa, -tan_alpha, -gamma, fz, pressure, -abs(v_x), mu, side)
        assert back == (-ahead[0], -ahead[1], ahead[2])


def test_forces_are_continuous_through_standstill(tyre):
    q = tyre.slip_array()
    for kappa, tan_alpha, gamma, fz, pressure, _, mu, side in random_inputs(tyre, 200, seed=6):
        ahead, back = (slip_forces(q, kappa, tan_alpha, gamma, fz, pressure, v, mu, side) for v in (1e-6, -1e-6))
        offsets = 1e-9 * max(fz, 1.0)  # what the offsets' factor v^2/(v^2 + 0.25) leaves at 1e-6 m/s
        assert np.allclose(ahead, back, rtol=0.0, atol=offsets)


def test_symmetric_standing_tyre_is_without_force(tyre):
    assert slip_forces(tyre.slip_array(), 0.0, 0.0, 0.0, tyre.fz0, tyre.p0, 0.0, 1.0, 1.0) == (0.0, 0.0, 0.0)


def test_combined_slip_reduces_both_forces(tyre):
    q = without_offsets(tyre).slip_array()

    def force(kappa: float, tan_alpha: float) -> tuple[float, float, float]:
        return slip_forces(q, kappa, tan_alpha, 0.0, tyre.fz0, tyre.p0, SPEED, 1.0, 1.0)

    braking = [force(-0.1, slip)[0] / force(-0.1, 0.0)[0] for slip in (0.05, 0.1, 0.2, 0.4)]
    cornering = [force(slip, 0.1)[1] / force(0.0, 0.1)[1] for slip in (-0.05, -0.1, -0.2, -0.4)]
    for ratios in (braking, cornering):
        assert all(late < early < 1.0 for early, late in pairwise(ratios))
        assert ratios[-1] > 0.0


def test_friction_scales_sliding_and_spares_the_slip_stiffness(tyre):
    q = without_offsets(tyre).slip_array()
    for kappa, tan_alpha, axis in ((1e-6, 0.0, 0), (0.0, 1e-6, 1)):
        full, icy = (
            slip_forces(q, kappa, tan_alpha, 0.0, tyre.fz0, tyre.p0, SPEED, mu, 1.0)[axis] for mu in (1.0, 0.1)
        )
        assert icy == pytest.approx(full, rel=1e-6)
    full, icy = (slip_forces(q, -1e3, 0.0, 0.0, tyre.fz0, tyre.p0, SPEED, mu, 1.0)[0] for mu in (1.0, 0.1))
    assert icy == pytest.approx(0.1 * full, rel=1e-3)  # both far on the sliding branch


def test_any_input_gives_bounded_forces(tyre):
    q = tyre.slip_array()
    slips = (-1e3, -1.0, -0.1, 0.0, 0.1, 1.0, 1e3)
    for fz in (-10.0, 0.0, 1e-9, 1e-3, 1.0, 4e3, 2e5):
        for pressure in (0.0, 0.5 * tyre.p0, 2.0 * tyre.p0):
            for kappa in slips:
                for tan_alpha in slips:
                    forces = slip_forces(q, kappa, tan_alpha, 0.2, fz, pressure, 1.0, 1.0, 1.0)
                    assert np.all(np.abs(forces) <= 2.0 * max(fz, 0.0)), (fz, pressure, kappa, tan_alpha)
    assert slip_forces(q, 0.1, 0.1, 0.1, 0.0, tyre.p0, SPEED, 1.0, 1.0) == (0.0, 0.0, 0.0)


def test_forces_grow_from_zero_load_without_a_jump(tyre):
    q = tyre.slip_array()
    light = np.array(slip_forces(q, 0.02, 0.03, 0.01, 1e-3, tyre.p0, SPEED, 1.0, 1.0))
    double = np.array(slip_forces(q, 0.02, 0.03, 0.01, 2e-3, tyre.p0, SPEED, 1.0, 1.0))
    assert np.allclose(double[:2], 2.0 * light[:2], rtol=1e-4)  # proportional to load near zero
