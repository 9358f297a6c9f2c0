"""Claims about errors over drives and time, settling, and the consistency of reported uncertainty."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

from estimators.scores import accuracy
from estimators.scores.accuracy import error_over_time, settling_times
from estimators.scores.consistency import GAUSSIAN_SHARES, nees, nees_consistency, nees_of_std, share_within

NAN = math.nan


def correlated(generator: np.random.Generator, drives: int, times: int, memory: float) -> np.ndarray:
    """Stationary errors of unit variance, each `memory` of the last."""
    error = generator.standard_normal((drives, times))
    for k in range(1, times):
        error[:, k] = memory * error[:, k - 1] + math.sqrt(1.0 - memory**2) * error[:, k]
    return error


def tracked(generator: np.random.Generator, drives: int, claimed_noise: float) -> tuple[np.ndarray, np.ndarray]:
    """Errors and stds of a scalar Kalman filter of a random walk, which believes in `claimed_noise` (truth: 1)."""
    truth, estimate, variance = generator.standard_normal(drives), np.zeros(drives), 1.0
    errors, stds = [], []
    for _ in range(60):
        truth = truth + 0.1 * generator.standard_normal(drives)
        variance += 0.01
        gain = variance / (variance + claimed_noise**2)
        estimate = estimate + gain * (truth + generator.standard_normal(drives) - estimate)
        variance *= 1.0 - gain
        errors.append(estimate - truth)
        stds.append(np.full(drives, math.sqrt(variance)))
    return np.array(errors).T, np.array(stds).T


def test_rmse_bias_and_std_of_known_errors() -> None:
    error = [[1.0, 3.0], [1.0, NAN], [5.0, 5.0]]
    assert accuracy.bias(error).value == pytest.approx(np.mean([2.0, 1.0, 5.0]))
    assert accuracy.rmse(error).value == pytest.approx(math.sqrt(np.mean([5.0, 1.0, 25.0])))
    variance_of_bias = np.var([2.0, 1.0, 5.0], ddof=1) / 3.0
    assert accuracy.std(error).value == pytest.approx(math.sqrt(31.0 / 3.0 - (8.0 / 3.0) ** 2 + variance_of_bias))
    assert accuracy.std([[1.0, 1.0], [2.0, 2.0], [6.0, 6.0]]).value == pytest.approx(np.std([1.0, 2.0, 6.0], ddof=1))


def test_overall_figures_cover_the_truth_of_correlated_errors() -> None:
    generator, hits, repetitions = np.random.default_rng(2), np.zeros(3), 1000
    for _ in range(repetitions):
        error = 0.5 + correlated(generator, 30, 25, 0.9)
        error[generator.random(error.shape) < 0.2] = NAN
        found = (accuracy.bias(error), accuracy.rmse(error), accuracy.std(error))
        hits += [truth in interval for truth, interval in zip((0.5, math.sqrt(1.25), 1.0), found, strict=True)]
    sampling = 3.0 * math.sqrt(0.95 * 0.05 / repetitions)
    assert (hits / repetitions > np.array([0.95, 0.94, 0.93]) - sampling).all(), hits / repetitions
    assert (hits / repetitions < 0.95 + sampling).all(), hits / repetitions


def test_figures_over_time_cover_the_truth_at_95_percent_of_independent_times() -> None:
    """4000 times of 80 drives; quantile limits are never too narrow."""
    error = np.random.default_rng(3).normal(0.0, 2.0, (80, 4000))
    found = error_over_time(error)
    sampling = 3.0 * math.sqrt(0.95 * 0.05 / 4000)
    for band, truth in ((found.bias, 0.0), (found.rmse, 2.0), (found.std, 2.0)):
        assert np.mean((band.low <= truth) & (truth <= band.high)) == pytest.approx(0.95, abs=sampling)
    for band, share in ((found.q05, 0.05), (found.q50, 0.5), (found.q95, 0.95)):
        truth = 2.0 * stats.norm.ppf(share)
        covered = np.mean((band.low <= truth) & (truth <= band.high))
        assert 0.95 - sampling < covered < 0.99, share
        assert np.mean(band.value) == pytest.approx(truth, abs=0.05)


def test_figures_over_time_are_those_of_the_drives_present() -> None:
    error = np.random.default_rng(4).standard_normal((10, 3))
    error[4:, 1] = NAN
    error[:, 2] = NAN
    found, alone = error_over_time(error), error_over_time(error[:4, 1:2])
    assert found.drives.tolist() == [10, 4, 0]
    for name in ("bias", "rmse", "std", "q05", "q50", "q95"):
        assert getattr(found, name).at(1) == getattr(alone, name).at(0), name
        assert np.isnan(getattr(found, name).value[2]), name


def test_settling_is_the_first_time_after_which_the_error_stays_within() -> None:
    error = [[9, 2, 0.5, 0.1], [0.1, 0.2, 0.3, 0.4], [9, 0.5, 2, 0.9], [0, 0, 0, 2], [9, NAN, 0.5, NAN], [NAN] * 4]
    found = settling_times(error, [0.0, 10.0, 20.0, 30.0], bound=1.0)
    assert found.time.tolist() == [20.0, 0.0, 30.0, 30.0, 20.0, 30.0]
    assert found.observed.tolist() == [True, True, True, False, True, False]
    held = settling_times(error, [0.0, 10.0, 20.0, 30.0], bound=1.0, hold=5.0)
    assert held.observed.tolist() == [True, True, False, False, True, False]


def test_settling_is_judged_up_to_each_drives_end() -> None:
    error = [[9.0, 0.5, 0.5, 9.0], [9.0, 9.0, 9.0, 0.1]]
    found = settling_times(error, [0.0, 1.0, 2.0, 3.0], bound=1.0, until=[2.5, 2.5])
    assert found.time.tolist() == [1.0, 2.5]
    assert found.observed.tolist() == [True, False]


def test_correct_kalman_filter_is_consistent_and_an_overconfident_one_is_not() -> None:
    right = nees_consistency(nees_of_std(*tracked(np.random.default_rng(7), 200, 1.0)))
    inside = (right.acceptance.low < right.over_time.value) & (right.over_time.value < right.acceptance.high)
    assert right.consistent
    assert np.mean(inside) > 0.8
    assert 1.0 in right.ratio
    over = nees_consistency(nees_of_std(*tracked(np.random.default_rng(7), 200, 0.5)))
    assert not over.consistent
    assert over.mean.low > 1.0
    assert over.ratio.low > 1.0
    modest = nees_consistency(nees_of_std(*tracked(np.random.default_rng(7), 200, 2.0)))
    assert modest.mean.high < 1.0


def test_nees_of_several_quantities_is_chi_square() -> None:
    """Acceptance at each of 4000 times holds 95 % of the means; the interval decides as the acceptance region does."""
    root = np.array([[2.0, 0.0, 0.0], [1.0, 0.5, 0.0], [-3.0, 1.0, 0.2]])
    error = np.random.default_rng(8).standard_normal((20, 4000, 3)) @ root.T
    found = nees_consistency(nees(error, np.broadcast_to(root @ root.T, (20, 4000, 3, 3))), quantities=3)
    accepted = (found.acceptance.low <= found.over_time.value) & (found.over_time.value <= found.acceptance.high)
    assert np.mean(accepted) == pytest.approx(0.95, abs=3.0 * math.sqrt(0.95 * 0.05 / 4000))
    assert (accepted == ((found.over_time.low <= 3.0) & (found.over_time.high >= 3.0))).all()
    assert found.consistent


def test_nees_of_one_quantity_by_both_ways_and_missing_samples() -> None:
    error, std = np.array([[1.0, NAN, 3.0]]), np.array([[2.0, 1.0, NAN]])
    by_covariance = nees(error[..., None], std[..., None, None] ** 2)
    assert by_covariance == pytest.approx(nees_of_std(error, std), nan_ok=True)
    assert np.isnan(by_covariance).tolist() == [[False, True, True]]


def test_shares_within_one_and_two_std_are_the_gaussian_ones() -> None:
    generator, repetitions = np.random.default_rng(9), 400
    hits = np.zeros(2)
    for _ in range(repetitions):
        error = 3.0 * correlated(generator, 40, 20, 0.8)
        hits += [GAUSSIAN_SHARES[k - 1] in share_within(error, np.full(error.shape, 3.0), k) for k in (1, 2)]
    assert (hits / repetitions > 0.93 - 3.0 * math.sqrt(0.95 * 0.05 / repetitions)).all(), hits / repetitions
    assert pytest.approx((0.6827, 0.9545), abs=1e-4) == GAUSSIAN_SHARES


@pytest.mark.parametrize(
    ("call", "value", "valid"),
    [
        (lambda: accuracy.rmse(np.empty((0, 5))), r"\(0, 5\)", "at least one"),
        (lambda: accuracy.rmse([[NAN, NAN]]), r"\(1, 2\)", "at least one"),
        (lambda: accuracy.rmse([1.0]), r"\(1,\)", r"\(drives, time\)"),
        (lambda: accuracy.rmse([[math.inf]]), "inf", "NaN where missing"),
        (lambda: settling_times([[1.0, 2.0]], [0.0], 1.0), r"\(1,\)", r"\(2,\) rising"),
        (lambda: settling_times([[1.0, 2.0]], [1.0, 0.0], 1.0), "time", "rising"),
        (lambda: settling_times([[1.0]], [0.0], 0.0), "0.0", "above 0"),
        (lambda: settling_times([[1.0]], [0.0], 1.0, until=[1.0, 2.0]), r"\(2,\)", r"\(1,\)"),
        (lambda: nees_of_std([[1.0]], [[0.0]]), "0.0", "above 0"),
        (lambda: nees(np.zeros((1, 2)), np.zeros((1, 2, 2))), "singular", "positive definite"),
        (lambda: nees(np.zeros((1, 2)), np.zeros((1, 3, 3))), r"\(1, 3, 3\)", r"\(1, 2, 2\)"),
        (lambda: nees_consistency([[1.0]], quantities=0), "0", "from 1"),
        (lambda: share_within([[1.0]], [[NAN]], 1.0), "no sample in common", "neither"),
    ],
)
def test_bad_input_is_refused_in_one_line(call: Callable[[], object], value: str, valid: str) -> None:
    with pytest.raises(ValueError, match=f"{value}.*valid: .*{valid}") as refused:
        call()
    assert "\n" not in str(refused.value)
