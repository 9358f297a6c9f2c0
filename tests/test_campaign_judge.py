"""The judgement of rows whose answer is known beforehand, and figures that are null where the drives do not tell."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import numpy as np
import pytest

from estimators.drive_log import WHEELS
from testbed.campaign.judge import judge
from testbed.campaign.judge_columns import QUANTITIES
from testbed.campaign.plan import Campaign, campaign
from testbed.course import Course, truth_of
from tests.campaigns import made_up_rows

PLAN = campaign(
    tomllib.loads("""
seed = 3
runs = 20
low_percent = 20
estimators = ["wheel_radius"]
[scenario]
road = { sweep = ["A", "C"] }
speed_kmh = { sweep = [50, 110] }
duration_s = 60
pressure_kpa.fl = { uniform = [150, 250] }
""")
)
NOISE = 4.0  # kPa


@pytest.fixture(scope="module")
def rows() -> list[dict[str, Any]]:
    return made_up_rows(PLAN, noise=1e3 * NOISE)


@pytest.fixture(scope="module")
def scores(rows: list[dict[str, Any]]) -> dict[str, Any]:
    return judge(PLAN, rows)


def holds(figure: dict[str, Any], truth: float) -> bool:
    low, high = figure["ci95"]
    return bool(low <= truth <= high)


def test_error_of_known_noise_is_found_with_its_bias_and_consistency(scores: dict[str, Any]) -> None:
    (entry,) = scores["estimates"]
    assert (entry["method"], entry["quantity"], entry["unit"], entry["drives"]) == (
        "wheel_radius", "relative_pressure_change", "kPa", 80,
    )  # fmt: skip
    assert holds(entry["rmse"], NOISE)
    assert entry["rmse"]["here"] == pytest.approx(NOISE, rel=0.03)
    assert holds(entry["bias"], 0.0)
    assert holds(entry["nees"], 1.0)
    assert holds(entry["within_1_std"], 0.683)
    assert entry["settled"]["here"] == 1.0
    assert set(entry["wheels"]) == set(WHEELS)
    over_time = entry["wheels"]["fl"]["over_time"]
    assert np.mean(over_time["q95"]) == pytest.approx(1.645 * NOISE, rel=0.1)
    assert np.mean(over_time["q05"]) == pytest.approx(-1.645 * NOISE, rel=0.1)


def test_constant_error_is_all_bias(rows: list[dict[str, Any]]) -> None:
    name = "wheel_radius/fl/relative_pressure_change"
    shifted = [row | {f"{name}/value": [t + 20e3 for t in row[f"{name}/truth"]]} for row in rows]
    entry = judge(PLAN, shifted)["estimates"][0]["wheels"]["fl"]
    assert entry["bias"]["here"] == pytest.approx(20.0)
    assert entry["rmse"]["here"] == pytest.approx(20.0)
    assert entry["std"]["here"] == pytest.approx(0.0, abs=1e-9)
    assert entry["settled"]["here"] == 0.0
    assert entry["settling_s"]["here"] is None
    assert entry["nees"]["here"] == pytest.approx((20.0 / NOISE) ** 2)


def test_alarm_five_seconds_after_the_tyre_is_low_is_so_told(
    rows: list[dict[str, Any]], scores: dict[str, Any]
) -> None:
    (entry,) = scores["alarms"]
    fell = [row for row in rows if row["pressure_kpa/fl"][-1] <= 200.0]
    told = [row for row in rows if json.loads(row["alarms"])]
    assert entry["faulty_drives"] == len(fell) > len(told) > 0
    assert entry["detected"]["here"] == pytest.approx(len(told) / len(fell))
    assert entry["detection_s"]["here"] == pytest.approx(5.0)
    assert entry["isolated"]["here"] == 1.0
    assert entry["confusion"] == {"fl": {"fl": len(told)}}
    sound = sum(
        next((t - 1 for t, p in zip(r["time_s"], r["pressure_kpa/fl"], strict=True) if p <= 200), 59) for r in rows
    )
    assert entry["false_alarms"]["hours"] == pytest.approx((sound + len(rows)) / 3600.0)
    assert entry["false_alarms"]["count"] == 0
    assert holds(entry["false_alarms"]["per_hour"], 0.0)


def test_tyre_that_is_low_from_the_start_is_so_from_zero_on(rows: list[dict[str, Any]]) -> None:
    low = {"pressure_kpa/fl": [190.0] * 60, "alarms": json.dumps([[12.0, "wheel_radius", ["fl"]]])}
    entry = judge(PLAN, [row | low for row in rows])["alarms"][0]
    assert entry["detection_s"]["here"] == 12.0
    assert entry["faulty_drives"] == len(rows)
    assert entry["false_alarms"] is None
    assert entry["roc"] is None


def test_alarm_of_a_sound_car_is_false_and_of_another_wheel_is_not_isolated(rows: list[dict[str, Any]]) -> None:
    early = [row | {"alarms": json.dumps([[1.5, "wheel_radius", ["rr"]]])} for row in rows]
    entry = judge(PLAN, early)["alarms"][0]
    assert entry["false_alarms"]["count"] == len(rows)
    assert entry["detected"]["here"] == 0.0
    wrong = [row | {"alarms": row["alarms"].replace("fl", "rr")} for row in rows]
    entry = judge(PLAN, wrong)["alarms"][0]
    assert entry["isolated"]["here"] == 0.0
    assert set(entry["confusion"]["fl"]) == {"fl", "rr"}


def test_statistic_that_separates_has_area_one_and_a_designed_threshold(rows: list[dict[str, Any]]) -> None:
    """Drives below 200 kPa against drives that end above 230: 7 standard deviations between them."""
    clear = [row for row in rows if row["pressure_kpa.fl"] < 199.0 or row["pressure_kpa.fl"] > 230.0]
    entry = judge(PLAN, clear)["alarms"][0]
    assert entry["roc"]["area"]["here"] == 1.0
    assert entry["roc"]["detected"]["here"] == 1.0
    assert 0.0 < entry["roc"]["threshold"]["here"] < 50.0
    assert entry["tail"] is None or entry["tail"]["threshold"]["here"] > 10.0


def test_map_is_over_road_and_speed_and_counts_every_drive(scores: dict[str, Any]) -> None:
    maps = scores["maps"]
    assert (maps["x"], maps["x_labels"], maps["y"], maps["y_labels"]) == (
        "road", ("A", "C"), "speed_kmh", ("50", "110"),
    )  # fmt: skip
    (entry,) = maps["maps"]
    assert [[cell["drives"] for cell in column] for column in entry["cells"]] == [[20, 20], [20, 20]]
    assert all(holds(cell["rmse"], NOISE) for column in entry["cells"] for cell in column)


def test_worst_drive_is_the_one_that_errs_most(rows: list[dict[str, Any]]) -> None:
    name = "wheel_radius/rl/relative_pressure_change/value"
    bad = [dict(row) for row in rows]
    bad[17][name] = [value + 30e3 for value in bad[17][name]]
    assert judge(PLAN, bad)["worst"] == {"wheel_radius": 17}


def test_failed_drives_are_counted_and_nothing_else(rows: list[dict[str, Any]]) -> None:
    failed = {"number": 0, "error": "ValueError: no", "wall_s": 1.0}
    found = judge(PLAN, [failed, *rows[1:]])
    assert found["failed"] == [{"number": 0, "error": "ValueError: no"}]
    assert found["estimates"][0]["drives"] == len(rows) - 1


@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_drives_give_nulls_and_no_failure(rows: list[dict[str, Any]], count: int) -> None:
    found = judge(PLAN, [{"number": 9, "error": "no"}, *rows[:count]])
    text = json.dumps(found, allow_nan=False)
    assert ("null" in text) == (count > 0 or found["maps"] is None)


def test_estimate_that_is_never_given_has_no_entry(rows: list[dict[str, Any]]) -> None:
    silent = [
        {k: [float("nan")] * 60 if k.startswith("wheel_radius/") and k.endswith(("value", "std")) else v
         for k, v in row.items()}
        for row in rows
    ]  # fmt: skip
    found = judge(PLAN, silent)
    assert found["estimates"] == []
    assert found["worst"] == {}
    json.dumps(found, allow_nan=False)


def test_quantity_without_a_unit_is_refused_and_every_one_with_a_unit_has_a_truth(rows: list[dict[str, Any]]) -> None:
    with pytest.raises(ValueError, match="no unit to judge 'mood' in; known: pressure, "):
        judge(PLAN, [rows[0] | {"wheel_radius/fl/mood/value": [1.0] * 60}])
    course = Course(np.array([1.0]), *(np.ones((1, 4)) for _ in range(3)))
    for kind, quantity in QUANTITIES.items():
        name = f"fl/{kind}" if quantity.loss else kind
        assert truth_of(name, course, 250e3, np.ones(4)) is not None


def test_drives_of_different_length_share_one_axis(rows: list[dict[str, Any]]) -> None:
    plan: Campaign = PLAN
    short = made_up_rows(plan, seconds=30)
    found = judge(plan, [*rows[:10], *short[10:20]])
    over_time = found["estimates"][0]["wheels"]["fl"]["over_time"]
    assert over_time["time_s"][-1] == 60.0
    assert found["estimates"][0]["drives"] == 20
    assert found["hours"] == pytest.approx((10 * 60 + 10 * 30) / 3600.0)
