"""Sensors alone and beside their neighbours: who is accused, when, and who is not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from estimators.car import GRAVITY, Car
from estimators.drive_log import WHEELS
from estimators.redundancy.frozen import run_for
from estimators.sensor_checks import kernel
from estimators.sensor_checks.messages import CAME, LOST, MessageWatch
from estimators.sensor_checks.numbers import LIMITS
from estimators.sensor_checks.repetition import LEAST, RepetitionWatch
from estimators.sensor_checks.sensor_checks import CULPRITS

BETWEEN = 1e12
CELLS, START = 1500, 1000


def test_a_stuck_number_is_told_at_the_run_that_chance_allows_once_in_so_many() -> None:
    rng = np.random.default_rng(0)
    value = rng.standard_normal(2000)
    value[1000:1100] = value[1000]
    time = 1e-3 * np.arange(2000)
    told = RepetitionWatch(BETWEEN).add(time, value)
    assert [change.stuck for change in told] == [True, False]
    assert told[0].time == pytest.approx(1.0 + 1e-3 * run_for(LEAST, BETWEEN))
    assert told[1].time == pytest.approx(1.1)


def test_repetition_does_not_depend_on_how_the_samples_are_cut() -> None:
    rng = np.random.default_rng(1)
    time = 1e-3 * np.arange(3000)
    for scale in (0.4, 1.0, 3.0):
        value = np.round(scale * rng.standard_normal(3000))
        value[1000:1200], value[2000 : 2000 + int(rng.integers(5, 60))] = value[1000], 0.0
        cuts = np.sort(rng.integers(0, 3000, 40))
        watch, parts = RepetitionWatch(BETWEEN), []
        for piece in np.split(np.arange(3000), cuts):
            parts += watch.add(time[piece], value[piece])
        assert parts == RepetitionWatch(BETWEEN).add(time, value)


def test_a_sensor_that_usually_repeats_is_not_judged_by_it() -> None:
    value = np.repeat(np.arange(300.0), 20)
    assert RepetitionWatch(BETWEEN).add(1e-2 * np.arange(len(value)), value) == []


def _others() -> np.ndarray:
    return 0.005 * np.arange(4000)


def test_a_silence_is_told_after_as_many_messages_as_the_log_likelihood_needs() -> None:
    watch = MessageWatch(BETWEEN)
    watch.add(0.01 * np.arange(1000), _others)
    due = 9.99 + 0.01 * (math.ceil(math.log(BETWEEN) / LOST) + 1.0)
    assert watch.silent(due - 1e-6, _others) == []
    told = watch.silent(12.0, _others)
    assert [lost for _, lost in told] == [True]
    assert due <= told[0][0] <= due + 0.02  # from when another sensor is heard in the gap
    again = watch.add(12.0 + 0.01 * np.arange(2000), _others)
    assert [lost for _, lost in again] == [False]


def test_lost_messages_are_told_and_a_sound_share_is_not() -> None:
    rng, time = np.random.default_rng(2), 0.01 * np.arange(4000)
    sound, faulty = MessageWatch(BETWEEN), MessageWatch(BETWEEN)
    others = lambda: 0.0025 * np.arange(20000)  # noqa: E731
    assert sound.add(time[rng.random(4000) > 0.01], others) == []
    told = faulty.add(time[(rng.random(4000) > 0.3) | (time < 20.0)], others)
    assert told
    assert told[0][1]
    assert 20.0 < told[0][0] < 21.5
    assert -CAME < LOST


def test_nobody_is_accused_where_the_whole_log_is_silent() -> None:
    time = 0.01 * np.arange(2000)
    kept = time[(time < 8.0) | (time > 11.0)]
    others = lambda: kept  # noqa: E731
    assert MessageWatch(BETWEEN).add(kept, others) == []


def rigid(seed: int = 0) -> np.ndarray:
    """Cells (n, 18) of a rigid body that heaves, pitches and rolls, hubs beside it, on a straight road."""
    rng, car = np.random.default_rng(seed), Car()
    c = kernel.constants(car)
    time = kernel.STEP * np.arange(CELLS)
    rates = 0.05 * np.stack([np.sin(7.0 * time), np.sin(9.0 * time + 1.0)])
    change = np.gradient(rates, kernel.STEP, axis=1)
    heave = GRAVITY + np.sin(8.0 * time)
    cells = np.zeros((CELLS, 18))
    cells[:, kernel.AZ] = heave
    cells[:, kernel.GX], cells[:, kernel.GY] = rates
    for i in range(4):
        cells[:, 6 + i] = heave + change[0] * c.y[i] - change[1] * c.x[i]
        hop = 0.01 * np.sin(60.0 * time + i)
        cells[:, 10 + i] = cells[:, 6 + i] - 3600.0 * hop
    cells[:, kernel.SPEEDS] = 20.0 / car.rolling_radius
    scale = np.array([0.01] * 3 + [1e-3] * 3 + [0.1] * 8 + [0.02] * 4)
    return cells + scale * rng.standard_normal(cells.shape)


def judged(cells: np.ndarray) -> list[tuple[int, str]]:
    """(cell, culprit) of every accusation."""
    said = np.empty((len(cells), kernel.SAID))
    kernel.follow(kernel.constants(Car()), kernel.new_state(), LIMITS, np.arange(len(cells)), cells, said)
    events = said[:, kernel.EVENT]
    return [(int(k), CULPRITS[int(events[k, j])]) for k, j in np.argwhere(events >= 0.0)]


def test_a_sound_body_accuses_nobody() -> None:
    assert judged(rigid()) == []


@pytest.mark.parametrize(
    ("column", "size", "sensor"),
    [
        *((6 + i, 1.0, f"body/{wheel}/accel_z") for i, wheel in enumerate(WHEELS)),
        *((10 + i, 2.0, f"hub/{wheel}/accel_z") for i, wheel in enumerate(WHEELS)),
        (kernel.AZ, 1.0, "imu/accel/z"),
        (kernel.GX, 0.2, "imu/gyro/x"),
        (kernel.GY, 0.1, "imu/gyro/y"),
        (kernel.AY, 3.0, "imu/accel/y"),
    ],
)
def test_an_offset_is_that_sensors_own_and_told_within_two_seconds(column: int, size: float, sensor: str) -> None:
    cells = rigid()
    cells[START:, column] += size
    told = judged(cells)
    assert {name for _, name in told} == {sensor}
    assert START <= told[0][0] < START + round(2.0 / kernel.STEP)
