"""Who is accused in a recording: lanes from the first accusation to the last word, and red samples meanwhile."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from estimators.accusation import steering_of
from estimators.car import Car
from estimators.drive_log import Signal
from estimators.estimator import Alarm, Flag
from estimators.faults.targets import find_target
from estimators.readers import read_log
from estimators.runner import Bank
from estimators.steering_actuator.accusation import TEXTS
from testbed.recording import RecordingWriter
from testbed.verdicts import Verdicts
from tests.recording_contents import layout

CHECK = "does not fit the other sensors; false alarms: one in 10 h"


def told() -> tuple[Bank, Verdicts]:
    bank = Bank(["redundancy", "sensor_checks", "itpms"], Car())
    return bank, Verdicts(bank)


def test_a_lane_says_who_accuses_since_when_and_how_sure_until_all_believe_again() -> None:
    bank, verdicts = told()
    bank.alarms["redundancy"].append(Alarm(3.0, "imu/accel/x does not fit; designed for one false alarm in 10 h"))
    bank.alarms["itpms"].append(Alarm(3.2, "low", ("fl",)))
    lanes = verdicts.update()
    assert list(lanes) == ["est/verdict/imu/accel/x"]
    assert lanes["est/verdict/imu/accel/x"].value.tolist() == ["redundancy since 3.00 s (false: one in 10 h)"]
    bank.alarms["sensor_checks"].append(Alarm(4.0, f"imu/accel/x {CHECK}"))
    bank.flags["redundancy"].append(Flag(6.0, "acceleration: accelerometer agrees again"))
    lanes = verdicts.update()
    assert lanes["est/verdict/imu/accel/x"].value[-1] == "sensor_checks since 4.00 s (false: one in 10 h)"
    bank.flags["sensor_checks"].append(Flag(8.0, "imu/accel/x agrees again"))
    lanes = verdicts.update()
    assert (lanes["est/verdict/imu/accel/x"].time[-1], lanes["est/verdict/imu/accel/x"].value[-1]) == (8.0, "")
    assert verdicts.update() == {}


def test_samples_are_red_while_any_monitor_accuses_and_of_the_axis_alone() -> None:
    bank, verdicts = told()
    time = 0.5 + np.arange(10.0)
    sensed = {"imu/accel": Signal(time, np.arange(30.0).reshape(10, 3), "m/s^2", "imu")}
    assert verdicts.accused(sensed) == {}
    bank.alarms["sensor_checks"].append(Alarm(3.0, f"imu/accel/y {CHECK}"))
    bank.flags["sensor_checks"].append(Flag(6.0, "imu/accel/y agrees again"))
    verdicts.update()
    red = verdicts.accused(sensed)["imu/accel/y"]
    assert red.time.tolist() == [3.5, 4.5, 5.5]
    assert red.value[:, 0].tolist() == [10.0, 13.0, 16.0]


def test_the_recording_draws_it_beside_the_signal_and_keeps_it_out_of_the_log(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.rrd", {}) as writer:
        writer.add("hub/fl/accel_z", [0.0, 1.0], [9.8, 0.0], "m/s^2")
        writer.text("est/verdict/hub/fl/accel_z", [0.5], ["sensor_checks since 0.50 s"])
        writer.accused("hub/fl/accel_z", [1.0], [0.0], "m/s^2")
    assert {"/hub/fl/accel_z", "/hub/fl/accel_z/accused"} <= layout(tmp_path / "a.rrd")[0]
    assert set(read_log(tmp_path / "a.rrd")) == {"hub/fl/accel_z", "est/verdict/hub/fl/accel_z"}
    assert "est/verdict/hub/fl/accel_z" not in read_log(tmp_path / "a.rrd").visible()


def test_the_steering_s_monitor_accuses_the_angles_then_more_exactly_the_motor_s_and_takes_it_back() -> None:
    bank = Bank(["steering_actuator"], Car())
    verdicts = Verdicts(bank)
    rate = "false alarms: one in 100 h"
    bank.alarms["steering_actuator"].append(Alarm(3.0, f"{TEXTS['angles']}, by +2.0 deg, since 2.5 s; {rate}"))
    assert set(verdicts.update()) == {"est/verdict/steering/pinion_angle", "est/verdict/steering/angle"}
    bank.alarms["steering_actuator"].append(Alarm(3.5, f"{TEXTS['motor angle']}, it is unsteady, since 3.2 s; {rate}"))
    lanes = {name.removeprefix("est/verdict/steering/"): lane.value[-1] for name, lane in verdicts.update().items()}
    told = "steering_actuator since 3.50 s (false: one in 100 h)"
    assert lanes == {"motor_angle": told, "pinion_angle": "", "angle": ""}
    bank.flags["steering_actuator"].append(Flag(9.0, TEXTS[""]))
    lanes = verdicts.update()
    assert {name: lane.value.tolist() for name, lane in lanes.items()} == {"est/verdict/steering/motor_angle": [""]}


def test_every_accusation_of_the_steering_s_monitor_is_one_of_a_sensor() -> None:
    for who, text in TEXTS.items():
        assert who == "" or all(find_target(sensor).name == sensor for sensor in steering_of(text))
