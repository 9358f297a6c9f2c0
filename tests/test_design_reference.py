"""Run lengths and thresholds against published and independently computed values, and against each other."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import pytest
from scipy.stats import chi2, ncx2, norm

from estimators.detectors import (
    CusumMean,
    CusumVariance,
    Ewma,
    Integrator,
    LocalCusum,
    design_cusum_mean,
    design_cusum_variance,
    siegmund_run_length,
    siegmund_threshold,
    thesis_theta,
    variance_drift,
    wald_run_length,
)
from estimators.detectors.absorption import mean_steps
from estimators.detectors.cusum_run_length import gaussian_run_length, run_length
from estimators.detectors.increments import Filtered, Gaussian, NegativeSquared, Squared
from estimators.detectors.integrator_run_length import integrator_run_length

PRINTED = 6e-4  # relative: the tables below have four digits or more


@pytest.mark.parametrize(("h", "arl0", "arl1"), [(4.0, 335.37, 8.383), (5.0, 930.89, 10.376)])
def test_cusum_run_lengths_are_those_of_the_tables(h: float, arl0: float, arl1: float) -> None:
    """Montgomery, Introduction to Statistical Quality Control: k = 0.5."""
    one, two = CusumMean(0.5, h), CusumMean(0.5, h, "both")
    assert one.average_run_length().mean == pytest.approx(arl0, abs=0.006)
    assert one.average_run_length(1.0).mean == pytest.approx(arl1, abs=6e-4)
    assert two.average_run_length().mean == pytest.approx(arl0 / 2.0, abs=0.006)
    assert CusumMean(0.5, h, "lower").average_run_length(-1.0).mean == pytest.approx(arl1, abs=6e-4)


@pytest.mark.parametrize(
    ("drift", "thresholds"),
    [(0.25, (8.585, 17.705, 26.914)), (0.5, (5.071, 9.662, 14.267)), (1.0, (2.665, 4.965, 7.268))],
)
def test_cusum_thresholds_for_run_lengths_of_1e3_1e5_1e7(drift: float, thresholds: tuple[float, ...]) -> None:
    for arl0, h in zip((1e3, 1e5, 1e7), thresholds, strict=True):
        design = design_cusum_mean(2.0 * drift, arl0)
        assert design.detector.level == pytest.approx(h, abs=6e-4)
        assert design.arl0.mean == pytest.approx(arl0, rel=1e-4)


def test_the_leak_alarm_of_seed_000_fires_every_22_5_samples() -> None:
    """Drift 0.2, threshold 3.5: 1.12 s at its 20 Hz; two-sided thresholds for 1 h and 100 h."""
    assert CusumMean(0.2, 3.5).average_run_length().mean == pytest.approx(44.9, abs=0.05)
    assert CusumMean(0.2, 3.5, "both").average_run_length().mean == pytest.approx(22.5, abs=0.05)
    for hours, h in ((1.0, 22.2), (100.0, 33.7)):
        assert design_cusum_mean(0.4, hours * 3600.0 * 20.0, "both").detector.level == pytest.approx(h, abs=0.06)


@pytest.mark.parametrize(("weight", "limit", "arl0", "arl1"), [(0.1, 2.814, 499.6, 10.33), (0.05, 2.615, 499.9, 11.38)])
def test_gma_run_lengths_are_those_of_lucas_and_saccucci(weight: float, limit: float, arl0: float, arl1: float) -> None:
    gma = Ewma(1.0 - weight, limit * sqrt(weight / (2.0 - weight)), "both")
    assert gma.average_run_length().mean == pytest.approx(arl0, abs=0.06)
    assert gma.average_run_length(1.0).mean == pytest.approx(arl1, abs=6e-3)


@pytest.mark.parametrize(
    ("theta", "sigma", "printed"),
    [
        (5.0, 1.0, (0.3995, 2.2409)),
        (5.0, 5.0, (17.4711, 63.2476)),
        (10.0, 1.0, (-0.2449, 0.6761)),
        (10.0, 5.0, (9.1921, 32.1745)),
        (15.0, 1.0, (-0.4979, 0.1161)),
        (15.0, 5.0, (5.5217, 20.8579)),
    ],
)
def test_the_twelve_thresholds_of_the_thesis_are_siegmunds(theta: float, sigma: float, printed: tuple) -> None:
    """Figures 4.7 to 4.12, with sigma the number that they call sigma^2."""
    for far, h in zip((200.0, 2e6), printed, strict=True):
        assert siegmund_threshold(theta / 2.0, far, sigma) == pytest.approx(h, abs=1e-4)
        if h > 0.0:
            assert siegmund_run_length(h, theta / 2.0, 0.0, sigma) == pytest.approx(far, rel=PRINTED)


def test_a_threshold_of_the_thesis_really_gives_533_samples() -> None:
    assert CusumMean(2.5, 0.3995).average_run_length().mean == pytest.approx(533.0, abs=0.5)


def test_no_threshold_is_returned_where_none_is_needed() -> None:
    """theta 10, sigma 1: any sample above the drift alarms, once in 1 / P(x > 5) samples."""
    design = design_cusum_mean(10.0, 200.0)
    assert design.detector.level == 0.0
    assert design.arl0.mean == pytest.approx(1.0 / norm.sf(5.0), rel=1e-9)
    assert design.arl0.mean == pytest.approx(3.5e6, rel=0.01)


@pytest.mark.parametrize(
    ("before", "after", "right", "printed"),
    [
        (1.0, 3.0, 1.6479, 2.7156),
        (1.0, 5.0, 2.0118, 4.0473),
        (3.0, 5.0, 1.2771, 4.8927),
        (3.0, 10.0, 1.7200, 8.8748),
        (5.0, 10.0, 1.3863, 9.6091),
        (5.0, 20.0, 1.8484, 17.0828),
    ],
)
def test_theta_of_a_variance_change(before: float, after: float, right: float, printed: float) -> None:
    assert variance_drift(before, after) == pytest.approx(right, abs=6e-5)
    assert thesis_theta(before, after) == pytest.approx(printed, rel=1e-4)
    ratio = after / before  # the log-likelihood ratio of y^2 / S0 is 0 at theta
    assert 0.5 * (1.0 - 1.0 / ratio) * variance_drift(before, after) == pytest.approx(0.5 * np.log(ratio))


@pytest.mark.parametrize(("arl0", "h", "delay"), [(200.0, 8.15, 7.9), (2e4, 21.65, 17.9), (2e6, 35.46, 28.1)])
def test_design_for_a_variance_change_from_1_to_3(arl0: float, h: float, delay: float) -> None:
    design = design_cusum_variance(1.0, 3.0, arl0)
    assert design.detector.level == pytest.approx(h, abs=6e-3)
    assert design.delay.mean == pytest.approx(delay, abs=0.06)
    assert design.arl0.mean == pytest.approx(arl0, rel=1e-4)


# --- two derivations of the same run length


@pytest.mark.parametrize("mean", [-0.3, 0.0, 1.0])
def test_collocation_agrees_with_nystrom(mean: float) -> None:
    quadrature = gaussian_run_length(4.0, 0.5, mean, 1.3)
    assert run_length(4.0, 0.5, Gaussian(mean, 1.3)) == pytest.approx(quadrature, rel=1e-5)


def test_a_brook_evans_chain_converges_to_the_same_run_length() -> None:
    """Brook & Evans 1972: states of width w = 2 h / (2 n - 1), all of a cell at its centre; error of order w^2."""
    h, k, lengths = 4.0, 0.5, []
    for n in (100, 200, 400):
        width = 2.0 * h / (2 * n - 1)
        upper = (np.arange(n)[None, :] - np.arange(n)[:, None] + 0.5) * width + k
        steps = np.diff(norm.cdf(upper), axis=1, prepend=0.0)
        steps[:, 0] = norm.cdf(upper[:, 0])
        lengths.append(np.linalg.solve(np.eye(n) - steps, np.ones(n))[0])
    exact = gaussian_run_length(h, k)
    errors = np.abs(np.array(lengths) - exact)
    assert errors[-1] < 3e-5 * exact
    assert errors[:-1] / errors[1:] == pytest.approx([4.0, 4.0], abs=0.3)


def test_a_threshold_on_single_samples_has_the_run_length_of_a_geometric_distribution() -> None:
    """AC, GMA without memory, CUSUM and variance CUSUM without threshold, and a GLR of one sample are one detector."""
    chance = 2.0 * norm.sf(2.5)
    assert Integrator(1, 2.5).average_run_length().mean == pytest.approx(1.0 / chance)
    assert Ewma(0.0, 2.5, "both").average_run_length().mean == pytest.approx(1.0 / chance)
    assert CusumMean(2.5, 0.0, "both").average_run_length().mean == pytest.approx(1.0 / chance)
    assert CusumVariance(6.25, 0.0).average_run_length().mean == pytest.approx(1.0 / chance)
    assert CusumVariance(0.3, 0.0, "decrease").average_run_length().mean == pytest.approx(1.0 / chi2.cdf(0.3, 1))


def test_an_integrator_of_two_samples_by_hand() -> None:
    """e1 = P(|x| > h), e2 = P(|x| <= h, |x + y| > h); L = (1 + 1 - e1) / (e1 + e2)."""
    x = np.linspace(-2.0, 2.0, 20001)
    e1 = 2.0 * norm.sf(2.0)
    e2 = np.trapezoid(norm.pdf(x) * (norm.sf(2.0 - x) + norm.cdf(-2.0 - x)), x)
    assert integrator_run_length(2.0, 2, True) == pytest.approx((2.0 - e1) / (e1 + e2), rel=1e-7)


def test_a_wide_limit_makes_a_local_cusum_a_cusum() -> None:
    wide = LocalCusum((12.0,), (0.5,), (4.0,), "both").average_run_length().mean
    assert wide == pytest.approx(CusumMean(0.5, 4.0, "both").average_run_length().mean, rel=1e-5)
    assert LocalCusum((inf,), (0.5,), (4.0,)).average_run_length().mean == pytest.approx(335.37, abs=0.006)


def test_very_long_run_lengths_keep_growing_by_the_same_factor() -> None:
    """exp(2 k) per unit of threshold; far beyond where a linear solver in double precision fails."""
    for k in (0.25, 0.5):
        lengths = [gaussian_run_length(h / k, k) for h in (12.0, 12.5, 14.0, 14.5)]
        assert lengths[-1] > 1e12
        assert lengths[1] / lengths[0] == pytest.approx(np.e, rel=1e-6)
        assert lengths[3] / lengths[2] == pytest.approx(np.e, rel=1e-6)


def test_state_reduction_solves_the_linear_system() -> None:
    steps = np.random.default_rng(0).random((40, 40))
    steps /= 1.01 * steps.sum(axis=1, keepdims=True)
    expected = np.linalg.solve(np.eye(40) - steps, np.ones(40))[0]
    assert mean_steps(steps.copy(), 1.0 - steps.sum(axis=1)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("drift", [0.25, 0.5, 1.0])
def test_siegmund_is_close_and_wald_is_not(drift: float) -> None:
    exact = gaussian_run_length(4.0 / drift, drift)
    assert siegmund_run_length(4.0 / drift, drift) == pytest.approx(exact, rel=0.06)
    assert wald_run_length(4.0 / drift, drift) < 0.75 * exact
    assert siegmund_run_length(3.0, 0.5, 0.5) == pytest.approx((3.0 + 1.166) ** 2)


@pytest.mark.parametrize(
    ("increments", "cdf"),
    [
        (Gaussian(0.4, 1.5), lambda u: norm.cdf(u, 0.4, 1.5)),
        (Squared(0.0, 1.5), lambda u: chi2.cdf(u / 2.25, 1)),
        (Squared(0.6, 1.5), lambda u: ncx2.cdf(u / 2.25, 1, 0.16)),
        (NegativeSquared(0.0, 1.5), lambda u: chi2.sf(-u / 2.25, 1)),
        (
            Filtered(0.4, 1.5, 2.0),
            lambda u: (
                np.where(u >= 0, norm.sf(2, 0.4, 1.5) + norm.cdf(-2, 0.4, 1.5), 0)
                + norm.cdf(np.clip(u, -2, 2), 0.4, 1.5)
                - norm.cdf(-2, 0.4, 1.5)
            ),
        ),
    ],
)
def test_distributions_of_increments(increments: Gaussian, cdf: object) -> None:
    """Against scipy's; the partial mean is u F(u) minus the integral of F (by parts)."""
    u = np.linspace(-12.0, 25.0, 37001)
    expected = cdf(u)  # type: ignore[operator]
    np.testing.assert_allclose(increments.cdf(u), expected, atol=1e-12)
    np.testing.assert_allclose(increments.tail(u), 1.0 - expected, atol=1e-12)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (expected[1:] + expected[:-1]) * np.diff(u))])
    start = u[0] * expected[0] - increments.partial_mean(u[:1])[0]
    np.testing.assert_allclose(increments.partial_mean(u), u * expected - area - start, atol=2e-3)
