"""Residuals that are correlated or not Gaussian: prewhitening and thresholds from a record."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from estimators.detectors import (
    CusumMean,
    LocalCusum,
    Monitor,
    Whitener,
    WhiteningFilter,
    count_alarms,
    empirical_threshold,
    fit_whitener,
    poisson_interval,
    simulated_run_length,
)


def correlated(n: int, seed: int, a: tuple[float, ...] = (1.2, -0.5), std: float = 2.0, mean: float = 3.0) -> NDArray:
    """An autoregression."""
    noise = np.random.default_rng(seed).standard_normal(n + 500)
    return mean + std * lfilter([1.0], np.concatenate([[1.0], -np.array(a)]), noise)[500:]


def test_a_whitener_finds_the_autoregression_that_made_the_residuals() -> None:
    found = fit_whitener(correlated(100_000, 0), order=2)
    assert found.coefficients == pytest.approx((1.2, -0.5), abs=0.012)  # 4 / sqrt(n)
    assert found.std == pytest.approx(2.0, rel=0.01)
    assert found.mean == pytest.approx(3.0, abs=0.1)
    assert 2 <= fit_whitener(correlated(20_000, 1)).order <= 8


def test_correlation_multiplies_false_alarms_and_whitening_takes_them_away() -> None:
    detector, x = CusumMean(0.5, 6.0, "both"), correlated(200_000, 2)
    designed = len(x) / detector.average_run_length().mean
    plain = count_alarms(detector, (x - x.mean()) / x.std())
    whitened = count_alarms(detector, fit_whitener(correlated(50_000, 3)).whiten(x))
    assert plain > 5.0 * designed
    low, high = poisson_interval(whitened)
    assert low < designed * 1.05  # 5 %: the whitener was fitted to another stretch
    assert high > designed * 0.95


def test_what_a_shift_is_after_whitening() -> None:
    whitener = Whitener((1.2, -0.5), 3.0, 2.0)
    shifted = whitener.whiten(correlated(50_000, 4) + 4.0)
    assert np.nanmean(shifted) == pytest.approx(whitener.shift_after(4.0), abs=0.02)
    assert whitener.shift_after(4.0) == pytest.approx(0.6)


def test_whitening_sample_by_sample_equals_arrays_and_leaves_out_what_is_missing() -> None:
    whitener, x = Whitener((1.2, -0.5), 3.0, 2.0), correlated(200, 5)
    x[[50, 51, 120]] = [np.nan, np.inf, -np.inf]
    white, filter_ = whitener.whiten(x), WhiteningFilter(whitener)
    assert white.tobytes() == np.array([filter_.step(value) for value in x.tolist()]).tobytes()
    assert np.flatnonzero(np.isnan(white)).tolist() == [0, 1, 50, 51, 52, 53, 120, 121, 122]
    monitor = Monitor(CusumMean(0.5, 5.0))
    assert np.isfinite(monitor.run(white).statistic).all()
    assert monitor.refused == 9
    filter_.reset()
    assert np.isnan(filter_.step(1.0))


@pytest.mark.parametrize(
    ("x", "complaint"),
    [
        (np.zeros(1000), "do not vary"),
        (np.full(1000, np.nan), "0 stretches"),
        (np.ones(5), "want at least"),
        (1.01 ** np.arange(2000.0), "not stable"),
    ],
)
def test_residuals_that_cannot_be_whitened_are_refused(x: NDArray, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        fit_whitener(x, order=2)


def heavy_tailed(n: int, seed: int) -> NDArray[np.float64]:
    """Student's t with 4 degrees of freedom, unit variance."""
    return np.random.default_rng(seed).standard_t(4, n) / 2.0**0.5


def cusum_at(threshold: float) -> CusumMean:
    return CusumMean(0.5, threshold, "both")


def test_heavy_tails_break_a_gaussian_design_and_a_record_mends_it() -> None:
    arl0 = 2000.0
    found = empirical_threshold(heavy_tailed(400_000, 6), cusum_at, arl0)
    fresh = heavy_tailed(1_000_000, 7)
    gaussian_threshold = 6.44  # 2000 samples for Gaussian residuals
    assert cusum_at(gaussian_threshold).average_run_length().mean == pytest.approx(arl0, rel=0.02)
    assert count_alarms(cusum_at(gaussian_threshold), fresh) > 1.5 * len(fresh) / arl0
    reached = len(fresh) / count_alarms(cusum_at(found.threshold), fresh)
    assert found.arl0.method == "record"
    assert found.arl0.low * 0.9 < reached < found.arl0.high * 1.1  # 10 %: 500 alarms in the fresh record
    assert found.arl0.low < arl0 < found.arl0.high


def test_several_local_cusums_take_their_thresholds_from_a_record_by_one_factor() -> None:
    base = LocalCusum((2.0, np.inf), (0.5, 0.5), (4.0, 5.0), "both")
    found = empirical_threshold(np.random.default_rng(10).standard_normal(200_000), base.scaled, 1000.0)
    seen = simulated_run_length(base.scaled(found.threshold), alarms=1000, seed=4)
    assert found.arl0.low < seen.high
    assert found.arl0.high > seen.low


def test_a_short_record_is_extrapolated_with_an_interval() -> None:
    x = np.random.default_rng(8).standard_normal(100_000)
    found = empirical_threshold(x, cusum_at, 1e5)
    truly = cusum_at(found.threshold).average_run_length().mean
    assert found.arl0.method == "record, extrapolated"
    assert found.arl0.low < truly < found.arl0.high
    assert found.arl0.high / found.arl0.low < 20.0


def test_a_record_that_says_nothing_of_the_rate_asked_for_is_refused() -> None:
    with pytest.raises(ValueError, match=r"feasible: 1 to 5e\+06"):
        empirical_threshold(np.random.default_rng(9).standard_normal(100_000), cusum_at, 1e9)
    with pytest.raises(ValueError, match="give at least 2000 residuals"):
        empirical_threshold(np.zeros(100), cusum_at, 1e3)


def test_poisson_interval() -> None:
    assert poisson_interval(0) == pytest.approx((0.0, 3.689), abs=1e-3)
    assert poisson_interval(10) == pytest.approx((4.795, 18.39), abs=1e-2)
