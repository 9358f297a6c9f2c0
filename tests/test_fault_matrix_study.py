"""The study `fault-matrix`: its rows and columns, who is right and who is not, and that a cell says what its trials
say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest

from estimators.accusation import Accusation, of_alarm, of_flag, rate_of, same, taken_back
from estimators.car import Car
from estimators.drive_log import Signal
from estimators.effective_steering import given, inputs
from estimators.estimator import Alarm, Flag
from estimators.faults import fault_kinds, parse_fault
from estimators.faults.targets import UNITS
from testbed.campaign.parts import write_table
from testbed.study.fault_matrix.events import RIGHT
from testbed.study.fault_matrix.faults import KINDS, SENSORS, cells
from testbed.study.fault_matrix.matrix import matrix
from testbed.study.fault_matrix.page import page
from testbed.study.registry import find_study


def test_every_kind_of_fault_and_every_sensor_of_the_car_is_in_it() -> None:
    assert set(KINDS) == set(fault_kinds())
    rows = {sensor.name.format(wheel="{}") for sensor in SENSORS}
    vectors = {name.rpartition("/")[0] for name in rows if name[-2:] in ("/x", "/y", "/z")}
    assert rows | vectors >= {name for name in UNITS if not name.endswith(("/edges", "/speed"))}


def test_every_cell_is_a_fault_that_can_be_typed() -> None:
    for cell in cells():
        assert parse_fault(cell.text("rl", "-", 12.5)).start == 12.5
    assert len({cell.name for cell in cells()}) == len(list(cells()))


def test_who_is_accused_is_what_the_words_say() -> None:
    told = Alarm(3.0, "imu/accel/x does not fit the other sensors (acceleration); designed for one false alarm in 10 h")
    assert of_alarm("redundancy", told) == [Accusation(3.0, "imu/accel/x", "redundancy")]
    assert rate_of(told) == "one in 10 h"
    slip = Alarm(3.0, "speed +14 km/h off the car's; false alarms: one in 100 h", ("fl", "rr"))
    assert [a.accused for a in of_alarm("wheel_plausibility", slip)] == ["wheel/fl", "wheel/rr"]
    assert rate_of(slip) == "one in 100 h"
    assert [a.accused for a in of_alarm("itpms", Alarm(3.0, "low", ("rl",)))] == ["low/rl"]
    assert [a.accused for a in of_flag("itpms", Flag(1.0, "wheel/fl/edges: no usable sample for 1 s"))] == ["wheel/fl"]
    assert of_flag("redundancy", Flag(1.0, "yaw rate: front agrees again")) == []
    assert taken_back("redundancy", Flag(1.0, "yaw rate: front agrees again")) == ["wheel/fl", "wheel/fr"]
    assert taken_back("redundancy", Flag(1.0, "yaw rate: gyro agrees again")) == ["imu/gyro/z"]
    assert taken_back("sensor_checks", Flag(1.0, "hub/fl/accel_z moves again")) == ["hub/fl/accel_z"]


def test_an_axis_and_its_vector_are_the_same_sensor_and_a_low_tyre_is_none() -> None:
    assert same("imu/accel", {"imu/accel/x"})
    assert same("imu/accel/x", {"imu/accel"})
    assert not same("imu/accel/y", {"imu/accel/x"})
    assert not same("low/fl", {"wheel/fl"})


def trial(delay: float | None, isolated: bool, wrong: tuple = (), low: tuple = ()) -> dict:
    told = delay if delay is not None else (1.0 if wrong or low else None)
    return {"cell": "hub/WHEEL/accel_z=bias", "delay": delay, "by": ["sensor_checks"] if delay is not None else [],
            "first": [], "isolated": isolated, "told": told, "wrong": list(wrong), "low": list(low)}  # fmt: skip


def test_a_cell_says_what_its_trials_say() -> None:
    found = [trial(0.2, True)] * 6 + [trial(0.8, True, low=(["low/fl", "axles"],))] * 2
    found += [trial(2.0, False, wrong=(["imu/gyro/x", "sensor_checks"],)), trial(None, False)]
    rows = [{"hours": 0.1, "false": [], "trials": found}]
    entry = matrix(rows)["hub/WHEEL/accel_z=bias"]
    assert (entry.trials, entry.missed, entry.isolated, entry.accused, entry.falsely) == (10, 1, 8, 9, 3)
    assert entry.delay(0.5).value == pytest.approx(0.2)
    assert entry.delay(0.95).value == float("inf")
    assert entry.others == "low by axles (2), imu/gyro/x by sensor_checks (1)"
    study = find_study("fault-matrix")
    table = {row.name: row for row in study.table(rows)}
    assert table["hub/WHEEL/accel_z=bias.missed_rate"].here == pytest.approx(10.0)
    assert table["hub/WHEEL/accel_z=bias.isolation_rate"].here == pytest.approx(100.0 * 8 / 9)
    assert not [row for row in study.printed(list(table.values())) if "=" in row.name]
    text = page(study.about, rows, list(table.values()))
    assert text.count("<figure>") == 4
    assert "low by axles (2)" in text


def test_an_event_s_accusations_are_kept_on_disk_and_counted(tmp_path) -> None:
    accused = [["wheel/rl", "redundancy", RIGHT], ["steering/angle", "redundancy", ""]]
    write_table(tmp_path / "part.parquet", [{"event": "tyre goes flat", "accused": accused}])
    rows = pq.read_table(tmp_path / "part.parquet").to_pylist()
    assert rows[0]["accused"] == accused
    table = {row.name: row.here for row in find_study("fault-matrix").table(rows)}
    assert table["event.tyre_goes_flat.told"] == table["event.tyre_goes_flat.falsely_accused"] == 100.0


def test_a_drive_s_false_alarms_are_kept_on_disk_and_counted(tmp_path) -> None:
    false = [{"time": 3.5, "accused": "steering/angle", "by": "redundancy"}]
    write_table(tmp_path / "part.parquet", [{"manoeuvre": "town", "hours": 0.5, "false": false, "trials": []}])
    rows = pq.read_table(tmp_path / "part.parquet").to_pylist()
    assert rows[0]["false"] == false
    table = {row.name: row.here for row in find_study("fault-matrix").table(rows)}
    assert table["false_alarms_per_100h"] == pytest.approx(200.0)


def test_a_monitor_that_knows_no_pinion_hears_it_as_the_steering_wheel_of_a_car_whose_motor_superposes() -> None:
    plain, active = Car(), replace(Car(), motor_gear_ratio=40.0, wheel_gear_ratio=1.0)
    reads, time = ("steering/angle", "imu/gyro"), np.array([0.0, 0.1])
    samples = {"steering/angle": Signal(time, np.array([0.4, 0.5])), "steering/pinion_angle": Signal(time, np.ones(2))}
    assert given(samples, reads, plain)["steering/angle"].value.tolist() == [0.4, 0.5]
    turned = given(samples, reads, active)["steering/angle"].value
    assert np.sin(turned / active.steering_ratio) * active.steering_ratio == pytest.approx(np.ones(2))
    assert inputs(reads, plain) == set(reads)
    assert inputs(reads, active) == {*reads, "steering/pinion_angle"}
