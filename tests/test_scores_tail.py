"""Claims about the extrapolated tail: against closed forms two decades beyond the data, with its interval."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy import optimize, stats

from estimators.scores.tail import Tail, block_maxima, extremal_index, fit_tail

BLOCKS = 2000  # of one hour
RATE = 1.0 / (100 * BLOCKS)  # [1/h], two decades beyond the data


def exponential(generator: np.random.Generator) -> np.ndarray:
    return generator.exponential(size=BLOCKS)


def gaussian(generator: np.random.Generator) -> np.ndarray:
    return generator.standard_normal((BLOCKS, 60)).max(axis=1)


@pytest.mark.parametrize(
    ("draw", "threshold"),
    [(exponential, -math.log(RATE)), (gaussian, stats.norm.isf(-math.expm1(math.log1p(-RATE) / 60)))],
    ids=["exponential", "Gaussian block maxima"],
)
def test_threshold_and_rate_two_decades_beyond_the_data_are_covered(
    draw: Callable[[np.random.Generator], np.ndarray], threshold: float
) -> None:
    """Both intervals are of one level set, so the threshold is covered as often as the rate."""
    generator, repetitions = np.random.default_rng(1), 100
    hits = np.zeros(2)
    for _ in range(repetitions):
        tail = fit_tail([draw(generator)], 1.0)
        hits += [threshold in tail.threshold_at(RATE), RATE in tail.rate_at(threshold)]
    sampling = 3.0 * math.sqrt(0.95 * 0.05 / repetitions)
    assert (hits / repetitions > 0.93 - sampling).all(), hits / repetitions


@pytest.mark.parametrize("shape", [-0.2, 0.3])
def test_shape_of_a_generalised_pareto_tail_is_covered(shape: float) -> None:
    drawn = stats.genpareto.rvs(shape, size=(60, BLOCKS), random_state=2)
    covered = np.mean([shape in fit_tail([blocks], 1.0).shape for blocks in drawn])
    assert covered > 0.93 - 3.0 * math.sqrt(0.95 * 0.05 / 60)


@pytest.mark.parametrize("shape", [-0.2, 0.0, 0.3])
def test_parameters_are_the_maximum_of_the_likelihood(shape: float) -> None:
    """Those of scipy's fit, which maximises the same likelihood by another route."""
    blocks = stats.genpareto.rvs(shape, size=3000, random_state=4)
    tail = fit_tail([blocks], 1.0)
    fitted_shape, _, fitted_scale = stats.genpareto.fit(tail.excesses, floc=0.0)
    assert (tail.shape.value, tail.scale.value) == pytest.approx((fitted_shape, fitted_scale), abs=2e-3)


def test_interval_is_the_profile_likelihood_interval() -> None:
    """Limits of the threshold where the likelihood, maximised under that threshold, has fallen by chi2(1) / 2."""
    tail = fit_tail([exponential(np.random.default_rng(5))], 1.0)
    excesses = tail.excesses

    def loss(p: np.ndarray) -> float:
        rate, scale, shape = math.exp(p[0]), math.exp(p[1]), p[2]
        gained = stats.genpareto.logpdf(excesses, shape, scale=scale).sum() + len(excesses) * p[0]
        return -tail.extremal_index * gained + rate * tail.hours

    def passed(p: np.ndarray) -> float:
        return tail.threshold + math.exp(p[1]) * math.expm1(p[2] * (p[0] - math.log(1e-4))) / p[2]

    best = np.array([math.log(tail.rate.value), math.log(tail.scale.value), tail.shape.value])
    found = tail.threshold_at(1e-4)
    for limit in (found.low, found.high):
        constrained = optimize.minimize(
            loss, best + 0.01, method="SLSQP", constraints={"type": "eq", "fun": lambda p, x=limit: passed(p) - x}
        )
        assert 2.0 * (constrained.fun - loss(best)) == pytest.approx(stats.chi2.ppf(0.95, 1), abs=0.1)


def test_threshold_and_rate_are_inverse() -> None:
    tail = fit_tail([gaussian(np.random.default_rng(6))], 0.5)
    for rate in (0.1, 1e-3, 1e-6):
        assert tail.rate_at(tail.threshold_at(rate).value).value == pytest.approx(rate, rel=1e-9)
    assert tail.rate_at(tail.threshold).value == pytest.approx(tail.rate.value)


def test_rate_counts_clusters_an_hour() -> None:
    """Each exceedance lasts two blocks: an index of a half, and the rate of the clusters, not of the blocks."""
    single = exponential(np.random.default_rng(7))
    paired = np.repeat(single, 2)
    found, alone = fit_tail([paired], 0.5), fit_tail([single], 1.0)
    assert found.extremal_index == pytest.approx(0.5, abs=0.1)
    assert alone.extremal_index > 0.9
    assert found.rate.value == pytest.approx(alone.rate.value, rel=0.15)
    assert found.threshold_at(1e-4).value == pytest.approx(alone.threshold_at(1e-4).value, rel=0.03)
    assert found.shape.high - found.shape.low == pytest.approx(alone.shape.high - alone.shape.low, rel=0.15)


def test_a_bounded_statistic_has_no_alarm_beyond_its_end() -> None:
    tail = fit_tail([np.random.default_rng(8).uniform(size=3000) ** 0.25], 1.0)
    assert tail.shape.value < 0.0
    assert tail.rate_at(5.0).value == 0.0
    assert tail.threshold_at(1e-9).value < 1.1


def test_more_confidence_gives_wider_limits_and_more_drives_narrower() -> None:
    blocks = exponential(np.random.default_rng(9))

    def width(tail: Tail) -> float:
        return tail.threshold_at(1e-4).high - tail.threshold_at(1e-4).low

    usual = width(fit_tail([blocks], 1.0))
    assert width(fit_tail([blocks], 1.0, confidence=0.5)) < usual < width(fit_tail([blocks], 1.0, confidence=0.99))
    assert width(fit_tail([blocks, exponential(np.random.default_rng(10))], 1.0)) < usual


def test_extremal_index_is_one_over_the_mean_length_of_clusters() -> None:
    """Moving maxima of k independent numbers stay above a high level for k steps."""
    drawn = np.random.default_rng(11).exponential(size=100_000)
    for length in (1, 2, 4):
        moving = np.max([drawn[k : len(drawn) - length + k] for k in range(length)], axis=0)
        assert extremal_index(moving > np.quantile(moving, 0.99)) == pytest.approx(1.0 / length, abs=0.1)


def test_hours_are_those_of_the_blocks_with_a_value() -> None:
    drives = np.random.default_rng(12).exponential(size=(400, 5))
    drives[0, 2] = math.nan
    assert fit_tail(list(drives), 0.1).hours == pytest.approx(199.9)


def test_block_maxima_are_of_whole_blocks() -> None:
    time = np.arange(0.0, 25.0, 0.5)
    statistic = np.where(time < 10.0, time, np.nan)
    assert block_maxima(statistic, time, 5.0) == pytest.approx([4.5, 9.5, math.nan, math.nan, math.nan], nan_ok=True)
    assert len(block_maxima(statistic, time, 10.0)) == 2


@pytest.mark.parametrize(
    ("call", "value", "valid"),
    [
        (lambda: fit_tail([], 1.0), "0 numbers", "at least 20"),
        (lambda: fit_tail([np.arange(100.0)], 1.0), "10 independent", "at least 20"),
        (lambda: fit_tail([np.ones(500)], 1.0), "0 independent", "at least 20"),
        (lambda: fit_tail([np.ones(500)], 0.0), "0.0", "above 0"),
        (lambda: fit_tail([np.ones(500)], 1.0, share=1.0), "1.0", "below 1"),
        (lambda: fit_tail([exponential(np.random.default_rng(0))], 1.0).threshold_at(0.5), "0.5", "at most"),
        (lambda: fit_tail([exponential(np.random.default_rng(0))], 1.0).rate_at(0.0), "0", "from u"),
        (lambda: block_maxima([], [], 1.0), r"\(0,\)", "n at least 1"),
        (lambda: block_maxima([1.0], [0.0], 0.0), "0.0", "above 0"),
    ],
)
def test_bad_input_is_refused_in_one_line(call: Callable[[], object], value: str, valid: str) -> None:
    with pytest.raises(ValueError, match=f"{value}.*valid: .*{valid}") as refused:
        call()
    assert "\n" not in str(refused.value)
