"""The study `sensor-faults`: one small repetition, and that its figures are what its rows say."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from testbed.campaign.parts import Parts
from testbed.study.registry import find_study
from testbed.study.sensor_faults.cases import BAR
from testbed.study.sensor_faults.drives import scenario
from testbed.study.sensor_faults.grade_limit import NOW, PAST, limit, ratio
from testbed.study.sensor_faults.paper import broken


@pytest.fixture(scope="module")
def row(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """As it comes back from disk."""
    study, parts = find_study("sensor-faults"), Parts(tmp_path_factory.mktemp("study"))
    parts.write("row", study.work(study.tasks(1, 0, True)[0]))
    return parts.read(["row"])[0]["row"]


def test_a_repetition_gives_every_row_that_is_asked_for_and_the_figures(row) -> None:
    study = find_study("sensor-faults")
    names = {r.name: r for r in study.table([copy.deepcopy(row)])}
    assert {"false_alarms", "hours", "designed_false_alarms_per_100h", "max_undetected_error_mps2", "detect_p95_s",
            "isolation_rate", *(f"missed_rate_{case.name}" for case in BAR)} <= set(names)  # fmt: skip
    assert names["designed_false_alarms_per_100h"].here == 10.0
    assert names["false_alarms"].here == len(row["alarms"])
    assert names["table_1, bias 0.3, method 1"].paper == 1e-2
    drawn = set(study.figures([row]))
    assert {f"figure-{n}" for n in range(6, 15)} <= drawn


def test_delays_and_shares_are_those_of_the_trials(row) -> None:
    study, made = find_study("sensor-faults"), []
    for k in range(20):
        of = {"case": BAR[0].name, "delay": 0.5 if k < 18 else None, "named": "", "right": k < 17, "error": 0.1 * k,
              "speed": 9.0, "driving": 1.0}  # fmt: skip
        made.append(of)
    names = {r.name: r.here for r in study.table([{**row, "trials": made}])}
    assert names[f"missed_rate_{BAR[0].name}"] == pytest.approx(10.0)
    assert names[f"isolated_within_1s_{BAR[0].name}"] == pytest.approx(85.0)
    assert names["isolation_rate"] == pytest.approx(100.0 * 17 / 18)
    assert names["max_undetected_error_mps2"] == pytest.approx(1.9)
    assert names["detect_p95_s"] is None or not np.isfinite(names["detect_p95_s"])  # two of twenty are never told


def test_drives_depend_on_seed_and_number_alone_and_have_grade_and_bank() -> None:
    first = [scenario(0, number, 10.0) for number in range(20)]
    assert first == [scenario(0, number, 10.0) for number in range(20)]
    assert len({drive.seed for drive in first}) == 20
    assert np.std([drive.grade for drive in first]) > 0.02
    assert all(drive.road != "D" or drive.speed <= 20.0 for drive in first)


def test_the_papers_faults_are_on_one_source_for_part_of_the_record() -> None:
    said = np.random.default_rng(0).standard_normal((100, 3))
    for fault, change in (("bias 0.3", said[:, 1] + 0.3), ("scale 0.5", 0.5 * said[:, 1]), ("zero", 0.0 * said[:, 1])):
        off, where = broken(said, fault, 1)
        assert np.array_equal(off[:, [0, 2]], said[:, [0, 2]])
        assert np.allclose(off[where, 1], change[where])
        assert np.array_equal(off[: where.start], said[: where.start])
    assert (broken(said, "stuck", 1)[0][40:70, 1] == said[39, 1]).all()


def test_the_limit_of_a_white_residual_is_that_of_a_mean_against_a_line() -> None:
    """Closed form: PAST and NOW white cells, level and slope unknown, is a regression of three columns."""
    step = (np.arange(PAST + NOW) >= PAST).astype(float)
    design = np.column_stack([np.ones(PAST + NOW), np.arange(PAST + NOW), step])
    std = 0.1 * np.sqrt(np.linalg.inv(design.T @ design)[2, 2])
    assert ratio(0.01 * np.eye(PAST + NOW), 0.3) == pytest.approx(0.3 / std, rel=1e-3)
    white = 0.1 * np.random.default_rng(0).standard_normal((20000, PAST + NOW))
    expected = norm.cdf(0.3 / std - norm.isf(0.5 / 36000.0))
    assert limit({"A": white}, 0.3, 10.0) == pytest.approx(expected, abs=0.05)
    assert limit({"A": white[:10]}, 0.3, 10.0) is None
