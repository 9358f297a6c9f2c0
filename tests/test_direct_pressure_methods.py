"""The published detector's reference values, and the working monitor on made-up tyres: leaks found, nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from estimators.detectors import CusumMean
from estimators.direct_pressure import numbers, thresholds
from estimators.direct_pressure.monitor import LEAK, PRESSURE, REFILL, SAID, SPEED, TEMPERATURE, follow, new_memory
from estimators.direct_pressure.published import PUBLISHED, follow_published, stationary_std
from estimators.drive_log import WHEELS, DriveLog, Signal
from estimators.runner import run

NOMINAL = 250e3  # Pa


def told(time, pressure, temperature=293.15, speed=None):
    """What the monitor says of pressure samples [Pa] at `time` [s], temperature [K], wheel speed [rad/s] (None: no
    sensor)."""
    known = [(SPEED, speed), (TEMPERATURE, temperature), (PRESSURE, pressure)]
    kinds = [(kind, np.broadcast_to(value, time.shape)) for kind, value in known if value is not None]
    value = np.stack([values for _, values in kinds], axis=1).reshape(-1)
    said = np.zeros((len(time), len(SAID)))
    kind = np.tile([kind for kind, _ in kinds], len(time))
    assert follow(new_memory(), np.repeat(time, len(kinds)), kind, value, said) == len(time)
    return {name: said[:, i] for i, name in enumerate(SAID)}


def leaking(interval, rate, onset, end, noise, step, seed=0):
    """Times [s] and samples [Pa] of a tyre with an orifice: dp/dt = -rate p / NOMINAL."""
    time = np.arange(0.0, end, interval)
    pressure = NOMINAL * np.exp(-rate / NOMINAL * np.maximum(time - onset, 0.0))
    pressure = pressure + noise * np.random.default_rng(seed).standard_normal(len(time))
    return time, step * np.rint(pressure / step) if step else pressure


def test_published_filter_settles_at_0_2127_psi_not_at_0_15() -> None:
    after, before = stationary_std()
    assert after == pytest.approx(0.2127, abs=5e-5)
    assert before == pytest.approx(0.2351, abs=5e-5)
    out = follow_published(PUBLISHED, np.full(200, 32.0), np.zeros(200))
    assert out[-1, 1] == pytest.approx(after, rel=1e-9)


def test_published_alarm_is_false_every_22_5_samples() -> None:
    one, two = (CusumMean(PUBLISHED.drift, PUBLISHED.threshold, side).average_run_length().mean for side in
                ("upper", "both"))  # fmt: skip
    assert one == pytest.approx(44.9, abs=0.05)
    assert two == pytest.approx(22.5, abs=0.05)
    assert two * PUBLISHED.step == pytest.approx(1.12, abs=0.005)


def test_published_loop_alarms_on_a_sound_tyre_as_often_as_the_exact_run_length_says() -> None:
    rng, n = np.random.default_rng(1), 400_000
    truth = PUBLISHED.start + np.cumsum(PUBLISHED.process**0.5 * rng.standard_normal(n))
    out = follow_published(PUBLISHED, truth + 0.5 * rng.standard_normal(n), np.zeros(n))
    four_std = 4.0 * 22.45 / (n / 22.45) ** 0.5  # run lengths spread about as much as their mean
    assert n / out[:, 5].sum() == pytest.approx(22.45, abs=four_std)


def test_slope_of_the_innovations_of_a_ramp_is_no_leak_rate() -> None:
    ramp = 32.0 - 0.1 * PUBLISHED.step * np.arange(2000)
    out = follow_published(PUBLISHED, ramp, np.zeros(2000))
    assert abs(out[-1, 6]) < 1e-6  # the true rate is 0.1 psi/s


@pytest.mark.parametrize(
    ("interval", "noise", "step", "rate", "end", "within"),
    [
        (0.05, 3447.0, 0.0, 689.5, 60.0, 12.0),
        (1.0, 500.0, 1373.0, 5000.0, 60.0, 4.0),
        (1.0, 500.0, 1373.0, 20.0, 600.0, 300.0),
        (60.0, 500.0, 2500.0, 10e3 / 3600.0, 2 * 3600.0, 3600.0),
    ],
)
def test_leak_is_found_and_its_rate_told(interval, noise, step, rate, end, within) -> None:
    onset = max(30.0, 25.0 * interval)
    said = told(*leaking(interval, rate, onset, onset + end, noise, step))
    (found,) = np.flatnonzero(said["event"] == LEAK)
    assert 0.0 <= said["time"][found] - onset < within
    truth = rate * np.exp(-rate / NOMINAL * (said["time"][-1] - onset))
    assert said["rate"][-1] == pytest.approx(truth, abs=4.0 * said["rate_std"][-1])
    assert said["rate_std"][-1] < 0.5 * truth


def test_warming_by_20_kelvin_is_no_leak_and_cooling_neither() -> None:
    """A tyre that gains and loses 24 kPa by warmth alone, seen in steps of 1 K and 1373 Pa."""
    time = np.arange(0.0, 7200.0)
    warmth = 293.15 + 20.0 * (1.0 - np.exp(-time / 1000.0)) - 20.0 * (time > 3600.0) * (
        1.0 - np.exp(-np.maximum(time - 3600.0, 0.0) / 1000.0)
    )  # fmt: skip
    pressure = (NOMINAL + numbers.ATMOSPHERE) * warmth / 293.15 - numbers.ATMOSPHERE
    assert np.ptp(pressure) > 20e3
    pressure = 1373.0 * np.rint((pressure + 500.0 * np.random.default_rng(2).standard_normal(len(time))) / 1373.0)
    said = told(time, pressure, np.rint(warmth))
    assert not said["event"].any()
    assert not told(time, pressure, None)["event"].any()


def test_one_wild_sample_is_no_alarm_and_a_filled_tyre_starts_anew() -> None:
    time, pressure = leaking(1.0, 0.0, 0.0, 400.0, 500.0, 0.0)
    pressure[100] -= 100e3
    pressure[200:] += 30e3
    said = told(time, pressure)
    assert said["event"].tolist().count(REFILL) == 1
    assert said["event"][202] == REFILL
    assert LEAK not in said["event"]
    assert said["pressure"][-1] == pytest.approx(NOMINAL + 30e3, abs=1e3)


def test_burst_raises_the_alarm_within_two_samples() -> None:
    time, pressure = leaking(1.0, 0.0, 0.0, 100.0, 500.0, 1373.0)
    pressure[60:] = 130e3
    said = told(time, pressure)
    assert np.flatnonzero(said["event"] == LEAK).tolist() == [61]
    assert said["pressure"][70] == pytest.approx(130e3, abs=2e3)


@pytest.mark.parametrize("interval", [0.05, 1.0, 60.0])
def test_thresholds_are_those_of_one_false_alarm_in_100_h(interval: float) -> None:
    wanted = 100.0 * 3600.0 / interval * len(WHEELS) * len(numbers.SHIFTS)
    column, share = thresholds.place(interval)
    for shift, row in zip(numbers.SHIFTS, thresholds.table(), strict=True):
        h = row[column] + share * (row[column + 1] - row[column])
        exact = CusumMean(0.5 * shift, h, "lower").average_run_length().mean
        interpolated = 0.2  # thresholds are almost linear in the logarithm of the run length
        assert exact == pytest.approx(wanted, rel=interpolated)


def test_a_telegram_a_minute_is_followed_by_the_estimator_and_names_the_wheel() -> None:
    signals = {}
    for wheel in WHEELS:
        time, pressure = leaking(60.0, 20.0 if wheel == "rl" else 0.0, 3600.0, 10800.0, 500.0, 2500.0, len(signals))
        signals[f"tyre/{wheel}/pressure"] = Signal(time + 7.0 * len(signals), pressure, "Pa")
        signals[f"tyre/{wheel}/temperature"] = Signal(time + 7.0 * (len(signals) - 1), np.full(len(time), 293.0), "K")
    said = run(DriveLog(signals), ["direct_pressure"])
    alarms = said["alarm/direct_pressure"].value
    assert all(text.startswith("rl: ") for text in alarms)
    assert "leak" in alarms[0]
    assert "one in 100 h" in alarms[0]
    assert not any("time stamps" in text for text in said["est/direct_pressure/flags"].value)


def test_table_of_thresholds_is_what_the_design_gives():
    assert thresholds.designed() == pytest.approx(thresholds.table(), rel=1e-6)
