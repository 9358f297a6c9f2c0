"""Claims about times to detection with censoring, the wheels named, and the count of false alarms."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

from estimators.scores.detection import confusion, detection, detection_times, isolation_rate, wheels_label
from estimators.scores.false_alarms import episodes, false_alarms
from estimators.scores.interval import Interval, proportion_interval
from estimators.scores.survival import EventTimes, event_curve, share_by

MEDIAN = math.log(2.0)  # of a unit exponential


def censored(generator: np.random.Generator, drives: int) -> EventTimes:
    """Unit exponential times, censored at uniform ends: about a third of the drives."""
    event, end = generator.exponential(size=drives), generator.uniform(0.0, 3.0, drives)
    return EventTimes(np.minimum(event, end), event <= end)


def test_without_censoring_the_curve_is_the_empirical_distribution() -> None:
    times = np.random.default_rng(0).integers(1, 12, 50).astype(float)
    curve = event_curve(EventTimes(times, np.ones(50)))
    assert curve.time.tolist() == np.unique(times).tolist()
    assert curve.share.value == pytest.approx([np.mean(times <= t) for t in curve.time])


def test_curve_of_a_worked_example() -> None:
    """Remission times of the 6-MP group (Freireich et al. 1963), the textbook example of the estimator."""
    time = [6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35]
    seen = [1, 1, 1, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0]
    curve = event_curve(EventTimes(time, seen))
    assert 1.0 - curve.share.value == pytest.approx([0.857, 0.807, 0.753, 0.690, 0.627, 0.538, 0.448], abs=5e-4)
    assert curve.watched.tolist() == [21, 17, 15, 12, 11, 7, 6]
    assert 1.0 - curve.share.low[0] == pytest.approx(0.952, abs=5e-4)
    assert 1.0 - curve.share.high[0] == pytest.approx(0.620, abs=5e-4)
    assert curve.quantile(0.5).value == 23.0


def test_curve_and_band_are_scipys() -> None:
    events = censored(np.random.default_rng(1), 40)
    curve = event_curve(events)
    data = stats.CensoredData.right_censored(events.time, ~events.observed)
    reference = stats.ecdf(data)
    with pytest.warns(RuntimeWarning, match="undefined at some"):  # scipy has no limits once the curve is 1
        limits = reference.cdf.confidence_interval(0.95, method="log-log")
    assert curve.share.value == pytest.approx(reference.cdf.evaluate(curve.time))
    inner = curve.share.value < 1.0
    assert curve.share.low[inner] == pytest.approx(limits.low.evaluate(curve.time)[inner])
    assert curve.share.high[inner] == pytest.approx(limits.high.evaluate(curve.time)[inner])


def test_band_median_and_share_by_a_limit_cover_the_truth_under_censoring() -> None:
    generator, hits, repetitions = np.random.default_rng(2), np.zeros(3), 1000
    for _ in range(repetitions):
        events = censored(generator, 60)
        curve = event_curve(events)
        step = int(np.searchsorted(curve.time, 1.0, side="right")) - 1
        truth = 1.0 - math.exp(-1.0)
        hits += [truth in curve.share.at(step), MEDIAN in curve.quantile(0.5), truth in share_by(events, 1.0)]
    sampling = 3.0 * math.sqrt(0.95 * 0.05 / repetitions)
    assert (hits / repetitions > 0.94 - sampling).all(), hits / repetitions
    assert (hits / repetitions < 0.97 + sampling).all(), hits / repetitions


def test_censored_drives_are_not_left_out() -> None:
    """Leaving them out would put the median at 0.48 instead of 0.69."""
    events = censored(np.random.default_rng(3), 4000)
    assert MEDIAN in event_curve(events).quantile(0.5)
    assert np.median(events.time[events.observed]) < 0.9 * event_curve(events).quantile(0.5).low


def test_what_is_not_reached_is_infinite() -> None:
    found = detection(EventTimes([5.0, 8.0, 60.0, 60.0, 60.0], [True, True, False, False, False]), limit=30.0)
    assert (found.median.value, found.median.high) == (math.inf, math.inf)
    assert found.median.json()["here"] is None
    assert (found.detected, found.drives) == (2, 5)
    never = detection(EventTimes([60.0, 60.0], [False, False]), limit=30.0)
    assert never.q95 == Interval(math.inf, math.inf, math.inf)
    assert never.by_limit == proportion_interval(0, 2)


def test_share_by_a_limit_is_exact_without_censoring() -> None:
    events = EventTimes(np.arange(1.0, 21.0), np.ones(20))
    for limit, count in ((0.5, 0), (7.0, 7), (20.0, 20)):
        found, exact = share_by(events, limit), proportion_interval(count, 20)
        assert (found.value, found.low, found.high) == pytest.approx((exact.value, exact.low, exact.high))


def test_share_beyond_the_last_watched_time_has_no_upper_limit() -> None:
    assert share_by(EventTimes([1.0, 2.0, 3.0], [True, False, False]), 10.0).high == 1.0
    assert share_by(EventTimes([1.0, 2.0], [False, False]), 10.0) == Interval(0.0, 0.0, 1.0)


def test_a_last_lone_drive_does_not_raise_the_lower_limit() -> None:
    time = np.concatenate([np.full(10, 1.0), np.full(9, 2.0), [3.0]])
    curve = event_curve(EventTimes(time, time != 2.0))
    assert curve.share.value.tolist() == [0.5, 1.0]
    assert curve.share.low[1] == curve.share.low[0]


def test_detection_time_runs_from_the_onset_to_the_first_alarm_after_it() -> None:
    found = detection_times([[3.0, 25.0, 22.0], [], [5.0], [10.0]], onset=[20.0, 20.0, 20.0, 10.0], end=[60.0] * 4)
    assert found.time.tolist() == [2.0, 40.0, 40.0, 0.0]
    assert found.observed.tolist() == [True, False, False, True]


def test_isolation_counts_exactly_the_right_wheels_given_an_alarm() -> None:
    named = [("fl",), ("rr", "fl"), None, ("fl", "fr"), ()]
    truth = [("fl",), ("fl", "rr"), ("fl",), ("fl",), ("rl",)]
    assert isolation_rate(named, truth) == proportion_interval(2, 4)
    table = confusion(named, truth)
    assert table.counts["fl"] == {"fl": 1, "fl fr": 1, "fl rr": 0, "none": 0, "rl": 0}
    assert table.counts["rl"]["none"] == 1
    assert table.share("fl", "fl fr") == proportion_interval(1, 2)
    assert wheels_label(["rr", "fl"]) == "fl rr"


def test_alarms_closer_than_the_gap_are_one_episode() -> None:
    assert episodes([0.0, 5.0, 9.0, 30.0, 31.0, 100.0], gap=10.0) == 3
    assert episodes([], gap=10.0) == 0
    found = false_alarms([[0.0, 5.0], [], [100.0, 300.0]], [3600.0, 3600.0, 1800.0], gap=10.0)
    assert (found.count, found.hours, found.rate.value) == (3, 2.5, pytest.approx(1.2))


def test_no_false_alarm_still_bounds_the_rate() -> None:
    assert false_alarms([[], []], [3600.0, 7200.0], gap=1.0).rate.high == pytest.approx(3.689 / 3.0, rel=1e-4)


@pytest.mark.parametrize(
    ("call", "value", "valid"),
    [
        (lambda: EventTimes([], []), r"\(0,\)", "n at least 1"),
        (lambda: EventTimes([math.inf], [True]), "inf", "finite"),
        (lambda: detection(EventTimes([1.0], [True]), limit=0.0), "0.0", "above 0"),
        (lambda: event_curve(EventTimes([1.0], [True])).quantile(1.0), "1.0", "below 1"),
        (lambda: detection_times([[1.0]], [5.0], [4.0]), "4.0", "after the onset"),
        (lambda: detection_times([[1.0]], [5.0, 6.0], [7.0, 8.0]), r"\(2,\)", r"\(1,\)"),
        (lambda: isolation_rate([None], [("fl",)]), "no alarm", "at least one"),
        (lambda: isolation_rate([("xx",)], [("fl",)]), "'xx'", "fl, fr, rl, rr"),
        (lambda: isolation_rate([("fl",)], []), "1 drives", "0"),
        (lambda: confusion([("fl",)], [("fl",)]).share("rr", "fl"), "'rr'", "fl"),
        (lambda: false_alarms([], [], gap=1.0), "0 drives", "one"),
        (lambda: false_alarms([[]], [0.0], gap=1.0), "0.0", "above 0"),
        (lambda: false_alarms([[]], [-1.0], gap=1.0), "-1", "from 0"),
        (lambda: episodes([1.0], gap=-1.0), "-1.0", "from 0"),
        (lambda: episodes([math.nan], gap=1.0), "nan", "finite"),
    ],
)
def test_bad_input_is_refused_in_one_line(call: Callable[[], object], value: str, valid: str) -> None:
    with pytest.raises(ValueError, match=f"{value}.*valid: .*{valid}") as refused:
        call()
    assert "\n" not in str(refused.value)
