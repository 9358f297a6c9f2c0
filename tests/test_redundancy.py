"""Claims about the estimator `redundancy`: its comparison of sources, its watch for stuck wheels, and what it says of a
drive with and without a fault."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

from estimators.detectors import CusumMean, Monitor
from estimators.drive_log import DriveLog, Signal
from estimators.faults import inject
from estimators.redundancy.comparison import LEARNING, Memory, new_memory, step
from estimators.redundancy.frozen import LONGEST, FrozenWatch, run_for
from estimators.redundancy.redundancy import WIDEST_ACCELERATION, WIDEST_YAW
from estimators.runner import Bank, run, run_bank
from tests.synthetic_drive import Noise, drive, varied_speed

CELLS = 3000
STD = np.array([0.01, 0.02, 0.03, 0.015])
DRIFT, NEVER = 1.0, np.full(4, 1e9)
ONSET = 30.0  # s of a fault
WITHIN = 1.0  # s
MEAN_ERROR = 5.0 / np.sqrt(CELLS)  # five standard errors


def compared(said: np.ndarray, limits: np.ndarray = NEVER, offset: float = 0.0) -> tuple[Memory, np.ndarray, list[int]]:
    """Four sources of one quantity with an unknown offset each of standard deviation `offset`: x and events."""
    memory, x, result = new_memory(np.zeros(4), np.full(4, offset)), np.empty((len(said), 4)), np.empty(3)
    h, none = np.eye(4), np.zeros(4)
    events = [step(memory, row, h, STD**2, none, none, DRIFT, limits, x[k], result) for k, row in enumerate(said)]
    return memory, x, events


def noisy(seed: int = 0) -> np.ndarray:
    """A quantity that wanders far, and four sources of it."""
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.standard_normal(CELLS))[:, None] + STD * rng.standard_normal((CELLS, 4))


def test_residuals_of_sound_sources_are_standard_whatever_the_quantity_does() -> None:
    _, x, _ = compared(noisy())
    assert np.abs(x.mean(axis=0)).max() < MEAN_ERROR
    assert np.abs(x.std(axis=0) - 1.0).max() < MEAN_ERROR


def test_constant_offsets_are_learnt_and_what_all_have_in_common_does_not_widen_residuals() -> None:
    offsets = np.array([0.3, -0.2, 0.1, 0.0])
    _, x, _ = compared(noisy(1) + offsets, offset=1.0)
    late = x[CELLS // 2 :]
    assert np.abs(late.mean(axis=0)).max() < 3.0 * MEAN_ERROR  # what is left of the offsets after 1500 cells
    assert np.abs(late.std(axis=0) - 1.0).max() < 2.0 * MEAN_ERROR


def test_statistic_is_the_detectors_cusum() -> None:
    memory, x, _ = compared(noisy(2))
    for i in range(4):
        readings = Monitor(CusumMean(DRIFT, 1e6, "both")).run(x[LEARNING:, i])
        assert memory.statistic[i].max() == pytest.approx(readings.statistic[-1], abs=1e-9)


@pytest.mark.parametrize("source", range(4))
def test_the_source_that_is_off_is_accused_and_comes_back(source: int) -> None:
    said = noisy(3)
    said[1000:1500, source] += 0.2
    memory, _, events = compared(said, np.full(4, 20.0))
    first = next(k for k, event in enumerate(events) if event >= 0)
    assert events[first] == source
    assert 1000 <= first < 1010
    assert {event for event in events if event >= 0} == {source}
    back = next(k for k, event in enumerate(events) if event == -2 - source)
    assert 1500 < back < 1700
    assert not memory.accused.any()


def test_of_two_sources_that_differ_neither_is_accused() -> None:
    said = noisy(4)
    said[:, 2:] = np.nan
    said[1000:, 0] += 5.0
    _, x, events = compared(said, np.full(4, 20.0))
    assert set(events) == {-1}
    assert np.isnan(x[:, 2:]).all()
    alone = noisy(4)
    alone[:, 1:] = np.nan
    assert np.isnan(compared(alone)[1]).all()


def test_run_length_that_gives_a_stuck_sensor_away() -> None:
    """Mean updates up to a run of n repeats of probability p is (1 - p^n) / (p^n (1 - p)); n is the least."""
    for p, updates in ((0.25, 1e6), (0.5, 1000.0), (0.1, 50.0)):
        n = run_for(p, updates)
        mean = [(1.0 - p**m) / (p**m * (1.0 - p)) for m in (n - 1, n)]
        assert mean[0] < updates <= mean[1]
    rng = np.random.default_rng(0)
    lengths = []
    for _ in range(400):
        run_of, count = 0, 0
        while run_of < 3:
            run_of, count = (run_of + 1 if rng.random() < 0.5 else 0), count + 1
        lengths.append(count)
    expected = (1.0 - 0.5**3) / (0.5**3 * 0.5)
    assert np.mean(lengths) == pytest.approx(expected, abs=4.0 * np.std(lengths) / 20.0)
    for bad in ((0.0, 10.0), (1.0, 10.0), (0.5, 0.5)):
        with pytest.raises(ValueError, match="valid"):
            run_for(*bad)


@pytest.mark.parametrize("stretch", [1, 7, 1000])
def test_a_repeated_wheel_speed_is_stuck_but_a_standing_or_slow_wheel_is_not(stretch: int) -> None:
    time = np.arange(1000) * 0.01
    moving = 50.0 + np.random.default_rng(1).standard_normal(1000)
    stuck = moving.copy()
    stuck[300:600] = stuck[299]
    pitch = 2.0 * np.pi / 48.0
    found = {}
    for name, value in (("moving", moving), ("stuck", stuck), ("standing", np.zeros(1000)), ("slow", np.repeat(
        1.0 + 0.01 * np.random.default_rng(2).standard_normal(100), 10))):  # fmt: skip
        watch = FrozenWatch(pitch)
        found[name] = [c for i in range(0, 1000, stretch) for c in watch.add(
            Signal(time[i : i + stretch], value[i : i + stretch]))]  # fmt: skip
    assert found["moving"] == found["standing"] == found["slow"] == []
    start, end = found["stuck"]
    assert start.stuck
    assert start.time == pytest.approx(2.99 + 0.01 * LONGEST)
    assert (end.stuck, end.time) == (False, pytest.approx(6.0))


@cache
def sound() -> DriveLog:
    """A minute of a wandering speed on a road that bends."""
    speed = varied_speed(60.0, 18.0, 3.0, 25.0)
    bend = 0.004 * np.sin(np.arange(len(speed)) / 900.0)
    return drive(speed, curvature=bend, noise=dataclasses.replace(Noise(), gyro_offset=0.002), seed=5)


def alarms(log: DriveLog) -> list[tuple[float, str]]:
    bank = Bank(["redundancy"], _car(log))
    run_bank(bank, log)
    return [(alarm.time, alarm.text) for alarm in bank.alarms["redundancy"]]


def _car(log: DriveLog):
    from estimators.car import Car

    return Car.from_notes(log.notes)


def test_a_sound_drive_raises_no_alarm_and_its_estimates_are_right() -> None:
    assert alarms(sound()) == []
    said = run(sound(), ["redundancy"])
    late = said["est/redundancy/yaw_rate"].between(20.0, 60.0)
    speed = np.interp(late.time, sound()["wheel/rl/speed"].time, 18.0 + 3.0 * np.sin(
        2.0 * np.pi * sound()["wheel/rl/speed"].time / 25.0))  # fmt: skip
    wanted = speed * 0.004 * np.sin(100.0 * late.time / 900.0)
    std = said["est/redundancy/yaw_rate/std"].between(20.0, 60.0).value
    assert np.sqrt(np.mean((late.value - wanted) ** 2)) < 2.0 * std.mean()
    assert std.max() < 0.02


@pytest.mark.parametrize(
    ("fault", "sensor"),
    [
        ("imu/accel/x=bias:0.5", "imu/accel/x"),
        ("imu/accel/x=bias:-0.5", "imu/accel/x"),
        ("imu/gyro/z=bias:1", "imu/gyro/z"),
        ("imu/gyro/z=bias:-1", "imu/gyro/z"),
        ("imu/gyro/z=noise:5", "imu/gyro/z"),
        ("wheel/fl=stuck", "wheel/fl"),
        ("wheel/rr=stuck", "wheel/rr"),
        ("wheel/rl=scale:1.1", "wheel/rl"),
        ("wheel/fr=zero", "wheel/fr"),
    ],
)
def test_a_faulty_sensor_is_named_within_a_second(fault: str, sensor: str) -> None:
    told = alarms(inject(sound(), [f"{fault}@{ONSET:g}"]))
    assert told
    time, text = told[0]
    assert ONSET < time < ONSET + WITHIN
    assert text.startswith(f"{sensor} ")
    assert "false alarms: one in 10 h" in text


def climbing(pitch_rate: bool) -> DriveLog:
    """A grade of 3 % that begins within half a second: 0.29 m/s^2 on the accelerometer."""
    signals = dict(sound().signals)
    for name, column, change in (("imu/accel", 0, 9.81 * 0.03), ("imu/gyro", 1, -0.03 / 0.5)):
        signal = signals[name]
        share = np.clip((signal.time - ONSET) / 0.5, 0.0, 1.0)
        value = signal.value.copy()
        value[:, column] += change * (share if name == "imu/accel" else (share > 0.0) * (share < 1.0) * pitch_rate)
        signals[name] = Signal(signal.time, value, signal.unit, signal.frame)
    torque = signals["driveline/torque"]
    weight = _car(sound()).mass * 9.81 * 0.03 * _car(sound()).rolling_radius
    pull = weight * np.clip((torque.time - ONSET) / 0.5, 0.0, 1.0)
    signals["driveline/torque"] = Signal(torque.time, torque.value + pull, torque.unit)
    return DriveLog(signals, sound().notes)


def test_a_grade_that_begins_is_no_fault_because_the_car_pitches() -> None:
    assert alarms(climbing(pitch_rate=True)) == []
    assert alarms(climbing(pitch_rate=False)) != []


def test_with_no_source_left_the_estimate_stays_and_its_std_says_that_nothing_is_known() -> None:
    signals = {}
    for name, signal in sound().items():
        kept = signal.time < ONSET if name not in ("driveline/torque",) else signal.time < 1e9
        signals[name] = Signal(signal.time[kept], signal.value[kept], signal.unit, signal.frame)
    said = run(DriveLog(signals, sound().notes), ["redundancy"])
    for name, widest in (("yaw_rate", WIDEST_YAW), ("acceleration", WIDEST_ACCELERATION)):
        value = said[f"est/redundancy/{name}"].between(ONSET + 2.0, 60.0)
        std = said[f"est/redundancy/{name}/std"].between(ONSET + 2.0, 60.0)
        assert (std.value == widest).all()
        assert np.unique(value.value).size == 1
    assert "yaw rate: no source is left" in " ".join(said["est/redundancy/flags"].value)
