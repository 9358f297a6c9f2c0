"""Claims about the bias of the Whittle fit: what its priors do to a spectrum without scatter, and the patch's slope."""

from __future__ import annotations

import math

import numpy as np
import pytest

from estimators.vibration.mode_frequency import ModeFrequency
from estimators.vibration.modes import ANTIPHASE, IN_PHASE, PATCH
from estimators.vibration.spectrum import LINES, USABLE, Segment, Spectrum
from estimators.wheel_speed.edge_speed import TEETH
from estimators.wheel_speed.resampling import RATE, droop
from testbed.study.itpms_vibration.drives import KNOWN, RADIUS, known_process, last_word, made_up_wheel
from testbed.study.itpms_vibration.listening import last_running, readings

FREQUENCY, DAMPING = 84.0, 0.07


def without_scatter(kmh, slope, bend, noise):
    """Spectrum of a minute whose every periodogram is the expected one; noise: r.m.s. over that of the mode."""
    omega = kmh / 3.6 / RADIUS
    tooth_rate = TEETH * omega / (2.0 * math.pi)
    x, u = LINES / FREQUENCY, np.log(np.maximum(LINES, 1.0) / ANTIPHASE.frequency)
    inside = (LINES > 54.0) & (LINES < 116.0)
    mode = np.where(inside, np.exp(u * (slope + u * bend)) / ((1.0 - x**2) ** 2 + (2.0 * DAMPING * x) ** 2), 0.0)
    used = USABLE * tooth_rate > LINES
    white = np.where(used, droop(LINES, tooth_rate), 1.0) ** -2.0
    power = mode / np.sum(mode / white) + noise**2 * 2.0 / RATE * white  # lines are 1 Hz apart
    spectrum = Spectrum()
    for _ in range(119):
        spectrum.add(Segment(omega, tooth_rate, 1e-4 * power, white, used))
    return spectrum


@pytest.mark.parametrize(
    ("shape", "most"),
    [(shape, 0.08) for shape in KNOWN["antiphase"][2]] + [((50.0, -5.0, 0.0), 0.2)],
)
def test_priors_draw_the_frequency_by_less_than_the_bias_allowed(shape, most):
    """Noise as large as the signal. At 50 km/h, near the patch's gap, a prior of one slope for all speeds: 0.35 Hz."""
    fitted = ModeFrequency(ANTIPHASE, RADIUS).fitted(without_scatter(*shape, 1.0), None)
    assert abs(fitted.frequency - FREQUENCY) < most


def test_patch_slope_is_that_of_a_moving_average():
    for mode, speed in ((ANTIPHASE, 14.0), (ANTIPHASE, 36.0), (IN_PHASE, 9.0)):
        f = mode.frequency * np.array([0.9999, 1.0001])
        tilt = np.diff(np.log(np.sinc(PATCH * f / speed) ** 2)) / np.diff(np.log(f))
        assert mode.patch_slope(speed) == pytest.approx(float(tilt[0]), abs=1e-3)


def test_patch_slope_ends_at_the_gap():
    gap = ANTIPHASE.frequency * PATCH
    assert ANTIPHASE.patch_slope(gap) == ANTIPHASE.patch_slope(0.0) == ANTIPHASE.patch_slope(0.1 * gap)


def test_a_record_heard_in_one_stretch_says_what_it_says_second_by_second():
    for mode in (ANTIPHASE, IN_PHASE):
        shape = KNOWN[mode.name][2][0]
        speed = shape[0] / 3.6 / RADIUS + known_process(mode.name, shape, 60.0, 3)
        by_second = last_running(readings(made_up_wheel(speed), RADIUS), mode).frequency
        assert last_word(speed, mode) == pytest.approx(by_second, rel=1e-5)
