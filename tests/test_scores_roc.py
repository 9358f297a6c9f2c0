"""Claims about ROC, DET, the area under the curve and the operating point: two Gaussians have closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy import stats

from estimators.scores.interval import proportion_interval
from estimators.scores.roc import area, detection_band, operating_point, roc

SHIFT = 1.5  # of the faulty drives' statistic, in standard deviations
AREA = stats.norm.cdf(SHIFT / math.sqrt(2.0))


def drives(generator: np.random.Generator, sound: int, faulty: int) -> tuple[np.ndarray, np.ndarray]:
    return generator.standard_normal(sound), SHIFT + generator.standard_normal(faulty)


def test_area_of_two_gaussians_is_the_closed_form() -> None:
    found = area(*drives(np.random.default_rng(0), 20000, 20000))
    assert found.value == pytest.approx(AREA, abs=0.005)
    assert AREA in found


def test_area_covers_95_percent() -> None:
    generator, repetitions = np.random.default_rng(1), 2000
    covered = np.mean([AREA in area(*drives(generator, 40, 25)) for _ in range(repetitions)])
    assert covered == pytest.approx(0.95, abs=0.005 + 3.0 * math.sqrt(0.95 * 0.05 / repetitions))


def test_area_is_that_under_the_curve_and_the_share_of_right_pairs() -> None:
    generator = np.random.default_rng(2)
    sound, faulty = generator.integers(0, 6, 30), generator.integers(2, 9, 20)  # with ties
    curve = roc(sound, faulty)
    under = np.trapezoid(curve.detection.value, curve.false_alarm.value)
    pairs = np.sign(faulty[:, None] - sound[None, :]).mean() / 2.0 + 0.5
    assert area(sound, faulty).value == pytest.approx(under)
    assert area(sound, faulty).value == pytest.approx(pairs)


def test_variance_is_delongs() -> None:
    """Against its definition by the matrix of all pairs."""
    sound, faulty = drives(np.random.default_rng(3), 12, 9)
    right = (faulty[None, :] > sound[:, None]).astype(float)
    variance = right.mean(axis=1).var(ddof=1) / 12 + right.mean(axis=0).var(ddof=1) / 9
    value = right.mean()
    reach = stats.norm.ppf(0.975) * math.sqrt(variance) / (value * (1.0 - value))
    found = area(sound, faulty)
    logit = math.log(value / (1.0 - value))
    assert (found.low, found.high) == pytest.approx([1.0 / (1.0 + math.exp(-logit + s * reach)) for s in (1, -1)])


def test_drives_that_separate_entirely_do_not_prove_an_area_of_one() -> None:
    found = area(np.arange(10.0), np.arange(20.0, 50.0))
    assert (found.value, found.high) == (1.0, 1.0)
    assert found.low == pytest.approx(0.025**0.1)
    assert area(np.arange(20.0, 50.0), np.arange(10.0)).high == pytest.approx(1.0 - 0.025**0.1)


def test_curve_starts_at_nothing_and_ends_at_everything() -> None:
    curve = roc([1.0, 2.0, math.nan], [2.0, 3.0])
    assert curve.threshold.tolist() == [math.inf, 3.0, 2.0, 1.0, -math.inf]
    assert curve.false_alarm.value.tolist() == [0.0, 0.0, 0.0, 0.5, 1.0]
    assert curve.detection.value.tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]
    assert curve.detection.at(2) == proportion_interval(1, 2)


def test_det_of_two_gaussians_is_a_straight_line_of_slope_minus_one() -> None:
    false_alarm, miss = roc(*drives(np.random.default_rng(4), 4000, 4000)).det()
    middle = (np.abs(false_alarm) < 1.6) & (np.abs(miss) < 1.6)
    assert miss[middle] == pytest.approx(-SHIFT - false_alarm[middle], abs=0.15)


def test_detection_at_a_share_of_false_alarms_covers_at_least_95_percent() -> None:
    generator, repetitions = np.random.default_rng(5), 1000
    threshold = stats.norm.isf(0.1)
    truth = stats.norm.sf(threshold - SHIFT)
    hits = np.zeros(2)
    for _ in range(repetitions):
        point = operating_point(*drives(generator, 100, 40), 0.1)
        hits += [truth in point.detection, threshold in point.threshold]
    assert (hits / repetitions > 0.95 - 3.0 * math.sqrt(0.95 * 0.05 / repetitions)).all(), hits / repetitions


def test_operating_point_keeps_the_share_of_false_alarms() -> None:
    sound, faulty = np.arange(100.0), np.arange(50.0, 150.0)
    point = operating_point(sound, faulty, 0.05)
    assert point.threshold.value == 94.0
    assert point.false_alarm.value == 0.05
    assert point.detection.value == np.mean(faulty > 94.0)


def test_few_sound_drives_promise_no_detection_at_a_low_share_of_false_alarms() -> None:
    point = operating_point(np.arange(20.0), np.arange(100.0, 120.0), 0.01)
    assert point.detection.value == 1.0
    assert point.detection.low == 0.0
    assert point.threshold.high == math.inf


def test_band_rises_with_the_share_of_false_alarms_and_holds_the_curve() -> None:
    band = detection_band(*drives(np.random.default_rng(6), 200, 100), np.linspace(0.02, 0.5, 25))
    for curve in (band.value, band.low, band.high):
        assert (np.diff(curve) >= 0.0).all()
    assert ((band.low <= band.value) & (band.value <= band.high)).all()


@pytest.mark.parametrize(
    ("call", "value", "valid"),
    [
        (lambda: roc([], [1.0]), "sound holds 0", "at least 1"),
        (lambda: roc([1.0], [math.nan]), "faulty holds 0", "at least 1"),
        (lambda: area([1.0], [1.0, 2.0]), "sound holds 1", "at least 2"),
        (lambda: area([1.0, math.inf], [1.0, 2.0]), "inf", "finite"),
        (lambda: operating_point([1.0], [2.0], 0.0), "0.0", "above 0"),
    ],
)
def test_bad_input_is_refused_in_one_line(call: Callable[[], object], value: str, valid: str) -> None:
    with pytest.raises(ValueError, match=f"{value}.*valid: .*{valid}") as refused:
        call()
    assert "\n" not in str(refused.value)
