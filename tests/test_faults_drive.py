"""Claims about faults in a drive: the drive with a fault is the sound drive's log with that fault, its truth is in the
recording, the command line of the estimators lays one over a log; and the events that only look like faults."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from estimators.__main__ import main as estimate
from estimators.drive_log import DriveLog
from estimators.faults import inject
from estimators.readers import read_log
from testbed.brake_pull import BrakePull
from testbed.campaign.fields import scenario_from
from testbed.drive import drive as record
from testbed.drive import main
from testbed.scenario import Scenario
from tests.drives import drive

FAULTS = (
    "wheel/rr=stuck@1.5",
    "wheel/fl=swap@0.5-1.2",
    "wheel/rl=noise:3@1",
    "imu/gyro/z=bias:1@1-2",
    "hub/fl/accel_z=delay:0.25@1-2",
    "imu/accel=dropout:0.2",
)
LOCKED, SPINNING = 0.9, 0.5  # slip ratio: beyond any that a rolling tyre keeps


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, DriveLog, DriveLog]:
    """A sound drive's file and log, and the log of the same drive with faults."""
    folder = tmp_path_factory.mktemp("faults")
    fields = {"road": "C", "duration": 2.5, "seed": 4}
    record(Scenario(**fields), folder / "sound.rrd", [])
    record(Scenario(**fields, faults=FAULTS), folder / "faulty.rrd", [])
    return folder / "sound.rrd", read_log(folder / "sound.rrd", None), read_log(folder / "faulty.rrd", None)


def test_a_drive_with_faults_is_the_sound_log_with_the_same_faults(logs) -> None:
    _, sound, faulty = logs
    laid = inject(sound, FAULTS, seed=4)
    changed = [n for n in sound.visible() if laid[n] != sound[n]]
    assert {"wheel/rr/edges", "wheel/fr/speed", "imu/gyro", "hub/fl/accel_z", "imu/accel"} <= set(changed)
    for name in faulty.visible():
        assert faulty[name] == laid[name], name


def test_faults_and_what_the_sound_sensors_say_are_in_the_recording(logs) -> None:
    _, sound, faulty = logs
    assert faulty.notes["scenario"]["faults"] == list(FAULTS)
    told = faulty["truth/fault/imu/gyro/z"]
    assert list(zip(told.time.tolist(), told.value, strict=True)) == [(1.0, "bias:1"), (2.0, "")]
    assert faulty["truth/sound/imu/gyro"] == sound["imu/gyro"].between(1.0, 2.0)
    assert "truth/sound/wheel/fr/speed" in faulty
    assert not any(name.startswith("truth/") for name in faulty.visible())


def test_command_line_lays_faults_over_a_log(logs, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, _, _ = logs
    out = tmp_path / "said.json"
    assert estimate([str(path), "wheel_radius", "--fault", "imu/gyro=dropout@1", "--json", str(out)]) == 0
    said = json.loads(out.read_text())
    assert said["faults"] == ["imu/gyro=dropout@1"]
    capsys.readouterr()
    for words, named in ((["--fault", "imu/gyro=x"], "'x'"), (["--fault", "radar=zero"], "'radar'"),
                         (["--fault", "imu/gyro=zero", "--fault-seed", "-1"], "--fault-seed -1")):  # fmt: skip
        assert estimate([str(path), "wheel_radius", *words]) == 2
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1
        assert named in lines[0]


def test_faults_and_brake_pulls_are_saved_with_the_scenario_and_taken_from_a_campaign_file() -> None:
    scenario = Scenario(faults=FAULTS, brake_pulls={"rl": BrakePull(3e3, 2.0, 3.0), "fl": BrakePull(500.0, 1.0)})
    assert Scenario.from_notes(json.loads(json.dumps(scenario.as_notes()))) == scenario
    fields = {"faults": list(FAULTS), "brake_nm": {"rl": {"torque": 3e3, "start_s": 2.0, "end_s": 3.0},
                                                   "fl": {"torque": 500, "start_s": 1}}}  # fmt: skip
    assert scenario_from(fields) == scenario
    with pytest.raises(ValueError, match="'broken'"):
        scenario_from({"faults": ["imu/accel=broken"]})


def test_a_pulling_brake_locks_its_wheel_and_no_other() -> None:
    driven = drive(road="flat", speed=20.0, duration=3.0, brake_pulls={"rl": BrakePull(3e3, 1.0, 1.8)})
    slip, time = np.abs(driven["slip_ratio"]), driven["time"]
    skidding = (time > 1.3) & (time < 1.8)
    assert (slip[skidding, 2] > LOCKED).all()
    assert slip[:, [0, 1, 3]].max() < 0.1
    assert slip[time > 2.6].max() < 0.1  # and rolls again when let go


def test_a_driven_wheel_spins_on_ice_when_the_car_pulls_away() -> None:
    driven = drive(road="flat", manoeuvre="stops", speed=15.0, duration=14.0, friction="0.9/0.1")
    slip = driven["slip_ratio"]
    assert np.nanmax(slip[:, 1]) > SPINNING
    assert np.nanmax(np.abs(slip[driven["time"] > 1.0][:, [0, 2]])) < SPINNING


def test_a_kerb_under_the_right_wheels_is_driven_over(tmp_path: Path) -> None:
    out = tmp_path / "kerb.json"
    words = ["--road", "flat", "--speed", "20", "--duration", "4", "--estimators", "none", "--quiet"]
    kerb = ["--obstacle", "cleat@8:height=70,length=9000,side=right"]
    assert main([*words, *kerb, "--out", str(tmp_path / "kerb.rrd"), "--json", str(out)]) == 0
    log = read_log(tmp_path / "kerb.rrd", None)
    jolt = [np.abs(log[f"hub/{wheel}/accel_z"].value - 9.81).max() for wheel in ("fl", "fr")]
    assert jolt[1] > 3.0 * jolt[0]
