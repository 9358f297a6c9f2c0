"""Claims about the seed's analytical redundancy (seed 003): reference values, corrections, defined answers."""

from __future__ import annotations

import numpy as np
import pytest

from estimators.redundancy.global_value import (
    WeightedMean,
    kalman_mean,
    mean_square_error,
    plain_mean,
    weighted_mean,
)
from estimators.redundancy.published import ERROR_FIRST, FALSE_ALARMS_FIRST, Parameters, judge, pair_sources
from estimators.redundancy.residual import any_measurement, faulty, limit, transformed
from estimators.redundancy.tuning import Candidate, choose, rated

N = 4000
NOISE = 0.03  # m/s^2: three such sources have a mean square error of 3e-4, the seed's first row


def sources(seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A quantity that wanders, and three sources of it with white noise."""
    rng = np.random.default_rng(seed)
    truth = np.sin(np.arange(N) / 300.0)
    return truth, truth[:, None] + NOISE * rng.standard_normal((N, 3))


def test_sigma_and_threshold_are_one_parameter() -> None:
    """The chosen sets of Tables 3 and 4 are limits of 0.0676 and 0.0348 m/s^2."""
    assert FALSE_ALARMS_FIRST.limit == pytest.approx(0.0676, abs=5e-5)
    assert ERROR_FIRST.limit == pytest.approx(0.0348, abs=5e-5)
    deviation = np.linspace(-0.3, 0.3, 3001)
    for sigma, threshold in ((0.06, 0.47), (0.02, 0.78), (0.4, 0.05)):
        assert np.array_equal(faulty(deviation, sigma, threshold), np.abs(deviation) > limit(sigma, threshold))
    for sigma, threshold in ((0.0, 0.5), (0.1, 1.0), (0.1, -0.1), (float("nan"), 0.5)):
        with pytest.raises(ValueError, match="valid"):
            limit(sigma, threshold)


def test_residual_is_odd_continuous_and_bounded() -> None:
    """The printed factor 0.9974 would make it jump by 0.005 at zero."""
    d = np.linspace(-1.0, 1.0, 2001)
    s = transformed(d, 0.1)
    assert np.abs(s + s[::-1]).max() < 1e-12  # the grid's own rounding
    assert s[1000] == 0.0
    assert (np.diff(s) >= 0.0).all()
    assert np.abs(np.diff(s)).max() < 0.001 / 0.1  # the slope is at most exp(-1/2) / sigma
    assert np.abs(s).max() <= 1.0


def test_mean_of_three_takes_a_third_of_a_bias() -> None:
    """(b/3)^2 of Table 1: 1.1e-3, 1.0e-2, 2.8e-2."""
    truth, said = sources()
    sound = mean_square_error(plain_mean(said), truth)
    assert sound == pytest.approx(NOISE**2 / 3.0, rel=0.1)
    for bias, square in ((0.1, 1.1e-3), (0.3, 1.0e-2), (0.5, 2.8e-2)):
        off = said + np.array([bias, 0.0, 0.0])
        error = mean_square_error(plain_mean(off), truth) - sound
        assert error == pytest.approx((bias / 3.0) ** 2, rel=0.05)
        assert (bias / 3.0) ** 2 == pytest.approx(square, rel=0.02)


def test_weighted_mean_takes_less_of_a_bias_than_the_mean_and_no_zero_divides() -> None:
    truth, said = sources()
    for bias in (0.1, 0.3, 0.5):
        off = said + np.array([0.0, bias, 0.0])
        last = slice(N // 2, None)
        weighted = mean_square_error(weighted_mean(off)[last], truth[last])
        assert weighted < 0.5 * mean_square_error(plain_mean(off)[last], truth[last])
    exact = np.repeat(truth[:, None], 3, axis=1)
    assert np.allclose(weighted_mean(exact), truth)


def test_weights_follow_their_recursion() -> None:
    """Equations 15 to 19 written out for one source's deviation."""
    _, said = sources()
    method, memory, first = WeightedMean(3, 0.9, 0.2), 0.9, 0.2
    values = [method.step(row, np.zeros(3, dtype=bool)) for row in said[:50]]
    deviations = np.abs(said[1:50, 2] - np.array(values[:-1]))
    closed = memory**49 * first + sum((1 - memory) * memory**i * e for i, e in enumerate(deviations[::-1]))
    assert method.deviation[2] == pytest.approx(closed, rel=1e-12)


def test_kalman_mean_of_a_constant_is_the_information_weighted_mean() -> None:
    rng = np.random.default_rng(2)
    variance = np.array([0.01, 0.04, 0.09])
    said = 3.0 + np.sqrt(variance) * rng.standard_normal((2000, 3))
    value = kalman_mean(said, variance, 0.0)
    weight = (1.0 / variance) / (1.0 / variance).sum()
    assert value[-1] == pytest.approx(float((said @ weight).mean()), abs=1e-3)


def test_a_faulty_source_is_excluded_and_comes_back() -> None:
    truth, said = sources()
    off = said.copy()
    off[1000:2000, 0] += 0.5
    judged = judge(off, Parameters(0.06, 0.9))
    assert judged.faulty[1050:2000, 0].mean() > 0.99
    assert judged.faulty[1050:2000, 1:].mean() < 0.02
    assert judged.faulty[2050:, 0].mean() < 0.02
    assert mean_square_error(judged.value[1050:2000], truth[1050:2000]) < 2.0 * NOISE**2


def test_with_every_source_excluded_the_answer_is_the_last_one_and_says_so() -> None:
    said = np.full((300, 3), 1.0)
    said[100:200] = np.array([5.0, 6.0, 7.0])
    judged = judge(said, Parameters(0.06, 0.47))
    assert judged.alone[102:200].all()
    assert np.isfinite(judged.value).all()
    assert np.unique(judged.value[102:200]).size == 1
    assert not judged.alone[:100].any()
    silent = judge(np.full((5, 3), np.nan), FALSE_ALARMS_FIRST)
    assert silent.alone.all()
    assert not silent.faulty.any()


def test_a_sensor_is_faulty_in_any_measurement() -> None:
    decisions = np.array([[True, False, False], [False, False, True]])
    assert any_measurement(decisions).tolist() == [True, False, True]


def test_speed_of_a_pair_is_the_sum_of_its_wheels() -> None:
    """Equation 3 prints a difference, by which a straight drive would stand."""
    time = np.arange(0.0, 10.0, 0.01)
    acceleration, yaw_rate = pair_sources(10.0 + time - 0.4, 10.0 + time + 0.4, 1.6, 0.01)
    assert np.allclose(acceleration[1:], 1.0)
    assert np.allclose(yaw_rate, 0.5)


def test_choice_by_priorities() -> None:
    limits = np.array([0.08, 0.12, 0.16, 0.24])  # all above the noise: below it every source is excluded at times
    truth, said = sources()
    off, candidates = said.copy(), []
    off[:, 0] += 0.15
    for far in limits:
        parameters = Parameters(float(far) / np.sqrt(-2.0 * np.log(0.5)), 0.5)
        sound, broken = judge(said, parameters), judge(off, parameters)
        candidates.append(rated(parameters, sound, [(broken, off[:, 0] - truth)], 0))
    alarms, errors = [c.false_alarm for c in candidates], [c.error for c in candidates]
    assert alarms == sorted(alarms, reverse=True)
    assert errors == sorted(errors)
    first = choose(candidates, "false_alarm", 0.002, "error")
    assert first.false_alarm <= 0.002
    assert all(c.error >= first.error for c in candidates if c.false_alarm <= 0.002)
    second = choose(candidates, "error", errors[1], "false_alarm")
    assert second == candidates[1]
    with pytest.raises(ValueError, match="valid: from"):
        choose(candidates, "error", 0.0, "missed")
    with pytest.raises(ValueError, match="'speed'"):
        choose([Candidate(FALSE_ALARMS_FIRST, 0.0, 0.0, 0.0)], "speed", 1.0, "missed")
