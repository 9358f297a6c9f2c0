"""Claims about every detector at work: recursion, one form equal to the other, alarms, missing and broken samples."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError, replace
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from estimators.detectors import (
    CusumMean,
    CusumVariance,
    Ewma,
    Glr,
    Integrator,
    LocalCusum,
    Monitor,
    missing_samples,
)
from estimators.detectors.monitor import AFTER_ALARM
from tests.detector_cases import DETECTORS, assert_sound, broken_sequence, broken_sequences, sound_sequences

EACH = pytest.mark.parametrize("name", DETECTORS)
MODES = ("latch", "clear", "restart")


def noise(n: int, seed: int = 0) -> NDArray[np.float64]:
    return np.random.default_rng(seed).standard_normal(n)


def statistic(detector: object, x: list[float]) -> list[float]:
    return Monitor(detector).run(x).statistic.tolist()  # type: ignore[arg-type]


# --- recursions, against their definitions written out


def test_cusum_is_the_sum_above_its_lowest_value_so_far() -> None:
    """Page's form: g = S - min S, both from 0."""
    x = noise(500) + 0.2
    sums = np.concatenate([[0.0], np.cumsum(x - 0.5)])
    page = sums - np.minimum.accumulate(sums)
    np.testing.assert_allclose(Monitor(CusumMean(0.5, 9.0)).run(x).statistic, page[1:], atol=1e-12)
    np.testing.assert_allclose(Monitor(CusumMean(0.5, 9.0, "lower")).run(-x).statistic, page[1:], atol=1e-12)


def test_a_two_sided_cusum_is_the_larger_of_the_two() -> None:
    x = noise(500)
    up, down, both = (Monitor(CusumMean(0.5, 9.0, s)).run(x).statistic for s in ("upper", "lower", "both"))
    assert (np.maximum(up, down) == both).all()


def test_cusum_for_variance_is_a_cusum_of_the_square() -> None:
    x = noise(500)
    assert (
        Monitor(CusumVariance(1.6, 9.0)).run(x).statistic == Monitor(CusumMean(1.6, 9.0)).run(x * x).statistic
    ).all()
    assert statistic(CusumVariance(0.5, 9.0, "decrease"), [0.0, 0.5, 1.0]) == [0.5, 0.75, 0.25]


def test_gma_forgets_by_its_forgetting_factor() -> None:
    assert statistic(Ewma(0.75, 9.0), [4.0, 0.0, 0.0]) == [1.0, 0.75, 0.5625]
    assert statistic(Ewma(0.0, 9.0, "both"), [4.0, -3.0]) == [4.0, 3.0]
    assert statistic(Ewma(0.0, 9.0, "lower"), [4.0, -3.0]) == [0.0, 3.0]


@pytest.mark.parametrize("sides", ["upper", "lower", "both"])
def test_glr_is_the_largest_likelihood_ratio_in_the_window(sides: str) -> None:
    x = noise(60)
    window = 8
    expected = []
    for t in range(1, len(x) + 1):
        sums = [x[t - n : t].sum() for n in range(1, min(t, window) + 1)]
        kept = [s if sides == "both" or (s > 0) == (sides == "upper") else 0.0 for s in sums]
        expected.append(max(s * s / (2 * n) for n, s in enumerate(kept, 1)))
    np.testing.assert_allclose(Monitor(Glr(window, 50.0, sides)).run(x).statistic, expected, rtol=1e-12, atol=1e-15)


def test_a_local_cusum_does_not_see_what_is_beyond_its_limit_on_either_side() -> None:
    """The thesis' filter lets -9 pass, and the lower side alarms on it."""
    local = LocalCusum((2.0,), (0.5,), (1.0,), "both")
    assert statistic(local, [2.0, 9.0, -9.0, -1.0]) == [1.5, 1.0, 0.5, 0.5]


def test_a_local_cusum_without_a_limit_is_a_cusum() -> None:
    x = noise(300)
    ratio = Monitor(LocalCusum((inf,), (0.5,), (4.0,), "both")).run(x).statistic
    assert (ratio == Monitor(CusumMean(0.5, 4.0, "both")).run(x).statistic / 4.0).all()


def test_local_and_global_cusum_alarms_when_either_does() -> None:
    x = noise(5000) + 0.1
    both = Monitor(LocalCusum((1.5, inf), (0.3, 0.5), (3.0, 4.0))).run(x).alarm
    local = Monitor(LocalCusum((1.5,), (0.3,), (3.0,))).run(x).alarm
    assert (both == (local | Monitor(CusumMean(0.5, 4.0)).run(x).alarm)).all()
    assert both.any()
    assert not both.all()


def test_an_integrator_is_zeroed_every_period() -> None:
    assert statistic(Integrator(3, 9.0), [1.0, 2.0, -4.0, 1.0, 1.0, 1.0, -5.0]) == [1.0, 3.0, 1.0, 1.0, 2.0, 3.0, 5.0]
    assert statistic(Integrator(1, 9.0), [1.0, -2.0, 4.0]) == [1.0, 2.0, 4.0]


# --- one form and the other


@EACH
@pytest.mark.parametrize("mode", MODES)
def test_one_sample_at_a_time_equals_arrays_to_the_last_bit(name: str, mode: str) -> None:
    x = broken_sequence(np.random.default_rng(5), 400)
    x[:150] = noise(150) + 0.3
    whole, cut, single = (Monitor(DETECTORS[name], mode) for _ in range(3))
    at_once = whole.run(x)
    pieces = [cut.run(part) for part in np.split(x, [1, 2, 50, 333])]
    steps = [single.step(value) for value in x.tolist()]
    assert at_once.statistic.tobytes() == np.concatenate([p.statistic for p in pieces]).tobytes()
    assert at_once.statistic.tobytes() == np.array([s.statistic for s in steps]).tobytes()
    assert at_once.alarm.tolist() == [s.alarm for s in steps] == np.concatenate([p.alarm for p in pieces]).tolist()
    assert (whole.alarms, whole.used, whole.refused) == (single.alarms, single.used, single.refused)


# --- alarms


@EACH
def test_a_latched_alarm_stays_until_reset_and_a_clearing_one_does_not(name: str) -> None:
    quiet = 0.0 if "decrease" not in name else 3.0
    towards = {"lower": -1.0}.get(DETECTORS[name].sides, 1.0)
    change = np.full(300, 1.4 * towards if "decrease" not in name else 0.0)
    x = np.concatenate([change, np.full(3000, quiet)])
    if name in ("cusum variance", "gma two-sided", "ac", "glr lower"):
        x[:300] *= 3.0
    latched, clearing = Monitor(DETECTORS[name], "latch"), Monitor(DETECTORS[name], "clear")
    on = clearing.run(x).alarm
    first = int(np.argmax(on))
    assert on[first]
    assert not on[-1]
    assert latched.run(x).alarm.tolist() == [False] * first + [True] * (len(x) - first)
    assert latched.alarm
    assert latched.alarms == 1
    latched.reset()
    assert not latched.alarm
    assert latched.statistic == 0.0
    assert latched.step(quiet).alarm is False


@EACH
def test_restarting_makes_every_alarm_the_end_of_a_fresh_run(name: str) -> None:
    x = noise(4000) * 1.5
    restarting = Monitor(DETECTORS[name], "restart")
    ends = np.flatnonzero(restarting.run(x).alarm)
    assert restarting.alarms == len(ends) > 1
    fresh = Monitor(DETECTORS[name]).run(x[ends[0] + 1 :]).alarm
    assert ends[1] == ends[0] + 1 + np.argmax(fresh)


@EACH
def test_reset_forgets_everything_but_the_counts(name: str) -> None:
    used = Monitor(DETECTORS[name])
    used.run([3.0, np.nan, -3.0, 2.0])
    used.reset()
    x = noise(50)
    assert used.run(x).statistic.tobytes() == Monitor(DETECTORS[name]).run(x).statistic.tobytes()
    assert (used.used, used.refused) == (53, 1)


def test_an_alarm_needs_more_than_the_threshold() -> None:
    assert not Monitor(CusumMean(0.5, 1.0)).step(1.5).alarm
    assert Monitor(CusumMean(0.5, 1.0)).step(np.nextafter(1.5, 2.0)).alarm


# --- samples that are missing or no numbers


@EACH
@pytest.mark.parametrize("mode", MODES)
def test_what_is_no_number_leaves_statistic_and_alarm_as_they_were(name: str, mode: str) -> None:
    x = noise(300) + 0.8
    places = np.sort(np.random.default_rng(1).integers(0, 300, 60))
    broken = np.insert(x, places, np.random.default_rng(2).choice([np.nan, np.inf, -np.inf], 60))
    clean, dirty = Monitor(DETECTORS[name], mode), Monitor(DETECTORS[name], mode)
    kept = np.isfinite(broken)
    at_clean, at_dirty = clean.run(x), dirty.run(broken)
    assert at_clean.statistic.tobytes() == at_dirty.statistic[kept].tobytes()
    assert at_clean.alarm.tolist() == at_dirty.alarm[kept].tolist()
    assert (dirty.refused, dirty.used, clean.refused) == (60, 300, 0)
    if mode == "clear":
        for i in np.flatnonzero(~kept[1:]) + 1:
            assert at_dirty.statistic[i] == at_dirty.statistic[i - 1]
            assert at_dirty.alarm[i] == at_dirty.alarm[i - 1]


def test_gaps_are_counted_and_change_nothing() -> None:
    time = [0.0, 0.1, 0.2, 0.7, 0.8, np.nan, 0.75, 0.9, 2.0]
    lost = missing_samples(time, 0.1)
    assert lost.tolist() == [0, 0, 0, 4, 0, 0, 0, 0, 10]
    x = noise(9)
    with_gaps, without = Monitor(CusumMean(0.5, 4.0)), Monitor(CusumMean(0.5, 4.0))
    assert with_gaps.run(x, lost).statistic.tobytes() == without.run(x).statistic.tobytes()
    assert (with_gaps.missing, with_gaps.gaps, without.missing) == (14, 2, 0)
    with_gaps.step(0.0, missing=3)
    assert (with_gaps.missing, with_gaps.gaps) == (17, 3)


def test_an_absurd_sample_alarms_and_stays_finite() -> None:
    for name, detector in DETECTORS.items():
        if "local" in name:
            continue  # a limit hides it, by design
        monitor = Monitor(detector)
        value = {"lower": -1e308}.get(detector.sides, 1e308)
        readings = monitor.run([value] * 3 if "decrease" not in name else [0.0] * 9)
        assert readings.alarm.any(), name
        assert np.isfinite(readings.statistic).all(), name


samples = st.floats(allow_nan=True, allow_infinity=True, width=64) | st.floats(-5.0, 5.0) | st.just(float("nan"))


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(sorted(DETECTORS)), st.sampled_from(MODES), st.lists(samples, max_size=60))
def test_no_sequence_breaks_a_detector(name: str, mode: str, values: list[float]) -> None:
    monitor, x = Monitor(DETECTORS[name], mode), np.array(values, dtype=np.float64)
    assert_sound(monitor, x, monitor.run(x))


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(width=64), max_size=40), st.floats(1e-3, 1e3))
def test_no_time_stamps_break_the_count_of_gaps(stamps: list[float], period: float) -> None:
    lost = missing_samples(stamps, period)
    assert lost.shape == (len(stamps),)
    assert (lost >= 0).all()
    if len(stamps):
        Monitor(CusumMean(0.5, 4.0)).run(np.zeros(len(stamps)), lost)


def test_a_million_broken_sequences_break_no_detector() -> None:
    """Every detector in every mode; 1 to 32 samples with a step, a gap of NaN, infinities and wild values."""
    each = math.ceil(1_000_000 / (len(DETECTORS) * len(MODES)))
    generator, seen, alarms = np.random.default_rng(2024), 0, 0
    for detector in DETECTORS.values():
        for mode in AFTER_ALARM.values():
            x, length = broken_sequences(generator, each)
            numbers, state = detector.numbers(), np.empty(detector.state_size)
            sound, alarmed = sound_sequences(detector.kind, numbers, detector.level, mode, state, x, length)
            assert sound == each, detector
            seen, alarms = seen + sound, alarms + alarmed
    assert seen >= 1_000_000
    assert seen > alarms > 0.1 * seen


# --- bad parameters


@pytest.mark.parametrize(
    ("make", "complaint"),
    [
        (lambda: CusumMean(-1.0, 4.0), "drift is -1"),
        (lambda: CusumMean(0.5, -0.2), "threshold is -0.2, valid: a number at least 0"),
        (lambda: CusumMean(0.5, np.nan), "threshold is nan"),
        (lambda: CusumMean(0.5, 4.0, "left"), "sides is 'left', valid: upper, lower, both"),
        (lambda: CusumVariance(0.0, 4.0), "drift is 0, valid: a number above 0"),
        (lambda: CusumVariance(1.0, 4.0, "both"), "change is 'both', valid: increase, decrease"),
        (lambda: Ewma(1.0, 0.5), "forgetting is 1, valid: a number at least 0 and at most 0.999"),
        (lambda: Glr(0, 5.0), "window is 0, valid: a whole number from 1 to 500"),
        (lambda: Glr(2.5, 5.0), "window is 2.5"),  # type: ignore[arg-type]
        (lambda: Integrator(0, 5.0), "period is 0"),
        (lambda: LocalCusum((2.0,), (2.0,), (1.0,)), "drift is 2, valid: below the limit 2"),
        (lambda: LocalCusum((2.0,), (0.5,), (0.0,)), "threshold is 0, valid: a number above 0"),
        (lambda: LocalCusum((2.0, inf), (0.5,), (1.0,)), "2 limits, 1 drifts and 1 thresholds"),
        (lambda: LocalCusum((-1.0,), (0.5,), (1.0,)), "limit is -1"),
        (lambda: Monitor(CusumMean(0.5, 4.0), "stop"), "after_alarm is 'stop', valid: latch, clear, restart"),
        (lambda: Monitor(CusumMean(0.5, 4.0)).run(np.zeros((2, 2))), "want (n,)"),
        (lambda: Monitor(CusumMean(0.5, 4.0)).step(1.0, missing=-1), "at least 0"),
        (lambda: missing_samples([0.0, 1.0], 0.0), "period is 0"),
    ],
)
def test_parameters_that_make_no_sense_are_refused(make: object, complaint: str) -> None:
    with pytest.raises(ValueError) as refusal:  # noqa: PT011  the text is compared below
        make()  # type: ignore[operator]
    assert complaint in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_parameters_are_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        DETECTORS["cusum"].threshold = 1.0  # type: ignore[attr-defined]
    assert replace(CusumMean(0.5, 4.0), threshold=5.0).level == 5.0
