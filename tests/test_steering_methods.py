"""The thesis' monitors of the steering actuator: each against a sum done by hand, its tuning, tables, suggestions."""

from __future__ import annotations

import numpy as np
import pytest

from estimators.detectors import CusumMean, siegmund_run_length, siegmund_threshold
from estimators.steering_actuator.errors import THESIS, Error
from estimators.steering_actuator.published import (
    FAST_PERIOD,
    METHODS,
    SLOW_PERIOD,
    ZEROED,
    detector,
    statistics,
    verdict,
)
from estimators.steering_actuator.residuals import RESIDUALS, residuals
from estimators.steering_actuator.tuning import MARGIN, tuned

BY_NAME = {method.name: method for method in METHODS}
QUIET = {"threshold": 1e12}


def said(name: str, position: np.ndarray, numbers: dict[str, object]) -> np.ndarray:
    """Statistic of the position alone, in units of its level."""
    method = BY_NAME[name]
    quiet = {**numbers, **({"thresholds": [1e12] * len(numbers["thresholds"])} if "thresholds" in numbers else QUIET)}
    return statistics(method, {RESIDUALS[0]: numbers, RESIDUALS[1]: quiet, RESIDUALS[2]: quiet}, residuals(position))[
        :, 0
    ]


def steps(*levels: float, cells: int = 300) -> np.ndarray:
    """Position residuals in which each level lasts as long, after the zeroed second of environment 1."""
    return np.concatenate([np.zeros(ZEROED), *(np.full(cells, level) for level in levels)])


def test_cusum_sums_what_is_beyond_its_drift_of_either_sign_the_double_one_each_by_itself() -> None:
    """g = 300 (50 - 20) after 300 cells of 50; of -50 the same for |eps|, and a sum of its own for the double one."""
    numbers = {"drift": 20.0, "threshold": 1000.0}
    for name in ("CUSUM", "double_CUSUM"):
        assert said(name, steps(50.0), numbers)[-1] == pytest.approx(9.0)
        assert said(name, steps(-50.0), numbers)[-1] == pytest.approx(9.0)
    assert said("CUSUM", steps(50.0, -50.0), numbers)[-1] == pytest.approx(18.0)
    assert said("double_CUSUM", steps(50.0, -50.0), numbers)[-1] == pytest.approx(9.0)
    assert said("CUSUM", steps(19.0), numbers).max() == 0.0


def test_gma_and_adyn_rise_as_one_minus_their_forgetting_to_the_n() -> None:
    for name, forgetting in (("GMA", 0.99), ("ADYN", 0.9)):
        found = said(name, steps(-40.0), {"forgetting": forgetting, "threshold": 10.0})
        assert found[ZEROED + 9] == pytest.approx(4.0 * (1.0 - forgetting**10))


def test_integrators_are_zeroed_periodically_and_ac_is_a_threshold() -> None:
    for name, period in (("ACS", SLOW_PERIOD), ("ACF", FAST_PERIOD), ("AC", 1)):
        found = said(name, steps(-3.0, cells=4 * SLOW_PERIOD), {"threshold": 3.0})
        assert found.max() == pytest.approx(period)
        assert found[4 * period] == pytest.approx(1.0 if 4 * period >= ZEROED else 0.0)


def test_a_local_cusum_is_blind_beyond_its_limit_on_either_side_and_a_global_one_is_not() -> None:
    local = {"limits": [100.0], "drifts": [20.0], "thresholds": [1000.0]}
    whole = {"limits": [100.0, None], "drifts": [20.0, 200.0], "thresholds": [1000.0, 20000.0]}
    for name in ("LCUSUM", "double_LCUSUM"):
        assert said(name, steps(-80.0), local)[-1] == pytest.approx(18.0)
        assert said(name, steps(120.0), local).max() == said(name, steps(-120.0), local).max() == 0.0
    assert said("double_LGCUSUM", steps(-300.0), whole)[-1] == pytest.approx(300.0 * 100.0 / 20000.0)


def test_environment_1_is_deaf_for_a_second() -> None:
    position = np.full(2 * ZEROED, 500.0)
    assert said("AC", position, {"threshold": 100.0})[ZEROED - 1] == 0.0
    assert said("ADYN", position, {"forgetting": 0.9, "threshold": 100.0})[ZEROED - 1] > 4.9
    times = {m.name: m.environment for m in METHODS}
    assert [name for name, environment in times.items() if environment == 2] == ["double_LGCUSUM", "ADYN"]


def test_a_short_alarm_at_the_beginning_is_a_star_and_the_first_true_one_is_told() -> None:
    over = np.zeros((500, 3))
    over[3:8, 0] = 2.0
    assert verdict(over) == verdict(np.zeros((500, 3))).__class__(None, "", True)
    over[200:, 2] = 3.0
    found = verdict(over)
    assert (found.time, found.by, found.star) == (pytest.approx(2.01), "acceleration", True)
    assert verdict(over, 4.0).time is None


def test_errors_are_the_thesis() -> None:
    assert Error("constant", 20.0).of(5).tolist() == [20.0] * 5
    slope = Error("slope", 50.0).of(1000)
    assert slope[:500].max() == 0.0
    assert slope[-1] == pytest.approx(50.0 * 4.995)
    noise = Error("noise", 50.0).of(100_000, 1)
    assert noise.std() == pytest.approx(np.sqrt(50.0 / 0.01), rel=0.01)
    assert Error("sine", 40.0).of(1000).std() == pytest.approx(40.0 * np.sinc(0.2) / np.sqrt(2.0), rel=1e-3)
    assert len({error.name for error in THESIS}) == len(THESIS) == 14
    with pytest.raises(ValueError, match="valid: none, constant"):
        Error("drift")


def test_tuning_never_alarms_where_it_was_tuned_and_finds_what_it_can() -> None:
    rng = np.random.default_rng(5)
    sound = [residuals(scale * rng.standard_normal(800)) for scale in (5.0, 5.0, 60.0)]
    errors = [Error("constant", size).of(800) for size in (50.0, 500.0)]
    faulty = [residuals(eps[:, 0] + added) for eps in sound for added in errors]
    for method in METHODS:
        numbers = tuned(method, sound, faulty)
        margins = [statistics(method, numbers, eps).max() for eps in sound]
        assert max(margins) <= 1.0 / MARGIN + 1e-9, method.name
        found = verdict(statistics(method, numbers, residuals(np.full(800, 900.0)))).time
        assert (found is None) == (method.family == "local"), method.name  # beyond every limit
        for name in RESIDUALS:
            assert detector(method, numbers[name]).level > 0.0
    local = tuned(BY_NAME["LCUSUM"], sound, faulty)["position"]
    assert verdict(statistics(BY_NAME["LCUSUM"], tuned(BY_NAME["LCUSUM"], sound, faulty), faulty[0])).time is not None
    assert local["limits"] == sorted(local["limits"])


@pytest.mark.parametrize(
    ("sigma", "theta", "h"),
    [(15.7, 40.0, 92.5), (20.7, 40.0, 162.6), (33.1, 70.0, 237.1), (21.9, 40.0, 182.2), (15.0, 40.0, 84.2)],
)
def test_suggestions_of_figures_4_18_to_4_21_are_siegmund_s(sigma: float, theta: float, h: float) -> None:
    """h to a digit of sigma; nu = theta / 2 is where his delay for theta is least."""
    found = siegmund_threshold(theta / 2.0, 2e7, sigma)
    slack = abs(siegmund_threshold(theta / 2.0, 2e7, sigma + 0.05) - found)
    assert found == pytest.approx(h, abs=slack)
    drifts = np.linspace(0.3, 0.7, 81) * theta
    delays = [siegmund_run_length(siegmund_threshold(v, 2e7, sigma), v, theta, sigma) for v in drifts]
    assert drifts[int(np.argmin(delays))] == pytest.approx(theta / 2.0, abs=0.02 * theta)
    assert CusumMean(theta / 2.0 / sigma, h / sigma).average_run_length().mean == pytest.approx(2e7, rel=0.35)
