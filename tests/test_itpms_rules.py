"""Claims about the decisions of `itpms`: alarm, published voting scheme, thresholds, and the bound beside them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from estimators.itpms.alarm import PATIENCE, AlarmRule
from estimators.itpms.mode_grid import BLOCK
from estimators.itpms.monitor import SAME_ROAD
from estimators.itpms.patterns import Judgement
from estimators.itpms.thresholds import FALSE_ALARMS_PER_HOUR, SPAN, TUNED, threshold_of
from estimators.itpms.voting import Thresholds, Vote, warning
from testbed.study.itpms_fusion.bound import ARL0, detection_bound, found_by_level, information, wandering_bound


def _judgement(statistic: float, pattern: tuple[int, ...], certainty: float = 1.0, lost: float = 0.15) -> Judgement:
    best = np.array([w in pattern for w in range(4)])
    change = np.where(best, math.log1p(-lost), 0.0)
    return Judgement(statistic, 0, best.astype(float), best, certainty, change, np.full(4, 0.01), np.full(4, 1e-4))


def test_alarm_waits_for_certainty_but_not_for_long_and_is_latched() -> None:
    rule = AlarmRule(10.0)
    assert rule.step(None) is None
    assert rule.step(_judgement(9.0, (0,))) is None
    assert rule.step(_judgement(11.0, (0,), lost=0.02)) is None
    assert rule.step(_judgement(11.0, (0,), certainty=0.7)) is None
    named = rule.step(_judgement(11.0, (0,)))
    assert named is not None
    assert named.wheels == ("fl",)
    assert all(rule.step(_judgement(12.0, (0,))) is None for _ in range(20))
    further = [rule.step(_judgement(20.0, (0, 3))) for _ in range(PATIENCE + 2)]
    assert [f.wheels for f in further if f] == [("fl", "rr")]
    unsure = AlarmRule(10.0)
    told = [unsure.step(_judgement(11.0, (1,), certainty=0.6)) for _ in range(PATIENCE + 1)]
    assert told[-1] is not None
    assert not any(told[:-1])


H = Thresholds(agreed=5.0, vibration=9.0, radius=11.0)


@pytest.mark.parametrize(
    ("vibration", "radius", "warned"),
    [
        (Vote(("fl",), 4.0), Vote(("fl",), 6.1), ("fl",)),
        (Vote(("fl",), 4.0), Vote(("fl",), 5.9), ()),
        (Vote(("fl",), 9.1), Vote(("fr",), 4.0), ("fl",)),
        (Vote(("fl",), 8.9), Vote(("fr",), 11.1), ("fr",)),
        (Vote(("fl",), 8.9), Vote(("fr",), 10.9), ()),
        (Vote(("fl",), 9.1), Vote(("fr",), 11.1), ("fl", "fr")),
        (Vote(("fl",), 9.1), Vote(), ("fl",)),
        (Vote(), Vote(), ()),
    ],
)
def test_voting_scheme_as_published(vibration: Vote, radius: Vote, warned: tuple[str, ...]) -> None:
    assert warning(vibration, radius, H) == warned


def test_agreement_needs_less_than_either_alone() -> None:
    assert TUNED.voting.agreed < min(TUNED.voting.vibration, TUNED.voting.radius)
    with pytest.raises(ValueError, match="h0 is 9"):
        Thresholds(9.0, 9.0, 11.0)


def test_threshold_has_its_rate_on_a_statistic_of_known_tail() -> None:
    """Exponential maxima: P(x > h) = exp(-h), so one alarm in 100 h of spans is at h = ln(spans)."""
    found = threshold_of(np.random.default_rng(8).exponential(size=20_000))
    spans = 3600.0 / (SPAN * FALSE_ALARMS_PER_HOUR)
    assert found.threshold == pytest.approx(math.log(spans), rel=0.1)
    assert found.arl0.low < spans < found.arl0.high


def test_bound_is_the_time_to_gather_the_threshold() -> None:
    speed = np.concatenate([np.full(10, 20.0), np.zeros(10), np.full(300, 20.0)])
    rate = 0.5 * information(np.array([20.0]), 1, np.array([0.15]))[0]
    waited = detection_bound(speed, 10.0, 0.0, 1, 0.15)
    assert waited == pytest.approx(10.0 + math.log(ARL0) / rate)
    assert detection_bound(speed, 10.0, 0.0, 4, 0.15) == pytest.approx(10.0 + math.log(ARL0) / rate / 4.0)
    assert detection_bound(np.zeros(50), 0.0, 0.0, 4, 0.15) is None


def test_bound_of_a_leak_gathers_while_it_leaks() -> None:
    """Slowly enough it is known before the share is lost; the same leak ten times faster later than at once."""
    speed = np.full(600, 20.0)
    assert detection_bound(speed, 100.0, 120.0, 4, 0.15) == 0.0
    sudden, leak = (detection_bound(speed, 100.0, within, 1, 0.10) for within in (0.0, 6.0))
    assert sudden is not None
    assert leak is not None
    assert sudden - 6.0 < leak < sudden


def test_bound_of_a_wandering_car_knows_the_day_and_the_road_that_two_wheels_share() -> None:
    """One tyre of 10 %: of a well-known car no sooner than its neighbour's road allows, later where it is read seldom,
    or the loss is smaller; never while the car stands."""
    steady = np.full(400, 20.0)
    alone, known = (bound(steady, 100.0, 0.0, 1, 0.10) for bound in (detection_bound, wandering_bound))
    assert alone is not None
    assert known is not None
    assert (1.0 - SAME_ROAD**2) * alone <= known <= alone + BLOCK
    slow = np.where(np.arange(400) % 40 < 8, 12.0, 0.0)
    waited = wandering_bound(slow, 100.0, 0.0, 1, 0.10)
    assert waited is None or waited > 5.0 * known
    small, great = (wandering_bound(steady, 100.0, 0.0, 1, share) for share in (0.05, 0.25))
    assert small is not None
    assert great is not None
    assert small > known >= great
    assert wandering_bound(np.zeros(400), 100.0, 0.0, 1, 0.10) is None


def test_equal_losses_are_the_harder_to_know_the_farther_from_what_was_learnt() -> None:
    shares = [found_by_level(0.2, 20.0, driven) for driven in (20.0, 25.0, 30.0, 36.0)]
    assert shares == sorted(shares, reverse=True)
    assert shares[0] > 0.99
    common = math.hypot(0.005, 0.5 * 0.002)  # at the speed learnt, 20 m/s: the day alone
    z = 0.334 * -math.log(0.8) / common - math.sqrt(2.0 * TUNED.alone["fused"])
    assert shares[0] == pytest.approx(stats.norm.cdf(z), abs=1e-3)
    assert found_by_level(1e-6, 20.0, 20.0) < 1e-5
