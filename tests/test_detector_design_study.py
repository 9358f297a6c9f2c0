"""Claims of the study `detector-design`: what the thesis' numbers follow from; its parts measure what they say."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import pytest
from scipy.stats import norm

from estimators.detectors import siegmund_threshold, thesis_theta, variance_drift
from estimators.detectors.cusum import variance_run_length
from testbed.study.detector_design import designs, thresholds, variance
from testbed.study.detector_design.conformed import gaussian_distance
from testbed.study.detector_design.detector_design import DetectorDesignStudy, simulate
from testbed.study.detector_design.figures_of_curves import curves
from testbed.study.detector_design.figures_of_residuals import conformed
from testbed.study.detector_design.rates import clustered_rate, inverse, pooled_rate
from testbed.study.detector_design.residuals import (
    ACTIVE,
    CALM,
    LIVELY,
    RANGE,
    SHARES,
    conform,
    residuals,
    seen_locally,
)
from testbed.study.detector_design.thesis import CONFORMED, CONFORMED_ASKED, THRESHOLDS, VARIANCE_CHANGES

PRINTED = 6e-5  # thresholds have four decimals
ROUNDED = 1e-3  # relative: sigma has three digits, E(y^2) is a sample's
SIGMAS = 4.0


def test_the_twelve_thresholds_are_siegmunds_with_sigma_read_as_variance():
    assert len(THRESHOLDS) == 12
    for t in THRESHOLDS:
        assert siegmund_threshold(t.drift, t.asked, t.variance) == pytest.approx(t.printed, abs=PRINTED)
        if t.variance != 1.0:
            assert abs(siegmund_threshold(t.drift, t.asked, sqrt(t.variance)) - t.printed) > 4.0


def test_the_first_threshold_gives_533_samples_and_so_eight_false_alarms_in_45_s():
    found = thresholds.exact_run_length(THRESHOLDS[0], 1.0)
    assert found == pytest.approx(533.0, abs=0.5)
    assert 45.0 * 100.0 / found == pytest.approx(8.0, abs=0.5)


def test_a_negative_threshold_alarms_at_every_sample_and_needs_be_no_more_than_zero():
    negative = [t for t in THRESHOLDS if t.printed < 0.0]
    assert [t.figure for t in negative] == ["4.9", "4.11"]
    for t in negative:
        assert thresholds.exact_run_length(t, 1.0) == 1.0
        assert thresholds.exact_threshold(t.drift, t.asked, 1.0) == 0.0


def test_thresholds_of_the_residuals_are_siegmunds_too():
    for case in CONFORMED:
        found = siegmund_threshold(case.drift, CONFORMED_ASKED, case.sigma)
        assert found == pytest.approx(case.threshold, rel=ROUNDED)


def test_all_four_thetas_of_the_variance_table_rest_on_one_mean_square():
    """sigma*^4 / 15.67^2: only the first residuals have that."""
    for case in CONFORMED:
        s0, s1 = case.sigma**2, (case.sigma + 0.01) ** 2
        star = variance_drift(s0, s1) * s0
        assert star**2 / variance.SHARED_SIGMA**2 == pytest.approx(case.theta_of_variance, rel=ROUNDED)


def test_the_thesis_theta_finds_the_change_on_the_square_itself_and_not_always_as_its_equations_stand():
    blind = []
    for change in VARIANCE_CHANGES:
        theta = thesis_theta(change.before, change.after)
        assert theta == pytest.approx(change.theta, rel=2e-3)
        assert change.before < theta < change.after
        if theta > change.after / change.before:
            blind.append(change.figure)
    assert blind == ["4.29", "4.30", "4.31", "4.32"]


@pytest.mark.parametrize(("threshold", "theta"), [(20.0, 2.7156), (15.0, 4.0473)])
def test_run_lengths_of_a_variance_are_extrapolated_to_ten_percent(threshold, theta, monkeypatch):
    monkeypatch.setattr(variance, "RESOLVED", 5.0)
    variance.run_length.cache_clear()
    assert variance.run_length(threshold, theta) == pytest.approx(
        variance_run_length(threshold, theta, "increase"), rel=0.15
    )
    variance.run_length.cache_clear()


def _spread(cut, zeros):
    """Standard deviation of the states' mixture within the cut, in closed form."""
    mass, second = SHARES[0] * zeros, 0.0
    for share, s in zip(SHARES[1:], (CALM, LIVELY, ACTIVE), strict=True):
        a = cut / s
        inside = norm.cdf(a) - norm.cdf(-a)
        mass += share * inside
        second += share * s * s * (inside - 2.0 * a * norm.pdf(a))
    return sqrt(second / mass)


def test_simulated_residuals_have_the_stated_spreads():
    for case in CONFORMED:
        assert _spread(case.cut, case.zeros) == pytest.approx(case.sigma, rel=ROUNDED)
    assert sum(SHARES) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("hold", [1, 50])
def test_residuals_keep_to_the_range_and_differ_in_bursts_by_their_order_alone(hold):
    r = residuals(hold)(np.random.default_rng(1), 1 << 19)
    assert RANGE[0] <= r.min()
    assert r.max() <= RANGE[1]
    assert conform(r, 100.0, True).std() == pytest.approx(20.7, rel=0.03)
    large = np.abs(r) > 150.0
    together = (large[1:] & large[:-1]).mean() / large.mean()
    assert (together > 0.5) == (hold > 1)


def test_gaussian_residuals_are_near_a_gaussian_and_cut_ones_are_not():
    r = np.random.default_rng(2).normal(3.0, 2.0, 100_000)
    assert gaussian_distance(r) < 0.005
    assert gaussian_distance(np.where(np.abs(r) < 1.0, 0.0, r)) > 0.05


def test_a_local_detector_is_shown_nothing_beyond_its_limit():
    x = seen_locally(lambda generator, n: np.linspace(-3.0, 3.0, n), 1.0)(np.random.default_rng(0), 7)
    assert x.tolist() == [0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0]


def test_simulated_false_alarms_are_those_of_the_exact_run_length():
    row = simulate(thresholds.tasks(3, 0, True)[0])
    compared = 0
    for (threshold, _, std), alarms, samples in zip(thresholds.CASES, row["alarms"], row["samples"], strict=True):
        expected = samples / thresholds.exact_run_length(threshold, std)
        if expected > 20.0:
            compared += 1
            assert abs(alarms - expected) <= SIGMAS * sqrt(expected)
    assert compared == 6


def _rows_of(ratio):
    """400 run lengths of mean 100 and of standard deviation 100, where 100 * ratio is stated."""
    count = 400
    one = {"asked": 100.0, "stated": 100.0 * ratio, "method": "made up", "count": count, "sum": 100.0 * count,
           "squares": 2.0 * 100.0**2 * count}  # fmt: skip
    return [{"part": designs.PART, "kind": "CUSUM", "designs": [one]} for _ in range(25)]


def test_a_stated_run_length_that_is_off_is_the_worst_and_is_objected_to():
    study = DetectorDesignStudy()
    good, bad = _rows_of(1.01), _rows_of(1.10)
    assert study.objections(good) == []
    assert len(study.objections(bad)) == 1
    first = next(iter(designs.table(bad)))
    assert first.name == "arl0_exact_over_simulated"
    assert first.limit == 1.0
    assert first.here == pytest.approx(1.10)
    assert first.ci95[0] < 1.10 < first.ci95[1]


def test_at_least_30_designs_of_every_kind_reach_from_1e2_to_1e5():
    tasks = [t for t in DetectorDesignStudy().tasks(1, 0, False) if t["part"] == designs.PART]
    compared = {(t["kind"], asked) for t in tasks for asked, _ in t["alarms"]}
    assert len(compared) >= 30
    assert {asked for _, asked in compared} == {1e2, 1e3, 1e4, 1e5}
    assert {type(designs.KINDS[kind](100.0).detector).__name__ for kind, _ in compared} == {
        "CusumMean", "CusumVariance", "Ewma", "Glr", "LocalCusum", "Integrator",
    }  # fmt: skip


def test_alarms_that_come_together_are_known_less_well_than_independent_ones():
    counts, samples = [0, 40, 0, 40], [1000] * 4
    together, alone = clustered_rate(counts, samples), pooled_rate(counts, samples)
    assert together.value == alone.value == 0.02
    assert together.low < alone.low
    assert together.high > alone.high
    assert clustered_rate([0, 0], [1000, 1000]).high > 0.0
    assert clustered_rate([3], [1000]).high == inf
    assert inverse(pooled_rate([0], [1000])).high == inf


def test_exact_curves_lie_where_the_figures_of_the_thesis_put_them():
    """Figures that the small form leaves out: drawn, and a delay is never below one sample, no threshold below 0."""
    drawn = curves() | conformed()
    assert len(drawn) == 4
    for axes in drawn["figures-4.1-4.3-delay"].axes:
        thesis, exact = (line.get_ydata() for line in axes.lines[:2])
        assert min(exact) >= 1.0
        assert min(thesis) > 0.0
    assert min(min(axes.lines[1].get_ydata()) for axes in drawn["figures-4.4-4.6-threshold"].axes) == 0.0
    assert min(min(axes.lines[0].get_ydata()) for axes in drawn["figures-4.4-4.6-threshold"].axes) < 0.0
