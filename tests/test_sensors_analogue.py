"""The error chain of analogue sensors does what its settings say, each claim alone."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from testbed.sensors import SensorSuite
from testbed.sensors.settings import AnalogueSettings
from tests.test_sensors_motion import motion, pieces

CAR = SimpleNamespace(nominal_radius=0.35)
SIGMAS = 4.5  # bound of a random figure in its own standard deviations: passes 99.9993 % of seeds, the seeds are fixed


def sensed(name, settings, whole, seed=1):
    return SensorSuite({name: settings}, seed, CAR).advance(whole)[name]


def test_white_noise_has_the_set_standard_deviation_on_every_axis_and_no_memory():
    n = 40_000
    value = sensed("imu/gyro", AnalogueSettings(rate=1000.0, noise=0.02), motion(n)).value
    assert np.abs(value.std(axis=0) / 0.02 - 1.0).max() < SIGMAS / np.sqrt(2 * n)
    assert np.abs(value.mean(axis=0)).max() < SIGMAS * 0.02 / np.sqrt(n)
    for lag in (1, 2, 10):
        memory = (value[lag:] * value[:-lag]).mean(axis=0) / 0.02**2
        assert np.abs(memory).max() < SIGMAS / np.sqrt(n)
    across = np.corrcoef(value.T)[np.triu_indices(3, 1)]
    assert np.abs(across).max() < SIGMAS / np.sqrt(n)


@pytest.mark.parametrize("rate", [1000.0, 100.0])
def test_bias_walk_grows_with_the_root_of_time_at_any_rate(rate):
    walk, seconds = 0.003, 200
    value = sensed("imu/gyro", AnalogueSettings(rate=rate, bias_walk=walk), motion(1000 * seconds)).value
    for gap in (0.01, 0.1, 1.0):
        stride = round(gap * rate)
        growth = value[stride::stride] - value[:-stride:stride]  # independent increments
        assert growth.std() == pytest.approx(walk * np.sqrt(gap), rel=SIGMAS / np.sqrt(2 * growth.size))


def test_fixed_bias_and_scale_error_are_exact():
    settings = AnalogueSettings(rate=1000.0, bias=0.25, scale=-0.5)
    ramp = np.linspace(-3.0, 3.0, 101)
    assert np.array_equal(sensed("engine/torque", settings, motion(101, engine_torque=ramp)).value, 0.5 * ramp + 0.25)


def test_turn_on_bias_and_scale_are_drawn_once_with_their_set_spread():
    settings = AnalogueSettings(rate=1000.0, bias_std=0.3, scale_std=0.02)
    n, biases, scales = 300, [], []
    for seed in range(n):
        value = sensed("engine/torque", settings, motion(4, engine_torque=[0.0, 0.0, 1.0, 1.0]), seed).value
        assert value[0] == value[1]
        assert value[2] == value[3]
        biases.append(value[0])
        scales.append(value[2] - value[0] - 1.0)
    assert np.std(biases) == pytest.approx(0.3, rel=SIGMAS / np.sqrt(2 * n))
    assert np.std(scales) == pytest.approx(0.02, rel=SIGMAS / np.sqrt(2 * n))
    assert abs(np.corrcoef(biases, scales)[0, 1]) < SIGMAS / np.sqrt(n)


def test_values_lie_on_the_quantisation_grid_nearest_to_the_truth_and_saturate():
    ramp = np.linspace(-12.0, 12.0, 2001)
    settings = AnalogueSettings(rate=1000.0, quantisation=0.25, low=-10.0, high=10.0)
    value = sensed("engine/torque", settings, motion(2001, engine_torque=ramp)).value
    assert np.array_equal(value * 4.0, np.rint(value * 4.0))
    assert np.abs(value - np.clip(ramp, -10.0, 10.0)).max() <= 0.125
    assert (value.min(), value.max()) == (-10.0, 10.0)


def test_delay_moves_the_stamps_exactly_and_keeps_what_is_under_way():
    whole = motion(2000, gyro=np.arange(2000) / 7.0)
    prompt = sensed("imu/gyro", AnalogueSettings(rate=1000.0, noise=0.1), whole)
    late = sensed("imu/gyro", AnalogueSettings(rate=1000.0, noise=0.1, delay=0.0125), whole)
    assert len(late) == 2000 - 13  # the samples of the last 12.5 ms are not yet on the bus
    assert np.array_equal(late.value, prompt.value[: len(late)])
    assert np.array_equal(late.time, np.rint((prompt.time[: len(late)] + 0.0125) * 1e9) / 1e9)


def test_dropouts_lose_the_set_share_and_leave_the_other_samples_as_they_were():
    n, share = 50_000, 0.03
    whole = motion(n)
    full = sensed("hub/fl/accel_z", AnalogueSettings(rate=1000.0, noise=1.0), whole)
    holed = sensed("hub/fl/accel_z", AnalogueSettings(rate=1000.0, noise=1.0, dropout=share), whole)
    lost = n - len(holed)
    assert abs(lost - share * n) < SIGMAS * np.sqrt(n * share * (1.0 - share))
    kept = np.isin(full.time, holed.time)
    assert np.array_equal(full.value[kept], holed.value)


def test_bursts_lose_whole_runs_at_the_set_rate():
    n, begin, length = 200_000, 0.001, 20
    settings = AnalogueSettings(rate=1000.0, burst=begin, burst_length=length)
    kept = sensed("engine/torque", settings, motion(n)).time
    gaps = np.rint(np.diff(kept) * 1000.0).astype(int) - 1
    gaps = gaps[gaps > 0]
    assert gaps.min() == length
    # a gap ends at the first sample after which no burst has begun for `length` samples; its starts are rare and alone
    share = 1.0 - (1.0 - begin) ** length
    spread = np.sqrt(share * (1.0 - share) * length / n)  # runs of `length` alike samples: n / length are independent
    assert 1.0 - len(kept) / n == pytest.approx(share, abs=SIGMAS * spread)


def test_slow_sensors_average_their_interval_or_sample_its_end():
    random = np.random.default_rng(5).standard_normal(1001)
    whole = motion(1001, engine_torque=random)
    mean = sensed("engine/torque", AnalogueSettings(rate=100.0, average=True), whole)
    assert np.allclose(mean.time, np.arange(101) / 100.0, atol=1e-9)
    assert mean.value[1:] == pytest.approx(random[1:].reshape(100, 10).mean(axis=1), abs=1e-14)
    point = sensed("engine/torque", AnalogueSettings(rate=100.0), whole)
    assert np.array_equal(point.value, random[::10])


def test_averaging_removes_what_sampling_folds_down():
    time = np.arange(2000) / 1000.0
    whole = motion(2000, engine_torque=np.sin(2.0 * np.pi * 100.0 * time + 1.0))
    folded = sensed("engine/torque", AnalogueSettings(rate=100.0), whole).value
    removed = sensed("engine/torque", AnalogueSettings(rate=100.0, average=True), whole).value[1:]
    assert folded == pytest.approx(np.sin(1.0), abs=1e-9)
    assert removed == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("rate", [66.0, 0.3, 999.0, 400.0])
def test_a_rate_that_does_not_divide_the_steps_samples_between_them(rate):
    whole = motion(7001, engine_torque=3.0 * np.arange(7001) / 1000.0)
    signal = sensed("engine/torque", AnalogueSettings(rate=rate), whole)
    assert np.diff(signal.time) == pytest.approx(1.0 / rate, abs=2e-9)
    assert len(signal) == int(7.0 * rate) + 1
    assert signal.value == pytest.approx(3.0 * signal.time, abs=3.0 * 1e-9)  # stamps are on a grid of 1 ns


def test_clock_jitter_moves_the_instants_with_their_stamps_by_the_set_amount():
    n, jitter = 20_000, 0.4e-3
    whole = motion(10 * n, engine_torque=3.0 * np.arange(10 * n) / 1000.0)
    signal = sensed("engine/torque", AnalogueSettings(rate=100.0, jitter=jitter), whole)
    shift = signal.time - np.arange(len(signal)) / 100.0
    assert signal.value == pytest.approx(3.0 * signal.time, abs=3.0 * 1e-9)
    assert shift.std() == pytest.approx(jitter, rel=SIGMAS / np.sqrt(2 * n))
    assert (np.diff(signal.time) > 0.0).all()


def test_an_average_over_a_jittered_interval_holds_only_its_own_steps():
    whole = motion(1000, engine_torque=np.arange(1000.0))
    settings = AnalogueSettings(rate=100.0, average=True, jitter=2e-3)
    signal = SensorSuite({"engine/torque": settings}, 3, CAR).advance(whole)["engine/torque"]
    ends = np.floor(signal.time * 1000.0 + 1e-6)
    begins = np.concatenate([[-1.0], ends[:-1]])
    assert signal.value == pytest.approx((begins + 1.0 + ends) / 2.0, abs=1e-9)
    assert np.ptp(np.diff(ends)) > 2.0


def test_samples_of_cut_motion_equal_those_of_the_whole_for_odd_rates():
    whole = motion(3000, engine_torque=np.random.default_rng(1).standard_normal(3000))
    for settings in (AnalogueSettings(rate=333.0), AnalogueSettings(rate=77.0, average=True, jitter=3e-3)):
        suite = SensorSuite({"engine/torque": settings}, 2, CAR)
        parts = [suite.advance(part)["engine/torque"] for part in pieces(whole, range(1, 3000, 3))]
        at_once = sensed("engine/torque", settings, whole, seed=2)
        assert np.array_equal(np.concatenate([p.time for p in parts]), at_once.time)
        assert np.array_equal(np.concatenate([p.value for p in parts]), at_once.value)
