"""The bus speed follows the edges and nothing else."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from estimators.drive_log import WHEELS
from testbed.sensors import SensorSuite, sensor_settings
from testbed.sensors.bus_speed import LONGEST_PITCH, BusSpeed
from testbed.sensors.defaults import BUS_SPEED
from tests.test_sensors_motion import motion, pieces, rolling

CAR = SimpleNamespace(nominal_radius=0.35)
PITCH = 2.0 * math.pi / 48
STEP = 0.01 / 3.6 / CAR.nominal_radius  # rad/s
UNBIASED = 1e-5  # relative, mean over 10 s: a tenth of the radius change from 25 kPa on the default tyre
UNBIASED_SLOW = 3e-5  # 24 rings with up to 1e-4 each


def wheels(overrides=None, seed=1):
    settings = {k: v for k, v in sensor_settings(overrides).items() if k.startswith("wheel/")}
    return SensorSuite(settings, seed, CAR)


@pytest.mark.parametrize("kmh", [81.7, 133.9, 200.0])
def test_mean_speed_is_unbiased_at_constant_speed(kmh):
    speed = kmh / 3.6 / CAR.nominal_radius
    log = wheels().advance(rolling(11_001, speed))
    for wheel in WHEELS:
        signal = log[f"wheel/{wheel}/speed"].between(1.0, 11.0)
        assert len(signal) == 1000
        assert signal.value.mean() == pytest.approx(speed, rel=UNBIASED)


def test_mean_speed_of_slow_wheels_is_unbiased_over_many_rings():
    speed = 11.3 / 3.6 / CAR.nominal_radius  # fewer edges than updates: values are held, and 10 s are few turns
    logs = [wheels(seed=seed).advance(rolling(11_001, speed)) for seed in range(6)]
    means = [log[f"wheel/{w}/speed"].between(1.0, 11.0).value.mean() for log in logs for w in WHEELS]
    assert np.mean(means) == pytest.approx(speed, rel=UNBIASED_SLOW)


def test_an_even_ring_gives_the_speed_to_one_step_and_a_timer_tick():
    speed = 60.123
    log = wheels({"wheel/*/edges": {"pitch_error": 0.0}}).advance(rolling(3001, speed))
    signal = log["wheel/fl/speed"].between(0.1, 3.0)
    tick = speed * 1e-6 / 0.008  # one tick in the shortest span of four pitches
    assert np.abs(signal.value - speed).max() <= 0.5 * STEP + tick


def test_speed_is_in_whole_steps_of_a_hundredth_kmh_at_the_nominal_radius():
    signal = wheels().advance(rolling(2001, 60.0))["wheel/rl/speed"]
    assert signal.unit == "rad/s"
    kmh = signal.value * CAR.nominal_radius * 3.6
    assert kmh * 100.0 == pytest.approx(np.rint(kmh * 100.0), abs=1e-8, nan_ok=True)
    assert len(np.unique(signal.value)) > 10


def test_updates_come_every_10_ms_and_2_ms_late():
    signal = wheels().advance(rolling(1001, 60.0))["wheel/fl/speed"]
    # the first update, before any edge, knows no speed and sends none
    assert signal.time == pytest.approx(np.arange(1, 100) / 100.0 + 0.002, abs=1e-9)


def _braking():
    """25 rad/s, from 1 s on braked with 50 rad/s^2, standing from 1.5 s to 4 s, then driving off with 20 rad/s^2."""
    time = np.arange(6001) / 1000.0
    speed = np.where(time < 1.0, 25.0, np.maximum(25.0 - 50.0 * (time - 1.0), 0.0))
    speed += np.maximum(20.0 * (time - 4.0), 0.0)
    on_the_way = np.where(time < 1.0, 25.0 * time, 25.0 + 6.25 - 25.0 * np.maximum(1.5 - time, 0.0) ** 2)
    angle = on_the_way + 10.0 * np.maximum(time - 4.0, 0.0) ** 2
    return time, motion(6001, rim_angle=angle, rim_speed=speed), speed


def test_speed_falls_to_zero_at_standstill_and_comes_back():
    _, whole, truth = _braking()
    settings = {"wheel/*/speed": {"delay": 0.0}}
    log = wheels(settings).advance(whole)
    edges, signal = log["wheel/fr/edges"].time, log["wheel/fr/speed"]
    assert (signal.between(1.5 + BUS_SPEED.timeout + 0.011, 4.0).value == 0.0).all()
    silent = signal.between(1.51, 2.0)
    since = silent.time - edges[edges < 1.51].max()
    assert (silent.value <= LONGEST_PITCH * PITCH / since + 0.5 * STEP).all()
    assert (np.diff(signal.between(1.45, 4.0).value) <= 0.0).all()
    back = signal.between(4.5, 6.0)
    # the mean over a window that began at most one window and one pitch ago, and the ring's error
    lag = 20.0 * (0.01 + PITCH / 10.0)
    at = truth[np.rint(back.time * 1000.0).astype(int)]
    assert (np.abs(back.value - at) < lag + 0.02 * at).all()


def test_after_standstill_the_first_edge_alone_gives_no_speed():
    bus = BusSpeed(BUS_SPEED, 48, CAR.nominal_radius)
    edges = np.array([10.001, 10.051])
    time, value = bus.advance(0, 9_999, edges[:0])
    assert np.isnan(value[time <= BUS_SPEED.timeout]).all()  # unknown until it has been silent for long enough
    assert (value[time > BUS_SPEED.timeout] == 0.0).all()
    time, value = bus.advance(10_000, 10_100, edges)
    first = time < 10.051
    assert (value[first] == 0.0).all()
    assert value[~first][0] == pytest.approx(PITCH / 0.05, abs=STEP)


def test_without_edges_the_speed_holds_then_decays_as_the_longest_pitch_per_elapsed_time():
    bus = BusSpeed(BUS_SPEED, 48, CAR.nominal_radius)
    edges = np.arange(1, 11) * 0.01 - 0.001  # one edge 1 ms before every update, the last at 0.099 s
    time, value = bus.advance(0, 700, edges)
    held = PITCH / 0.01
    assert value[(time > 0.015) & (time < 0.105)] == pytest.approx(held, abs=STEP)
    quiet = time > 0.115
    stands = time - 0.099 > BUS_SPEED.timeout
    decays = quiet & ~stands
    assert value[decays] == pytest.approx(LONGEST_PITCH * PITCH / (time[decays] - 0.099), abs=STEP)
    assert (value[stands] == 0.0).all()
    assert stands.any()


def test_the_speed_is_a_function_of_the_logged_edges_alone():
    _, whole, _ = _braking()
    log = wheels({"wheel/*/edges": {"double": 0.01, "missing": 0.01}}).advance(whole)
    for wheel in ("fl", "rr"):
        time, value = BusSpeed(BUS_SPEED, 48, CAR.nominal_radius).advance(0, 6000, log[f"wheel/{wheel}/edges"].time)
        heard = time + BUS_SPEED.delay <= 6.0
        assert np.array_equal(log[f"wheel/{wheel}/speed"].value, value[heard], equal_nan=True)


def test_wrong_truth_with_the_same_edges_gives_the_same_speed():
    true = rolling(3001, 40.0)
    garbage = rolling(3001, -3.0)  # what the rims really did is not what this bus heard
    heard = wheels().advance(true)["wheel/fl/edges"]

    def same_edges(name, time, value):
        return (heard.time, np.ones(len(heard))) if name == "wheel/fl/edges" else (time, value)

    settings = sensor_settings()
    told = SensorSuite(settings, 1, CAR, transforms=[same_edges]).advance(garbage)
    assert np.array_equal(told["wheel/fl/speed"].value, wheels().advance(true)["wheel/fl/speed"].value, equal_nan=True)
    assert not np.array_equal(told["wheel/fr/speed"].value, wheels().advance(true)["wheel/fr/speed"].value)


def test_an_edge_on_the_very_update_counts_once_however_the_drive_is_cut():
    speed = 100.0 * PITCH  # an edge every update
    whole = rolling(2001, speed, angle=0.0)
    even = {"wheel/*/edges": {"pitch_error": 0.0, "timer": 0.01}}  # so coarse that every stamp is an update
    at_once = wheels(even).advance(whole)["wheel/fl/speed"]
    suite = wheels(even)
    parts = [suite.advance(part)["wheel/fl/speed"] for part in pieces(whole, range(1, 2001, 5))]
    assert np.array_equal(np.concatenate([p.value for p in parts]), at_once.value, equal_nan=True)
    assert at_once.value[5:] == pytest.approx(speed, abs=STEP)


def test_an_edge_on_the_very_update_belongs_to_that_update():
    bus = BusSpeed(BUS_SPEED, 48, CAR.nominal_radius)
    time, value = bus.advance(0, 20, np.array([0.01, 0.02]))
    assert time == pytest.approx([0.02])
    assert value == pytest.approx([PITCH / 0.01], abs=STEP)
