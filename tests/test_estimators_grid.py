"""Claims about time stamps and the common clock on which every signal is averaged."""

from __future__ import annotations

import numpy as np
import pytest

from estimators.arrival import Intake, arrival_times
from estimators.drive_log import Signal
from estimators.grid import LATENCY, Channel, Grid

CHANNELS = (Channel("a"), Channel("b", 2))


def test_a_cell_is_the_mean_of_its_samples() -> None:
    time = np.arange(0.005, 1.0, 0.01)
    value = np.where((time * 10).astype(int) % 2 == 0, 3.0, -1.0)
    grid = Grid((Channel("a"),), 0.1)
    grid.add({"a": Signal(np.append(-0.005, time), np.append(9.0, value))})
    cells, _ = grid.close(1.0 + LATENCY)
    inside = cells.index >= 0
    assert cells.centre[inside] == pytest.approx(0.05 + 0.1 * np.arange(10))
    assert cells.value[inside, 0] == pytest.approx([3.0, -1.0] * 5)


@pytest.mark.parametrize("offset", [0.0, 0.004, 0.009])
def test_a_ramp_is_read_at_the_cell_centre_however_its_samples_lie(offset: float) -> None:
    """Wheels sampled at other moments would otherwise differ by acceleration times offset."""
    time = np.arange(-0.2, 2.0, 0.015) + offset
    grid = Grid((Channel("a"),), 0.1)
    grid.add({"a": Signal(time, 5.0 + 3.0 * time)})
    cells, _ = grid.close(1.5)
    assert cells.value[:, 0] == pytest.approx(5.0 + 3.0 * cells.centre, abs=1e-9)


def test_a_column_is_picked_and_a_missing_channel_is_nan() -> None:
    grid = Grid(CHANNELS, 0.1)
    time = np.arange(0.0, 1.0, 0.01)
    grid.add({"b": Signal(time, np.column_stack([time, time, np.full(100, 7.0)]))})
    cells, _ = grid.close(2.0)
    assert np.isnan(cells.value[:, 0]).all()
    assert (cells.value[:, 1] == 7.0).all()


def test_a_cell_stays_open_until_the_latency_has_passed() -> None:
    grid = Grid((Channel("a"),), 0.1)
    time = np.arange(0.0, 0.5, 0.01)
    grid.add({"a": Signal(time, time)})
    assert grid.close(0.1 + LATENCY - 1e-3)[0].index.tolist() == []
    assert grid.close(0.1 + LATENCY)[0].index.tolist() == [0]
    assert grid.close(0.1 + LATENCY)[0].index.tolist() == []


def test_what_comes_after_its_cell_was_closed_is_refused_and_flagged() -> None:
    grid = Grid((Channel("a"),), 0.1)
    grid.add({"a": Signal([0.0, 0.01, 0.05], [1.0, 1.0, 1.0])})
    grid.close(1.0)
    grid.add({"a": Signal([0.07, 1.5], [9.0, 1.0])})
    cells, flags = grid.close(2.0)
    assert cells.index.tolist() == [15]
    assert "a: handed over too late" in [flag.text for flag in flags]


def test_the_same_complaint_is_raised_once_in_ten_seconds() -> None:
    grid = Grid((Channel("a"),), 0.1)
    time = np.arange(0.0, 25.0, 0.01)
    flags = grid.add({"a": Signal(time, np.full(2500, np.nan))})
    assert [flag.time for flag in flags] == pytest.approx([0.01, 10.01, 20.01], abs=0.011)


def test_late_repeated_and_wild_stamps_are_refused_and_the_rest_is_used() -> None:
    intake = Intake()
    good, complaints = intake.accept(np.array([0.0, 0.1, 0.2, 0.15, 0.2, 0.3, 1e6, 0.4, 1e10, 0.5]))
    assert good.tolist() == [False, True, True, False, False, True, False, True, False, True]
    assert [text for _, text in complaints] == [
        "late time stamps",
        "repeated time stamps",
        "time stamps far ahead of the clock",
        "time stamps beyond 9e+09 s",
    ]


def test_a_true_gap_is_believed_at_its_second_sample() -> None:
    good, complaints = Intake().accept(np.array([0.0, 0.1, 100.0, 100.1, 100.2]))
    assert good.tolist() == [False, True, False, True, True]
    assert complaints == []


@pytest.mark.parametrize("cuts", [(1,), (3, 4), (2, 5, 6, 7), tuple(range(1, 10))])
def test_the_decision_does_not_depend_on_the_cut(cuts: tuple[int, ...]) -> None:
    time = np.array([0.0, 0.1, 0.2, 0.15, 50.0, 50.1, 1e6, 50.2, 50.2, 50.3])
    whole, complaints = Intake().accept(time)
    intake = Intake()
    parts = [intake.accept(part) for part in np.split(time, cuts)]
    assert np.concatenate([good for good, _ in parts]).tolist() == whole.tolist()
    assert [c for _, some in parts for c in some] == complaints


def test_a_recorded_sample_arrives_with_its_stamp_and_a_late_one_with_the_clock() -> None:
    arrival = arrival_times(np.array([0.0, 0.1, 0.2, 0.15, 1e6, 0.3]))
    assert arrival.tolist() == [0.1, 0.1, 0.2, 0.2, 0.2, 0.3]
