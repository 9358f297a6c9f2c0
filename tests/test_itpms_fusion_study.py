"""Study `itpms-fusion`: what it draws is what was asked for, and its rows say what fabricated drives hold."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from estimators.car import Car
from estimators.drive_log import WHEELS, Signal
from estimators.itpms.thresholds import SPAN
from models.tyre_properties import load_tyre
from testbed.bench.itpms_cost import nominal
from testbed.campaign.variants import variant_of
from testbed.study.itpms_fusion.cars import DAY_WARMTH, LEVELS, NOMINAL, SPEEDS, TOLD, TOLD_ERROR, RepetitionCar
from testbed.study.itpms_fusion.drives import LOSSES, OFF_CALIBRATION, REGULATIONS, Drive, drives, name_of
from testbed.study.itpms_fusion.itpms_fusion import ItpmsFusionStudy
from testbed.study.itpms_fusion.repetition import METHODS, _series
from testbed.tyre.inflation import ATMOSPHERE

CARS = 40


def test_cars_and_days_are_drawn_within_what_was_asked() -> None:
    radii, levels, speeds, loads = [], [], [], []
    for number in range(CARS):
        car = RepetitionCar(3, number)
        day, other = car.day(1, 60.0), car.day(2, 60.0)
        factors = np.array([[s.radius_factor[w] for w in WHEELS] for s in (day, other)])
        radii.append(np.ptp(car.radii))
        assert np.abs(factors - car.radii).max() <= 1.25e-3
        assert np.ptp(factors - car.radii, axis=1).max() <= 2.5e-3  # of two tyres against each other
        levels.append(float(day.road.removeprefix("gd=")))
        speeds.append(day.speed)
        loads.append(day.payload)
        assert abs(day.ambient - car.filled_at) <= DAY_WARMTH
        gas = [(s.pressures["fl"] + ATMOSPHERE) / s.ambient for s in (day, other)]
        assert gas[0] == pytest.approx(gas[1])  # the amount of gas is the same on a colder day
        assert car.day(1, 60.0) == day
        assert car.pressure_at(car.filled_at) == pytest.approx(NOMINAL)
    assert max(radii) <= 6e-3
    assert LEVELS[0] <= min(levels) < 40e-6 < 400e-6 < max(levels) <= LEVELS[1]
    assert SPEEDS[0] <= min(speeds) < max(speeds) <= SPEEDS[1]
    assert 0.0 <= min(loads) < 60.0 < 340.0 < max(loads) <= 400.0


def test_the_estimator_is_told_wrong_numbers_and_a_wrong_pressure_law() -> None:
    car = RepetitionCar(3, 1)
    scenario = car.day(0, 60.0)
    variant = variant_of(scenario, {}, car.tyre, car.believed)
    right = variant_of(scenario, {}, {}, {})
    assert isinstance(variant.car, Car)
    assert isinstance(right.car, Car)
    for name in TOLD:
        ratio = getattr(variant.car, name) / getattr(right.car, name)
        assert 1.0 - TOLD_ERROR <= ratio <= 1.0 + TOLD_ERROR
        assert ratio != 1.0
    assert variant.car.radius_sensitivity == right.car.radius_sensitivity  # what it believes is the book's
    tyre, book = variant.tyre, load_tyre()
    assert tyre is not None
    assert (1.0 - tyre.torsion_base) / (1.0 - book.torsion_base) == pytest.approx(1.0, abs=0.2)
    assert tyre.re_pressure_share / book.re_pressure_share == pytest.approx(1.0, abs=0.2)


def test_every_repetition_has_each_loss_and_takes_turns_with_rules_and_cases() -> None:
    seen: set[str] = set()
    for number in range(12):
        given = drives(0, number, small=False)
        assert [Drive.from_json(json.loads(json.dumps(d.as_json()))) for d in given] == given
        named = {d.name for d in given}
        assert {name_of(*loss) for loss in LOSSES} <= named
        seen |= named
        for d in given:
            assert d.scenario.duration > d.onset + d.within
            assert d.name.endswith("calibration") or d.calibration in named
    assert {*REGULATIONS, *OFF_CALIBRATION} <= seen
    assert drives(0, 3, small=False) == drives(0, 3, small=False)


def _drive(alarm: float | None, wheels: list[str], early: bool = False) -> dict[str, Any]:
    """A loss at 180 s, an alarm so long after it."""
    found = [] if alarm is None else [[180.0 + alarm, wheels]]
    alarms: dict[str, list[Any]] = dict.fromkeys(METHODS, found) | {"radius": []}
    if early:
        alarms["fused"] = [[50.0, ["rr"]]]
    return {
        "wheels": ["fl"], "share": 0.15, "onset_s": 180.0, "reached_s": 180.0, "end_s": 360.0, "sound_s": 180.0,
        "ended": None, "alarms": alarms, "bound_s": 2.0, "speed_kmh": 80.0, "fastest_kmh": 90.0,
        "manoeuvre": "town", "road": "gd=1e-5",
        "largest": {m: list(np.random.default_rng(0).exponential(size=round(180.0 / SPAN))) for m in METHODS[:3]},
        "statistics": None,
    }  # fmt: skip


def _rows(given: list[dict[str, Any]], name: str = "15x1_sudden") -> dict[str, Any]:
    rows = [{"drives": json.dumps({name: drive}), "error": None} for drive in given]
    return {row.name: row for row in ItpmsFusionStudy().table(rows)}


def test_times_isolation_and_false_alarms_are_counted_as_defined() -> None:
    given = [_drive(float(k), ["fl"]) for k in range(1, 20)] + [_drive(30.0, ["fl", "fr"])]
    rows = _rows([*given, _drive(5.0, ["fl"], early=True)])
    assert rows["detect_15pct_1_tyres_p95_s"].here == 19.0
    assert rows["detect_15pct_1_tyres_p95_s"].limit == 2.0
    slow = _rows([*given, {**_drive(None, ["fl"]), "fastest_kmh": 42.0}, {**_drive(None, ["fl"]), "fastest_kmh": 42.0}])
    assert slow["detect_15pct_1_tyres_p95_s"].here == np.inf
    assert slow["detect_15pct_1_tyres_heard_p95_s"].here == 19.0
    assert rows["isolation_rate"].here == pytest.approx(19.0 / 20.0)
    assert rows["false_alarms"].here == 1.0
    assert rows["hours"].here == pytest.approx(21 * 180.0 / 3600.0)
    assert rows["designed_false_alarms_per_100h"].limit == 1.0
    assert rows["voting.false_alarms"].here == 0.0
    assert rows["radius.detect_15pct_1_tyres_p95_s"].here == np.inf  # censored, not left out
    assert rows["radius.detect_15pct_1_tyres_p95_s"].as_json()["here"] is None
    assert rows["radius.detect_15pct_1_tyres_p95_s"].limit is None


def test_a_rule_is_passed_in_its_time_only() -> None:
    late = {**_drive(700.0, ["fl"]), "onset_s": 0.0, "reached_s": 0.0, "sound_s": 0.0, "end_s": 900.0}
    soon = {**late, "alarms": {m: [[20.0, ["fl"]]] for m in METHODS}}
    rows = _rows([late, soon], "r141_puncture")
    assert rows["r141_puncture_pass"].here == 0.5
    assert rows["radius.r141_puncture_pass"].here == 0.5
    assert _rows([late], "fmvss_138")["fmvss_138_pass"].here == 1.0  # 20 min


def test_figures_are_drawn_of_whatever_was_driven() -> None:
    time = np.arange(3.0, 30.0, 2.0)
    said = {f"est/itpms/{name}_confidence": [Signal(time, 0.1 * time)] for name in ("vibration", "radius")}
    said["est/itpms/fused_statistic"] = [Signal(time[5:], time[5:])]  # nothing was read in the first blocks
    drive = _drive(4.0, ["fl"]) | {"statistics": _series(said)}
    rows = [{"drives": json.dumps({"15x1_sudden": drive})}]
    assert set(ItpmsFusionStudy().figures(rows)) == {
        "detection-times", "false-alarm-tail", "figure-8-voting", "figure-9-warnings",
    }  # fmt: skip


def test_a_car_never_driven_is_known_as_its_prior() -> None:
    known = nominal()
    assert np.isfinite(known.level).all()
    assert np.sqrt(np.diag(known.unlearnt(0))).min() > 0.05
