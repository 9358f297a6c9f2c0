"""The suite as a whole: names and units, seeds, independence of chunks and of other sensors, overrides, bad input."""

from __future__ import annotations

import math
from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest

from estimators.drive_log import WHEELS
from testbed.sensors import SensorSuite, sensor_settings
from testbed.sensors.settings import AnalogueSettings, BusSpeedSettings, EncoderSettings
from tests.test_sensors_motion import motion, pieces, rolling

CAR = SimpleNamespace(nominal_radius=0.35)
# everything that draws, delays or counts is on
BUSY = {
    "*/accel*": {"dropout": 0.05, "burst": 0.002, "burst_length": 7, "jitter": 2e-4, "delay": 0.0037},
    "*/torque": {"jitter": 1e-3, "rate": 77.0},
    "tyre/*": {"rate": 9.0, "dropout": 0.1},
    "wheel/*/edges": {"missing": 0.02, "double": 0.03, "double_gap": 0.0031, "delay": 0.0004},
    "wheel/*/speed": {"dropout": 0.05, "delay": 0.013},
}


def busy_drive(steps=3000):
    """A wild motion: every quantity differs from every other at every step; the rims turn, stop and turn back."""
    time = np.arange(steps) / 1000.0
    random = np.random.default_rng(8)
    speed = 30.0 * np.sin(2.0 * time)[:, None] + np.arange(4)
    return motion(
        steps,
        accel_cg=random.standard_normal((steps, 3)),
        gyro=random.standard_normal((steps, 3)),
        body_accel_z=random.standard_normal((steps, 4)),
        hub_accel_z=random.standard_normal((steps, 4)),
        rim_angle=-15.0 * np.cos(2.0 * time)[:, None] + np.arange(4) * time[:, None],
        rim_speed=speed,
        steering_wheel_angle=random.standard_normal(steps),
        engine_torque=100.0 * random.standard_normal(steps),
        driveline_torque=1000.0 * random.standard_normal(steps),
        tyre_pressure=2e5 + 1e4 * random.standard_normal((steps, 4)),
        tyre_temperature=300.0 + 9.0 * random.standard_normal((steps, 4)),
    )


def joined(suite, parts):
    outputs = [suite.advance(part) for part in parts]
    return {
        name: (np.concatenate([o[name].time for o in outputs]), np.concatenate([o[name].value for o in outputs]))
        for name in outputs[0]
    }


def test_every_signal_of_the_contract_is_there_with_its_unit():
    log = SensorSuite(sensor_settings(), 1, CAR).advance(rolling(1001, 60.0))
    units = {"imu/accel": "m/s^2", "imu/gyro": "rad/s", "steering/angle": "rad"}
    units |= {"engine/torque": "N m", "driveline/torque": "N m"}
    for w in WHEELS:
        units |= {f"body/{w}/accel_z": "m/s^2", f"hub/{w}/accel_z": "m/s^2", f"wheel/{w}/edges": ""}
        units |= {f"wheel/{w}/speed": "rad/s", f"tyre/{w}/pressure": "Pa", f"tyre/{w}/temperature": "K"}
    assert {name: signal.unit for name, signal in log.items()} == units
    assert log["imu/accel"].value.shape == log["imu/gyro"].value.shape == (1001, 3)
    assert log["hub/rr/accel_z"].value.shape == (1001,)
    assert all(len(signal) for signal in log.values())


def test_each_signal_reads_its_own_quantity_and_wheel():
    values = {"accel_cg": [1.0, 2.0, 3.0], "gyro": [0.1, 0.2, 0.3], "steering_wheel_angle": 1.5}
    values |= {"engine_torque": 111.0, "driveline_torque": 2222.0, "tyre_pressure": [2e5, 2.1e5, 2.2e5, 2.3e5]}
    values |= {"body_accel_z": [1.0, 2.0, 3.0, 4.0], "hub_accel_z": [5.0, 6.0, 7.0, 8.0]}
    values |= {"tyre_temperature": [300.0, 301.0, 302.0, 303.0]}
    exact = dict.fromkeys(("noise", "bias_std", "bias_walk", "scale_std", "quantisation"), 0.0)
    analogue = [k for k, v in sensor_settings().items() if isinstance(v, AnalogueSettings)]
    log = SensorSuite(sensor_settings(dict.fromkeys(analogue, exact)), 1, CAR).advance(motion(1001, **values))
    sources = {"imu/accel": "accel_cg", "imu/gyro": "gyro", "steering/angle": "steering_wheel_angle"}
    sources |= {"engine/torque": "engine_torque", "driveline/torque": "driveline_torque"}
    for name, field in sources.items():
        assert np.allclose(log[name].value, values[field], rtol=1e-14, atol=0.0)
    for pattern, field in {
        "body/{}/accel_z": "body_accel_z",
        "hub/{}/accel_z": "hub_accel_z",
        "tyre/{}/pressure": "tyre_pressure",
        "tyre/{}/temperature": "tyre_temperature",
    }.items():
        for w, wheel in enumerate(WHEELS):
            assert (log[pattern.format(wheel)].value == values[field][w]).all()


@pytest.mark.parametrize("overrides", [{}, BUSY], ids=["defaults", "busy"])
def test_the_log_is_the_same_to_the_last_bit_however_the_drive_is_cut(overrides):
    whole = busy_drive()
    at_once = joined(SensorSuite(sensor_settings(overrides), 5, CAR), [whole])
    random = np.random.default_rng(2)
    ragged = np.sort(random.choice(np.arange(1, 3000), 60, replace=False))
    for cuts in (ragged, [1, 2, 3, 4, 5, 2999], range(100, 3000, 100), range(1500, 1700)):
        cut = joined(SensorSuite(sensor_settings(overrides), 5, CAR), pieces(whole, cuts))
        for name, (time, value) in at_once.items():
            assert cut[name][0].tobytes() == time.tobytes(), name
            assert cut[name][1].tobytes() == value.tobytes(), name


def test_same_seed_gives_the_same_bytes_and_another_seed_changes_every_noisy_signal():
    whole = busy_drive()
    logs = [SensorSuite(sensor_settings(), seed, CAR).advance(whole) for seed in (5, 5, 6)]
    for name, signal in logs[0].items():
        assert logs[1][name] == signal
        assert logs[2][name] != signal, name


def test_a_sensor_says_the_same_whether_others_exist_or_not_and_whatever_they_do():
    whole = busy_drive(1500)
    everything = SensorSuite(sensor_settings(BUSY), 5, CAR).advance(whole)
    for name in everything:
        kept = {name, name.replace("/speed", "/edges")} if name.startswith("wheel") else {name}
        alone = {k: v for k, v in sensor_settings(BUSY).items() if k in kept}
        assert SensorSuite(alone, 5, CAR).advance(whole)[name] == everything[name], name


def test_streams_of_different_sensors_are_uncorrelated():
    n = 20_000
    settings = {k: v for k, v in sensor_settings({"*/accel_z": {"quantisation": 0.0}}).items() if "accel" in k}
    log = SensorSuite(settings, 1, CAR).advance(motion(n))
    series = np.vstack([log[k].value.T.reshape(-1, n) for k in log])
    across = np.corrcoef(series)[np.triu_indices(len(series), 1)]
    assert len(series) == 11
    assert np.abs(across).max() < 4.5 / math.sqrt(n)


def test_stamps_never_run_ahead_of_the_drive_nor_back():
    suite = SensorSuite(sensor_settings(BUSY), 5, CAR)
    heard: dict[str, float] = {}
    for part in pieces(busy_drive(), range(250, 3000, 250)):
        for name, signal in suite.advance(part).items():
            if len(signal):
                assert signal.time[-1] <= part.end
                assert signal.time[0] >= heard.get(name, 0.0)
                assert (np.diff(signal.time) >= 0.0).all()
                heard[name] = signal.time[-1]


def test_edges_carry_their_running_count_across_chunks():
    suite = SensorSuite(sensor_settings(), 1, CAR)
    counts = [suite.advance(rolling(500, 60.0, first=500 * i))["wheel/fl/edges"].value for i in range(4)]
    counted = np.concatenate(counts)
    assert np.array_equal(counted, np.arange(1.0, len(counted) + 1.0))
    assert abs(len(counted) - 60.0 * 1.999 / (2.0 * math.pi / 48)) <= 1.0


def test_transforms_change_a_signal_before_the_bus_in_their_order():
    def doubled(name, time, value):
        return (time, 2.0 * value) if name == "engine/torque" else (time, value)

    def lifted(name, time, value):
        return (time, value + 1.0) if name == "engine/torque" else (time, value)

    whole = busy_drive()
    plain = SensorSuite(sensor_settings(), 1, CAR).advance(whole)
    changed = SensorSuite(sensor_settings(), 1, CAR, transforms=[doubled, lifted]).advance(whole)
    assert np.array_equal(changed["engine/torque"].value, 2.0 * plain["engine/torque"].value + 1.0)
    assert all(changed[name] == plain[name] for name in plain if name != "engine/torque")


def test_a_suite_does_not_change_its_input_or_hold_on_to_it():
    whole = busy_drive(2000)
    first, second = pieces(whole, [1000])
    before = {f.name: getattr(first, f.name).copy() for f in fields(first)}
    suite = SensorSuite(sensor_settings(), 1, CAR)
    suite.advance(first)
    for name, array in before.items():
        assert np.array_equal(getattr(first, name), array)
        getattr(first, name)[:] = 1e6  # the loop fills its buffer again
    fresh = busy_drive(2000)
    expected = joined(SensorSuite(sensor_settings(), 1, CAR), pieces(fresh, [1000]))
    for name, signal in suite.advance(second).items():
        assert np.array_equal(signal.value, expected[name][1][len(expected[name][1]) - len(signal) :])


def test_a_chunk_that_leaves_a_gap_or_repeats_is_refused():
    for start in (99, 101, 0):
        suite = SensorSuite(sensor_settings(), 1, CAR)
        suite.advance(motion(100))
        with pytest.raises(ValueError, match=f"chunk starts at step {start}, the drive continues at step 100"):
            suite.advance(motion(10, first=start))


def test_overrides_reach_all_that_their_pattern_names_and_later_ones_win():
    settings = sensor_settings({"hub/*/accel_z": {"noise": 0.1}, "hub/rl/accel_z": {"noise": 0.2, "rate": 500}})
    noises = [settings[f"hub/{w}/accel_z"].noise for w in WHEELS]
    assert noises == [0.1, 0.1, 0.2, 0.1]
    assert settings["hub/rl/accel_z"].rate == 500
    assert settings["body/rl/accel_z"] == sensor_settings()["body/rl/accel_z"]


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"imu/gyros": {"noise": 0.1}}, "no sensor is named 'imu/gyros'; there are body/fl/accel_z"),
        ({"imu/gyro": {"nois": 0.1}}, "imu/gyro has no setting 'nois'; it has rate, average, jitter, noise"),
        ({"imu/gyro": {"noise": math.nan}}, "imu/gyro noise: nan is not valid, want from 0 to 1e+09"),
        ({"imu/gyro": {"noise": math.inf}}, "imu/gyro noise: inf is not valid"),
        ({"imu/gyro": {"noise": "much"}}, "imu/gyro noise: 'much' is not a number"),
        ({"imu/gyro": {"noise": True}}, "imu/gyro noise: True is not a number"),
        ({"imu/gyro": {"rate": -100.0}}, "imu/gyro rate: -100.0 is not valid, want from 0.001 to 1000"),
        ({"imu/gyro": {"rate": 2000.0}}, "imu/gyro rate: 2000.0 is not valid"),
        ({"imu/gyro": {"bias": math.inf}}, "imu/gyro bias: inf is not valid, want from -1e+09 to 1e+09"),
        ({"imu/gyro": {"low": 1.0, "high": -1.0}}, "imu/gyro: low 1.0 is not below high -1.0"),
        ({"imu/gyro": {"average": 1}}, "imu/gyro average: 1 is not True or False"),
        ({"imu/gyro": {"dropout": 1.5}}, "imu/gyro dropout: 1.5 is not valid, want from 0 to 1"),
        ({"imu/gyro": {"burst_length": 2.5}}, "imu/gyro burst_length: 2.5 is not a whole number"),
        ({"imu/gyro": 0.1}, "imu/gyro: 0.1 is not a mapping of settings"),
        ({"wheel/fl/edges": {"teeth": 1}}, "wheel/fl/edges teeth: 1 is not valid, want from 2 to 1000"),
        ({"wheel/fl/edges": {"timer": 0.0}}, "wheel/fl/edges timer: 0.0 is not valid"),
        ({"wheel/*": {"timer": 1e-6}}, "wheel/fl/speed has no setting 'timer'"),
        ({"wheel/fl/speed": {"timeout": -1.0}}, "wheel/fl/speed timeout: -1.0 is not valid"),
    ],
)
def test_bad_overrides_get_one_line_that_names_value_and_cure(overrides, message):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 (matched below as plain text)
        sensor_settings(overrides)
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("settings", "seed", "radius", "message"),
    [
        (sensor_settings(), -1, 0.35, "seed -1 is not a whole number"),
        (sensor_settings(), 1.5, 0.35, "seed 1.5 is not a whole number"),
        (sensor_settings(), 1, 0.0, "nominal radius 0.0 m is not positive"),
        (sensor_settings(), 1, math.nan, "nominal radius nan m is not positive"),
        ({"imu/gyros": AnalogueSettings(rate=1.0)}, 1, 0.35, "no sensor is named 'imu/gyros'"),
        ({"imu/gyro": EncoderSettings(48, 0.0, 1e-6, 0.0)}, 1, 0.35, "settings are EncoderSettings, want Analogue"),
        ({"imu/gyro": AnalogueSettings(rate=math.nan)}, 1, 0.35, "imu/gyro rate: nan is not valid"),
        ({"wheel/fl/speed": BusSpeedSettings(100.0, 0.01, 0.5)}, 1, 0.35, "is computed from wheel/fl/edges"),
    ],
)
def test_a_suite_that_cannot_be_is_refused(settings, seed, radius, message):
    with pytest.raises(ValueError, match=message):
        SensorSuite(settings, seed, SimpleNamespace(nominal_radius=radius))
