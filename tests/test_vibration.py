"""Claims about the vibration analysis: a Gaussian process of known frequency, roads without excitation, bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest

from estimators.car import Car
from estimators.drive_log import Signal
from estimators.vibration.estimator import VibrationEstimator
from estimators.vibration.mode_frequency import NOISE_BAND, ModeFrequency
from estimators.vibration.modes import ANTIPHASE, IN_PHASE
from estimators.vibration.published.ar2 import (
    VAGUE,
    coefficients,
    kalman,
    least_squares,
    natural_frequency,
    pole_angle,
    recursion,
    spectral_peak,
)
from estimators.vibration.published.fft_batch import peak_frequency
from estimators.vibration.spectral_fit import FREQUENCY, SIZE, density, fit
from estimators.vibration.vibration import Vibration
from estimators.vibration.wheel_vibration import WheelVibration
from estimators.wheel_speed.edge_speed import TEETH, Samples
from estimators.wheel_speed.resampling import RATE, droop
from testbed.study.itpms_vibration.bound import frequency_bound
from testbed.study.itpms_vibration.drives import known_process
from tests.synthetic_drive import tooth_edges

SPEED = 80.0 / 3.6
OMEGA = SPEED / 0.36
SIZE_OF_SECOND = round(RATE)


def process(seconds, seed, v=SPEED, frequency=84.0):
    """Wheel speed less its mean [rad/s] with the antiphase mode at `frequency` [Hz], at v [m/s]."""
    return known_process("antiphase", (3.6 * v, -0.6, 3.5), seconds, seed, frequency)


def listened(speed, seconds, analysis=None):
    """All readings of a wheel's samples [rad/s], second by second."""
    analysis, said = analysis or WheelVibration("fl", 0.36), []
    for i in range(seconds):
        part = speed[SIZE_OF_SECOND * i : SIZE_OF_SECOND * (i + 1)]
        said += analysis.advance(Samples(SIZE_OF_SECOND * i, part, float(TEETH)), i + 1.0, math.inf)
    return said


def running(said, mode=ANTIPHASE):
    return [r for r in said if r.kind == "running" and r.mode is mode]


@pytest.fixture(scope="module")
def many():
    """Readings of 40 records of 60 s of a mode at 84 Hz."""
    records = [OMEGA + process(60.0, seed, SPEED) for seed in range(40)]
    return [listened(record, 60) for record in records]


def test_frequency_is_right_and_its_std_is_honest(many):
    """Bias within 3 standard errors and the bar of 0.1 Hz; scatter over reported std within its chi-square band."""
    last = [running(said)[-1] for said in many]
    error = np.array([r.frequency for r in last]) - 84.0
    reported = np.sqrt(np.mean([(r.frequency * r.ln_std) ** 2 for r in last]))
    assert abs(error.mean()) < 0.1 + 3.0 * error.std() / math.sqrt(len(error))
    assert 0.75 < error.std() / reported < 1.25  # chi-square of 40 records


def test_scatter_comes_near_the_bound(many):
    last = [running(said)[-1] for said in many]
    parameters = np.mean([r.parameters for r in last], axis=0)
    bound = frequency_bound(ANTIPHASE, parameters, 60.0, TEETH * OMEGA / (2.0 * np.pi))
    assert np.std([r.frequency for r in last]) < 1.5 * bound


def test_blocks_may_be_averaged(many):
    """Blocks of all records: their weighted mean is right to 0.1 Hz, and each is as far off as it says."""
    blocks = [r for said in many for r in said if r.kind == "block" and r.mode is ANTIPHASE]
    value, information = np.log([r.frequency for r in blocks]), np.array([r.information for r in blocks])
    mean = math.exp(value @ information / information.sum())
    normalised = (value - math.log(84.0)) * np.sqrt(information)
    assert len(blocks) == 40 * 7
    assert abs(mean - 84.0) < 0.1
    assert 0.8 < np.std(normalised) < 1.15
    assert abs(np.corrcoef(normalised[:-1], normalised[1:])[0, 1]) < 0.2


@pytest.mark.parametrize("share", [0.3, 1.0])
def test_white_noise_does_not_move_the_frequency(many, share):
    quiet = np.mean([running(said)[-1].frequency for said in many])
    noisy = []
    for seed in range(40):
        signal = process(60.0, seed, SPEED)
        noise = share * signal.std() * np.random.default_rng(1000 + seed).standard_normal(len(signal))
        noisy.append(running(listened(OMEGA + signal + noise, 60))[-1].frequency)
    assert abs(np.mean(noisy) - quiet) < 0.1


def test_std_grows_to_the_prior_without_excitation():
    """After a minute of road the wheel turns as smoothly as its timer can tell."""
    signal = process(60.0, 1, SPEED)
    timer = 5e-3 * np.random.default_rng(2).standard_normal(300 * SIZE_OF_SECOND)
    said = running(listened(np.concatenate([OMEGA + signal, OMEGA + timer]), 360))
    std = np.array([r.ln_std for r in said])
    assert std[59] < 0.01
    assert std[-1] > 0.5 * ANTIPHASE.frequency_std
    assert std[200] > 3.0 * std[59]


def test_std_grows_to_the_prior_at_standstill():
    signal = process(60.0, 1, SPEED)
    said = running(listened(np.concatenate([OMEGA + signal, np.full(240 * SIZE_OF_SECOND, np.nan)]), 300))
    std = np.array([r.ln_std for r in said])
    assert (np.diff(std[61::20]) >= 0.0).all()
    assert std[-1] == ANTIPHASE.frequency_std
    assert said[-1].frequency == ANTIPHASE.frequency
    assert said[-1].seconds == 0.0


def test_a_block_ends_where_the_speed_leaves_it():
    slow = 14.0 / 0.36 + process(6.0, 1, 14.0)
    fast = 36.0 / 0.36 + process(20.0, 2, 36.0)
    blocks = [r for r in listened(np.concatenate([slow, fast]), 26) if r.kind == "block"]
    speeds = [round(r.speed * 0.36) for r in blocks if r.mode is ANTIPHASE]
    assert speeds[0] == 14
    assert set(speeds[1:]) == {36}


def test_modes_are_read_only_where_the_road_excites_them():
    for v, wanted in ((5.0, set()), (10.0, {"in_phase"}), (15.0, {"in_phase", "antiphase"}), (40.0, {"antiphase"})):
        both = process(20.0, 3, v) + known_process("in_phase", (3.6 * v, 0.0, 6.0), 20.0, 4)
        said = listened(v / 0.36 + both, 20)
        assert {r.mode.name for r in said if r.seconds > 0.0} == wanted


def test_slopes_of_the_density_are_its_derivatives():
    f = np.arange(58.0, 119.0)
    p = np.array([math.log(86.0), math.log(0.07), -8.0, -1.0, 3.0, -11.0, -22.0])
    within = np.where(f < 110.0, 1.0, 0.0)
    white = droop(f, 470.0) ** -2.0

    def ln_density(q):
        total = np.empty(len(f))
        density(q, 87.0, f, within, white, np.empty(len(f)), total, np.empty((len(f), SIZE)))
        return np.log(total)

    slopes = np.empty((len(f), SIZE))
    density(p, 87.0, f, within, white, np.empty(len(f)), np.empty(len(f)), slopes)
    for a in range(SIZE):
        step = np.zeros(SIZE)
        step[a] = 1e-5
        assert slopes[:, a] == pytest.approx((ln_density(p + step) - ln_density(p - step)) / 2e-5, rel=1e-6, abs=1e-6)


def test_fit_of_the_exact_spectrum_finds_its_parameters():
    f = np.concatenate([np.arange(58.0, 119.0), np.arange(135.0, 166.0)])
    within = np.where(f < 120.0, 1.0, 0.0)
    white = droop(f, 470.0) ** -2.0
    true = np.array([math.log(79.0), math.log(0.08), -8.0, 1.0, 2.0, -12.0, -21.5])
    power, information = np.empty(len(f)), np.empty((SIZE, SIZE))
    density(true, 87.0, f, within, white, np.empty(len(f)), power, np.empty((len(f), SIZE)))
    p = np.array([math.log(87.0), math.log(0.075), -7.0, 0.0, 0.0, -10.0, -20.0])
    fit(p, 87.0, f, within, white, power, np.full(len(f), 1e4), p.copy(), np.full(SIZE, 1e-6), information)
    assert p == pytest.approx(true, abs=1e-2)
    assert abs(math.exp(p[FREQUENCY]) - 79.0) < 1e-3


def test_bound_of_a_lone_mode_is_the_textbook_one():
    """Only the mode, nothing else unknown, all frequencies: std(f0) = sqrt(zeta f0 / (2 pi T)). Here the other
    parameters are unknown and the band is cut, so the bound is above it, by less than three."""
    parameters = np.array([math.log(86.0), math.log(0.07), -8.0, 0.0, 0.0, -30.0, -60.0])
    textbook = math.sqrt(0.07 * 86.0 / (2.0 * math.pi * 60.0))
    assert 1.0 < frequency_bound(ANTIPHASE, parameters, 60.0, 1000.0) / textbook < 3.0
    assert NOISE_BAND[0] > ANTIPHASE.band[1]


@pytest.mark.parametrize(("f0", "zeta"), [(44.0, 0.08), (86.0, 0.07), (41.0, 0.3)])
def test_maps_of_ar2_to_a_frequency(f0, zeta):
    a1, a2 = coefficients(f0, zeta, RATE)
    omega = np.linspace(0.0, np.pi, 200001)
    spectrum = 1.0 / np.abs(1.0 + a1 * np.exp(-1j * omega) + a2 * np.exp(-2j * omega)) ** 2
    assert natural_frequency(a1, a2, RATE) == pytest.approx(f0)
    assert pole_angle(a1, a2, RATE) == pytest.approx(f0 * math.sqrt(1.0 - zeta**2))
    assert spectral_peak(a1, a2, RATE) == pytest.approx(RATE * omega[np.argmax(spectrum)] / 2.0 / np.pi, abs=1e-3)
    assert math.isnan(natural_frequency(-1.9, 0.9, RATE))


def _ar2(f0, zeta, seed, n=40000):
    a1, a2 = coefficients(f0, zeta, RATE)
    y, e = np.zeros(n), np.random.default_rng(seed).standard_normal(n)
    for t in range(2, n):
        y[t] = -a1 * y[t - 1] - a2 * y[t - 2] + e[t]
    return y


def test_recursive_least_squares_is_weighted_least_squares():
    y = _ar2(44.0, 0.08, 0, 2000)
    out, forgetting = np.empty((len(y), 2)), 0.998
    recursion(y, forgetting, forgetting, 0.0, 1e9, out)
    weight = forgetting ** np.arange(len(y) - 3, -1, -1)
    rows = -np.column_stack([y[1:-1], y[:-2]])
    direct = np.linalg.solve(rows.T @ (weight[:, None] * rows), rows.T @ (weight * y[2:]))
    assert out[-1] == pytest.approx(direct, rel=1e-6)


def test_kalman_filter_equals_its_plain_twin():
    y = _ar2(44.0, 0.08, 1, 500)
    out = np.empty((len(y), 2))
    recursion(y, 1.0, 0.3, 1e-6, VAGUE, out)
    x, p = np.zeros(2), VAGUE * np.eye(2)
    for t in range(2, len(y)):
        row = -np.array([y[t - 1], y[t - 2]])
        gain = p @ row / (0.3 + row @ p @ row)
        x = x + gain * (y[t] - row @ x)
        p = p - np.outer(gain, row @ p) + 1e-6 * np.eye(2)
    assert out[-1] == pytest.approx(x, rel=1e-6)


def test_published_ar2_is_right_without_noise_and_moves_with_it():
    y = _ar2(86.0, 0.07, 2)
    noise = np.random.default_rng(3).standard_normal(len(y)) * y.std()
    for method in (least_squares, lambda x, rate: kalman(x, rate, 0.1)):
        found = [natural_frequency(*map(float, method(y + s * noise, RATE)[-1]), RATE) for s in (0.0, 0.3, 1.0)]
        assert abs(found[0] - 86.0) < 0.6
        assert found[1] - 86.0 > 0.8  # more than two per cent of pressure
        assert found[2] - 86.0 > 5.0  # more than all of the effect of 15 %


def test_published_fft_finds_the_peak():
    signal = process(30.0, 5, SPEED, 86.0)
    assert abs(peak_frequency(OMEGA + signal, RATE, ANTIPHASE.band) - 86.0) < 3.0


def _log(speed, seconds, wheels=("fl", "fr", "rl", "rr"), edges=True, rate=100.0):
    """Signals of a car at a constant wheel speed with vibration."""
    found = {}
    for i, wheel in enumerate(wheels):
        time = np.arange(seconds * 1000) / 1000.0
        omega = speed / 0.36 + np.interp(time, np.arange(seconds * 400) / 400.0, process(seconds, i, 22.0, 86.0))
        if edges:
            found[f"wheel/{wheel}/edges"] = tooth_edges(time, omega, i)
        every = round(1000 / rate)
        found[f"wheel/{wheel}/speed"] = Signal(time[::every], omega[::every], "rad/s")
    return found


def test_a_slow_bus_speed_alone_is_called_unobservable_and_nothing_is_estimated():
    heard = Vibration(Car()).update(_log(22.0, 5, edges=False), 10.0)
    texts = " | ".join(flag.text for flag in heard.flags)
    assert heard.readings == ()
    for wheel in ("fl", "fr", "rl", "rr"):
        assert f"wheel/{wheel}/speed: antiphase and in_phase frequency not observable at 100 Hz" in texts


def test_a_fast_bus_speed_is_read_as_far_as_it_goes():
    heard = Vibration(Car()).update(_log(15.0, 12, edges=False, rate=200.0), 20.0)
    assert {r.mode for r in heard.readings} == {IN_PHASE}
    heard = Vibration(Car()).update(_log(22.0, 12, edges=False, rate=500.0), 20.0)
    last = [r for r in heard.readings if r.mode is ANTIPHASE and r.wheel == "rr"][-1]
    assert abs(last.frequency - 86.0) < 3.0


def test_one_dead_encoder_leaves_the_other_wheels():
    signals = _log(22.0, 20)
    del signals["wheel/rl/edges"], signals["wheel/rl/speed"]
    heard = Vibration(Car()).update(signals, 30.0)
    assert {r.wheel for r in heard.readings} == {"fl", "fr", "rr"}
    assert any("wheel/rl/edges: no usable sample" in flag.text for flag in heard.flags)
    last = [r for r in heard.readings if r.mode is ANTIPHASE and r.wheel == "fl"][-1]
    assert last.ln_std < 0.03
    assert abs(last.frequency - 86.0) < 3.0


@pytest.mark.parametrize(("speed", "said_at"), [(5.0, [31.0] * 4), (22.0, [])])
def test_a_wheel_is_missed_only_after_a_batch_without_a_mode(speed, said_at):
    """Too slow for any mode is said once, 30 s after the first reading; a mode heard within them is never missed."""
    said = VibrationEstimator(Car()).update(_log(speed, 40), 40.0)
    assert [flag.time for flag in said.flags if "no mode is heard" in flag.text] == said_at


def test_after_an_hour_of_silence_nothing_is_remembered():
    signals = _log(22.0, 20, wheels=("fl",))
    later = {name: Signal(s.time + 5000.0, s.value, s.unit) for name, s in signals.items()}
    vibration = Vibration(Car())
    vibration.update(signals, 20.0)
    first = next(r for r in vibration.update(later, 5003.0).readings if r.time > 5000.0)
    assert first.ln_std == first.mode.frequency_std


@pytest.mark.parametrize(
    ("document", "complaint"),
    [
        ({}, "valid: teeth"),
        ({"teeth": 1}, "valid: teeth"),
        ({"teeth": {"xx": {}}}, "wheel 'xx', valid: fl, fr, rl, rr"),
    ],
)
def test_a_calibration_that_is_none_is_refused(document, complaint):
    with pytest.raises(ValueError, match=complaint):
        Vibration(Car()).use_calibration(document)


def test_declared_modes_are_those_of_the_linearised_car():
    """Frequency within 5 %, sensitivity within 15 % of `modes`, at a speed at which the mode is read."""
    from testbed.study.itpms_vibration.linearised import mode_at, sensitivity

    for mode, speed in ((ANTIPHASE, 80.0), (IN_PHASE, 45.0)):
        for axle in ("front", "rear"):
            frequency, damping = mode_at(speed, 1.0)[axle][mode.name]
            assert abs(frequency / mode.frequency - 1.0) < 0.05
            assert abs(math.log(damping / mode.damping)) < mode.damping_std
        assert abs(sensitivity(mode.name, speed, 0.7) / mode.sensitivity - 1.0) < 0.15


def test_too_few_lines_give_no_frequency():
    from estimators.vibration.spectrum import Spectrum

    assert ModeFrequency(ANTIPHASE).fitted(Spectrum(), None) is None
