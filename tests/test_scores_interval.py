"""Claims about intervals: closed forms, exact coverage where it can be summed, coverage over fixed seeds elsewhere."""

from __future__ import annotations

import ast
import json
import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from estimators import scores
from estimators.registry import registered
from estimators.scores.bootstrap import bootstrap, bootstrap_of_sums
from estimators.scores.interval import (
    Interval,
    mean_interval,
    poisson_rate_interval,
    positive_mean_interval,
    proportion_interval,
    quantile_interval,
    rms_interval,
    shared_proportion_interval,
    std_interval,
)

REPETITIONS = 2000
SAMPLING = 3.0 * math.sqrt(0.95 * 0.05 / REPETITIONS)  # three standard deviations of a coverage of 95 %
ROUNDING = 1e-9


def coverage(interval_of: Callable[[np.random.Generator], Interval], truth: float, repetitions: int) -> float:
    generator = np.random.default_rng(1)
    return float(np.mean([truth in interval_of(generator) for _ in range(repetitions)]))


@pytest.mark.parametrize(
    ("interval", "truth"),
    [
        (lambda g: mean_interval(g.normal(3.0, 2.0, 8)), 3.0),
        (lambda g: std_interval(g.normal(3.0, 2.0, 8)), 2.0),
        (lambda g: rms_interval(g.normal(0.0, 2.0, 8)), 2.0),
    ],
    ids=["mean", "std", "rms"],
)
def test_gaussian_intervals_cover_95_percent(interval: Callable[[np.random.Generator], Interval], truth: float) -> None:
    assert coverage(interval, truth, REPETITIONS) == pytest.approx(0.95, abs=SAMPLING)


def test_gaussian_limits_are_the_closed_forms() -> None:
    samples = np.array([1.0, -2.0, 4.0, 0.5, 3.0])
    mean, std, rms = samples.mean(), samples.std(ddof=1), math.sqrt(np.mean(samples**2))
    reach = stats.t.ppf(0.975, 4) * std / math.sqrt(5.0)
    found = mean_interval(samples)
    assert (found.value, found.low, found.high) == pytest.approx((mean, mean - reach, mean + reach))
    for found, value, degrees in ((rms_interval(samples), rms, 5), (std_interval(samples), std, 4)):
        limits = [value * math.sqrt(degrees / stats.chi2.ppf(p, degrees)) for p in (0.975, 0.025)]
        assert (found.value, found.low, found.high) == pytest.approx((value, *limits))


def test_rms_interval_is_never_too_narrow_with_a_bias() -> None:
    for offset in (0.5, 1.0, 3.0):
        truth = math.hypot(offset, 1.0)
        assert coverage(lambda g, b=offset: rms_interval(g.normal(b, 1.0, 20)), truth, REPETITIONS) > 0.95 - SAMPLING


def test_mean_square_of_correlated_drives_is_covered_within_two_percent() -> None:
    """Per-drive mean squares, from nearly constant errors (1 degree of freedom a drive) to many independent ones."""
    for degrees in (1, 4, 60):
        found = coverage(lambda g, k=degrees: positive_mean_interval(g.chisquare(k, 40) / k), 1.0, REPETITIONS)
        assert 0.93 - SAMPLING < found < 0.95 + SAMPLING, degrees


@pytest.mark.parametrize("trials", [1, 7, 40])
def test_proportion_covers_at_least_95_percent_for_every_share(trials: int) -> None:
    found = [proportion_interval(count, trials) for count in range(trials + 1)]
    for share in np.linspace(0.001, 0.999, 333):
        probability = stats.binom.pmf(np.arange(trials + 1), trials, share)
        covered = sum(p for p, interval in zip(probability, found, strict=True) if share in interval)
        assert covered >= 0.95 - ROUNDING, share


def test_poisson_rate_covers_at_least_95_percent_for_every_rate() -> None:
    found = [poisson_rate_interval(count, 10.0) for count in range(80)]
    for expected in np.geomspace(0.01, 30.0, 300):
        probability = stats.poisson.pmf(np.arange(80), expected)
        covered = sum(p for p, interval in zip(probability, found, strict=True) if expected / 10.0 in interval)
        assert covered >= 0.95 - ROUNDING, expected


def test_no_alarm_in_t_hours_bounds_the_rate_at_3_689_over_t() -> None:
    interval = poisson_rate_interval(0, 50.0)
    assert (interval.value, interval.low) == (0.0, 0.0)
    assert interval.high == pytest.approx(3.689 / 50.0, rel=1e-4)
    assert interval.high == pytest.approx(-math.log(0.025) / 50.0)


def test_all_of_n_detected_bounds_the_share_by_the_nth_root() -> None:
    assert proportion_interval(40, 40).low == pytest.approx(0.025 ** (1 / 40))
    assert proportion_interval(0, 40).high == pytest.approx(1.0 - 0.025 ** (1 / 40))


def test_shares_of_drives_are_covered_although_samples_in_a_drive_agree() -> None:
    """Shares of 20 correlated samples; as 30 x 20 independent trials they would be covered by half as often."""

    def shares(g: np.random.Generator) -> np.ndarray:
        return g.binomial(20, g.beta(2.0, 0.5, 30)) / 20.0

    naive = coverage(lambda g: proportion_interval(20 * shares(g).sum(), 600.0), 0.8, 500)
    assert naive < 0.8
    assert coverage(lambda g: shared_proportion_interval(shares(g)), 0.8, REPETITIONS) > 0.94 - SAMPLING


def test_drives_that_all_agree_count_one_trial_each() -> None:
    assert shared_proportion_interval(np.ones(12)) == proportion_interval(12, 12)
    assert shared_proportion_interval(np.zeros(12)) == proportion_interval(0, 12)


@pytest.mark.parametrize(("probability", "number"), [(0.05, 100), (0.5, 15), (0.95, 200)])
def test_quantile_interval_covers_at_least_95_percent(probability: float, number: int) -> None:
    truth = -math.log1p(-probability)
    found = coverage(lambda g: quantile_interval(g.exponential(size=number), probability), truth, REPETITIONS)
    assert 0.95 - SAMPLING < found < 0.99


def test_quantile_limits_appear_with_enough_samples() -> None:
    assert quantile_interval(np.arange(71.0), 0.05).low == -math.inf
    assert quantile_interval(np.arange(73.0), 0.05).low == 0.0
    assert quantile_interval([1.0], 0.5) == Interval(1.0, -math.inf, math.inf)


def test_bootstrap_limits_are_scipys_bca_limits() -> None:
    samples = np.random.default_rng(5).exponential(size=30)
    found = bootstrap(np.mean, samples, seed=0, replicates=20000)
    reference = stats.bootstrap((samples,), np.mean, n_resamples=20000, method="BCa", rng=np.random.default_rng(1))
    spread = found.high - found.low
    assert found.low == pytest.approx(reference.confidence_interval.low, abs=0.02 * spread)
    assert found.high == pytest.approx(reference.confidence_interval.high, abs=0.02 * spread)


def test_bootstrap_of_sums_is_the_bootstrap() -> None:
    drives = np.random.default_rng(6).normal(1.0, 1.0, (25, 40))
    direct = bootstrap(lambda d: np.sqrt(np.mean(d**2)), drives, seed=0, replicates=8000)
    sums = np.column_stack([np.sum(drives**2, axis=1), np.full(25, 40.0)])
    fast = bootstrap_of_sums(lambda s: np.sqrt(s[..., 0] / s[..., 1]), sums, seed=1, replicates=8000)
    spread = direct.high - direct.low
    assert (fast.low, fast.high) == pytest.approx((direct.low, direct.high), abs=0.03 * spread)
    assert fast.value == pytest.approx(direct.value)


def test_bootstrap_of_drives_covers_where_single_samples_would_not() -> None:
    """Errors constant within each of 30 drives: 50 samples a drive carry no more than one."""

    def mean_of_drives(g: np.random.Generator) -> Interval:
        drives = g.standard_normal((30, 1)) + 0.1 * g.standard_normal((30, 50))
        sums = np.column_stack([drives.sum(axis=1), np.full(30, 50.0)])
        return bootstrap_of_sums(lambda s: s[..., 0] / s[..., 1], sums, seed=int(g.integers(1 << 30)), replicates=600)

    assert 0.91 < coverage(mean_of_drives, 0.0, 600) < 0.97


def test_bootstrap_repeats_with_its_seed_and_takes_lists_of_unequal_drives() -> None:
    drives = [np.arange(float(n)) for n in (3, 5, 9, 4)]
    found = [bootstrap(lambda d: np.mean(np.concatenate(d)), drives, seed=seed, replicates=200) for seed in (1, 1, 2)]
    assert found[0] == found[1] != found[2]


def test_missing_samples_are_dropped() -> None:
    assert mean_interval([1.0, math.nan, 2.0, 4.0]) == mean_interval([1.0, 2.0, 4.0])


def test_scores_import_only_numpy_and_scipy_and_are_no_estimators() -> None:
    allowed = {*sys.stdlib_module_names, "numpy", "scipy"}
    for path in Path(scores.__path__[0]).glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                package = name.split(".")[0]
                assert package in allowed or name.startswith(("estimators.scores.", "estimators.drive_log")), path
    assert not [kind for kind in registered().values() if kind.__module__.startswith("estimators.scores")]


def test_one_sample_bounds_no_mean() -> None:
    assert mean_interval([2.0]) == Interval(2.0, -math.inf, math.inf)
    assert positive_mean_interval([2.0]) == Interval(2.0, 0.0, math.inf)


def test_json_has_null_for_what_is_not_reached() -> None:
    text = json.dumps(Interval(2.0, 1.0, math.inf).json(), allow_nan=False)
    assert json.loads(text) == {"here": 2.0, "ci95": [1.0, None]}


@pytest.mark.parametrize(
    ("call", "value", "valid"),
    [
        (lambda: mean_interval([]), "0 numbers", "at least 1"),
        (lambda: mean_interval([math.nan]), "0 numbers", "at least 1"),
        (lambda: mean_interval([1.0, math.inf]), "inf", "finite"),
        (lambda: mean_interval([[1.0]]), r"\(1, 1\)", "one number a drive"),
        (lambda: mean_interval([1.0, 2.0], 95.0), "95.0", "below 1"),
        (lambda: std_interval([1.0]), "1 number", "at least 2"),
        (lambda: positive_mean_interval([-1.0, 2.0]), "-1", "no negative"),
        (lambda: shared_proportion_interval([0.5, 1.5]), "1.5", "0 to 1"),
        (lambda: proportion_interval(3, 2), "3", "0 to trials"),
        (lambda: proportion_interval(0, 0), "0", "above 0"),
        (lambda: poisson_rate_interval(-1, 2.0), "-1", "from 0"),
        (lambda: poisson_rate_interval(1, 0.0), "0.0", "above 0"),
        (lambda: quantile_interval([1.0, 2.0], 1.0), "1.0", "below 1"),
        (lambda: Interval(1.0, 2.0, 0.0), "2.0", "low at most high"),
        (lambda: bootstrap(np.mean, np.ones(1), 0), "1 drives", "at least 2"),
        (lambda: bootstrap(lambda d: math.nan, np.ones(5), 0), "nan", "always is"),
    ],
)
def test_bad_input_is_refused_in_one_line(call: Callable[[], object], value: str, valid: str) -> None:
    with pytest.raises(ValueError, match=f"{value}.*valid: .*{valid}") as refused:
        call()
    assert "\n" not in str(refused.value)
