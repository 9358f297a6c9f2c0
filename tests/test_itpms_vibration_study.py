"""The figures of the study `itpms-vibration`, from made-up rows of which they are known, and its known process."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import welch

from estimators.vibration.modes import ANTIPHASE
from estimators.wheel_speed.resampling import RATE, droop
from testbed.study.itpms_vibration.bound import frequency_bound
from testbed.study.itpms_vibration.drives import CELLS, KNOWN, RATIOS, known_process, made_up_wheel
from testbed.study.itpms_vibration.itpms_vibration import ItpmsVibrationStudy
from testbed.study.itpms_vibration.linearised import mode_at
from testbed.study.itpms_vibration.listening import METHODS, timer_noise, words
from testbed.study.itpms_vibration.rows_of_scatter import median_of_worst

OMEGA = 60.0
PARAMETERS = [math.log(86.0), math.log(0.07), -14.0, -0.6, 3.5, -17.0, -24.0]
BOUND = frequency_bound(ANTIPHASE, np.array(PARAMETERS), 60.0, 48.0 * OMEGA / (2.0 * math.pi))
SCATTER = {"vibration": 1.2, "fft": 3.0, "ar2_rls": 2.0, "ar2_kalman": 2.5}  # std over bound
SHIFT = {"vibration": 0.05, "fft": -1.0, "ar2_rls": 9.0, "ar2_kalman": 8.0}  # Hz at 100 % of noise, a third at 30 %
SENSITIVITY = 0.34
REPETITIONS = 200


def _words(values):
    return {**dict(zip(METHODS, values, strict=True)), "std": 1.2 * BOUND, "excitation": 9.0, "parameters": PARAMETERS}


def _rows():
    rng = np.random.default_rng(0)
    road, speed, mode = CELLS[0]
    rows = []
    for number in range(REPETITIONS):
        cell = {"kind": "cell", "road": road, "speed": speed, "mode": mode}
        values = [[86.0 + SCATTER[m] * BOUND * rng.standard_normal() for m in METHODS] for _ in range(4)]
        level = [10.0 * timer_noise(OMEGA, ANTIPHASE.frequency, 1e-6)] * 4
        rows.append({"task": cell, "omega": [OMEGA] * 4, "words": [_words(v) for v in values], "level": level})
        truth = KNOWN[mode][0]
        shares = [[[{m: truth + s * SHIFT[m] for m in METHODS}] * 8 for s in (0.0, 1.0 / 3.0, 1.0)]] * 3
        rows.append({"task": {"kind": "known", "mode": mode}, "words": shares})
        for ratio in RATIOS:
            low = {"ratio": ratio, "mode": mode, "number": number}
            said = [_words([86.5 * ratio**SENSITIVITY] * 4)] * 4
            rows.append({"task": {"kind": "pressure", **low}, "words": [said] * (3 if ratio == 1.0 else 1)})
            change = [[4.45 + 0.33 * math.log(ratio), 0.005]] * 3
            rows.append({"task": {"kind": "run", **low}, "means": [*change, None if number % 2 else change[0]]})
    return rows


@pytest.fixture(scope="module")
def table():
    return {row.name: row for row in ItpmsVibrationStudy().table(_rows())}


@pytest.mark.parametrize("method", METHODS)
def test_figures_of_a_method_are_those_of_the_rows(table, method):
    assert table[f"{method}_std_over_bound"].here == pytest.approx(SCATTER[method], rel=0.1)
    assert table[f"{method}_bias_hz"].here == pytest.approx(SHIFT[method])
    assert table[f"{method}_bias_hz_known_process_30_percent"].here == pytest.approx(SHIFT[method] / 3.0)
    assert table[f"{method}_bias_hz_car_100_percent"].here == pytest.approx(0.0)
    assert table[f"{method}_sensitivity_antiphase"].here == pytest.approx(SENSITIVITY)


def test_figures_of_the_drives_are_those_of_the_rows(table):
    assert table["vibration_std_over_bound"].limit == 1.5
    assert table["vibration_bias_hz"].limit == 0.1
    assert table["vibration_std_over_bound_worst_by_chance"].here == pytest.approx(SCATTER["vibration"], rel=0.1)
    assert table["vibration_std_over_reported"].here == pytest.approx(1.0, rel=0.1)
    assert table["signal_to_timing_noise_1_us_antiphase_A_60_km_h"].here == pytest.approx(10.0)
    assert table["signal_to_timing_noise_5_us_antiphase_A_60_km_h"].here == pytest.approx(0.4)
    assert table["bound_60_s_antiphase_A_60_km_h"].here == pytest.approx(BOUND)
    linear = np.mean([mode_at(80.0, 1.0)[axle]["antiphase"][0] for axle in ("front", "rear")])
    assert table["vibration_minus_linearised_hz_antiphase"].here == pytest.approx(86.5 - linear)


def test_worst_of_like_cells_is_what_chance_makes_it():
    """Against 20 000 draws of eleven cells; and the study's row from its pooled figure."""
    squares = np.random.default_rng(3).chisquare(28, (20_000, 11)) / 28.0
    assert median_of_worst([28] * 11) == pytest.approx(np.sqrt(np.median(squares.max(axis=1))), rel=0.01)
    assert median_of_worst([10_000_000]) == pytest.approx(1.0, abs=1e-3)


def test_added_noise_and_its_opposite_cancel_what_they_share_with_the_drive():
    """A known process of 30 s: the mean of a noise added and taken off scatters less than half as much as either."""
    signal = known_process("antiphase", KNOWN["antiphase"][2][1], 30.0, 5)
    heard = made_up_wheel(80.0 / 3.6 / 0.36 + signal)
    noises = [0.3 * np.std(signal) * np.random.default_rng(k).standard_normal(len(signal)) for k in range(6)]
    said = np.array([[words(heard, 0.36, ANTIPHASE, sign * n)["vibration"] for sign in (1.0, -1.0)] for n in noises])
    assert np.std(said.mean(axis=1)) < 0.5 * np.std(said[:, 0])


def test_a_wheel_that_was_not_heard_counts_as_not_separated(table):
    assert table["share_separated_15_percent"].here == pytest.approx(0.875)


def test_known_process_has_the_spectrum_it_says():
    """Welch over an hour against the closed form, within the band; its level is set by its r.m.s."""
    shape = KNOWN["antiphase"][2][1]
    signal = known_process("antiphase", shape, 3600.0, 1)
    f, power = welch(signal, RATE, nperseg=round(RATE))
    inside = (f >= 60.0) & (f <= 115.0)
    f, power = f[inside], power[inside]
    frequency, damping, _ = KNOWN["antiphase"]
    x, u = f / frequency, np.log(f / ANTIPHASE.frequency)
    form = np.exp(u * shape[1] + u**2 * shape[2]) / ((1.0 - x**2) ** 2 + (2.0 * damping * x) ** 2)
    form *= droop(f, 48.0 * shape[0] / 3.6 / (2.0 * np.pi * 0.36)) ** 2
    ratio = power / form
    assert np.std(ratio) / np.mean(ratio) < 0.05
    assert np.std(signal) == pytest.approx(0.01)
