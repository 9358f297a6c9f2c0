"""`python -m testbed.drive` as a user has it: roads, options that reach the physics, JSON, log, table, replay, kill."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import rerun_cli

from estimators.drive_log import WHEELS, DriveLog
from estimators.readers import read_log
from models.vehicle import GRAVITY
from testbed.drive import main

RERUN = str(Path(rerun_cli.__file__).with_name("rerun"))
SHARED = Path(__file__).resolve().parents[1].parent / "shared" / "data"
MEASURED = ("belgian_block.crg", "iri_utia_profile_1.txt", "krc_rms_course_2in.crg")
WHEEL_KEYS = ("pressure_kpa", "stiffness_n_per_m", "rolling_radius_m", "load_n", "mean_speed_rad_s")


def driven(folder: Path, *arguments: str) -> dict[str, Any]:
    """The JSON result of a drive that must succeed; its recording is folder/drive.rrd."""
    result, out = folder / "drive.json", folder / "drive.rrd"
    assert main(["--quiet", "--out", str(out), "--json", str(result), *arguments]) == 0
    return dict(json.loads(result.read_text()))


def means(result: dict[str, Any], key: str) -> list[float]:
    return [result["wheels"][wheel][key] for wheel in WHEELS]


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Three seconds of class C at 80 km/h, nothing else asked for."""
    return driven(tmp_path_factory.mktemp("plain"), "--duration", "3", "--seed", "4")


@pytest.fixture(scope="module")
def smooth(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Three seconds of level road, against which options are compared."""
    return driven(tmp_path_factory.mktemp("smooth"), "--road", "flat", "--duration", "3")


def test_json_holds_every_figure_and_the_scenario(plain: dict[str, Any]) -> None:
    assert plain["sim_s"] == 3.0
    assert plain["seed"] == 4
    assert plain["recording"] == plain["log"]
    assert 0.0 < plain["wall_s"] < 600.0
    assert plain["realtime_factor"] > 0.0
    assert isinstance(plain["alarms"], list)
    assert plain["scenario"]["road"] == "C"
    assert plain["estimates"]
    for entry in plain["estimates"].values():
        assert set(entry) == {"value", "std", "unit"}
    for wheel in WHEELS:
        assert all(math.isfinite(plain["wheels"][wheel][key]) for key in WHEEL_KEYS)


def test_log_holds_sensors_truth_and_notes_of_the_whole_drive(plain: dict[str, Any]) -> None:
    log = read_log(Path(plain["log"]))
    wanted = ["imu/accel", "imu/gyro", "steering/angle", "engine/torque", "truth/fl/pressure", "truth/chassis/position"]
    for wheel in WHEELS:
        wanted += [f"{place}/{wheel}/accel_z" for place in ("body", "hub")]
        wanted += [
            f"wheel/{wheel}/edges",
            f"wheel/{wheel}/speed",
            f"tyre/{wheel}/pressure",
            f"tyre/{wheel}/temperature",
        ]
    assert not set(wanted) - set(log)
    assert log["imu/accel"].time[-1] == pytest.approx(3.0, abs=0.02)
    assert log.notes["scenario"] == plain["scenario"]


def test_edges_in_the_log_count_the_wheels_turns(plain: dict[str, Any]) -> None:
    """48 edges a turn: their number and the mean wheel speed of the JSON agree within two edges."""
    log = read_log(Path(plain["log"]))
    for wheel in WHEELS:
        turns = plain["wheels"][wheel]["mean_speed_rad_s"] * 3.0 / (2.0 * math.pi)
        assert len(log[f"wheel/{wheel}/edges"]) == pytest.approx(48 * turns, abs=2.0)


@pytest.mark.parametrize("road", ["A", "D", "H", "A:20,D:300", "gd=5e-5", "flat", *MEASURED])
def test_each_form_of_road_is_driven_at_the_wanted_speed(road: str, tmp_path: Path) -> None:
    if road in MEASURED:
        if not (SHARED / road).is_file():
            pytest.skip(f"needs {SHARED / road}")
        road = str(SHARED / road)
    speed = "15" if road == "H" else "80"  # km/h
    result = driven(tmp_path, "--road", road, "--duration", "2", "--speed", speed)
    within = 0.25 if road == "H" else 0.03  # the driver's control error; boulders of half a metre slow the car down
    assert result["distance_m"] == pytest.approx(2.0 * float(speed) / 3.6, rel=within)
    assert result["road"] == road
    heights = read_log(tmp_path / "drive.rrd")["truth/fl/road_height"].value
    level = road == "flat" or road.endswith(MEASURED[2])  # that one begins with 100 m without unevenness
    assert (float(heights.std()) > 0.0) == (not level)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drive.json", "drive.rrd"]


def test_lower_pressure_means_a_softer_tyre_that_rolls_shorter_and_so_faster(
    tmp_path: Path, smooth: dict[str, Any]
) -> None:
    result = driven(tmp_path, "--road", "flat", "--duration", "3", "--pressure", "fl=180")
    assert result["wheels"]["fl"]["pressure_kpa"] == pytest.approx(180.0, abs=1.0)  # it warms by a fraction of a kelvin
    assert result["wheels"]["fr"]["pressure_kpa"] == pytest.approx(250.0, abs=1.0)
    soft, stiff = (r["wheels"]["fl"] for r in (result, smooth))
    assert 0.6 < soft["stiffness_n_per_m"] / stiff["stiffness_n_per_m"] < 0.9
    assert soft["rolling_radius_m"] < 0.9985 * stiff["rolling_radius_m"]
    assert soft["mean_speed_rad_s"] > 1.0015 * stiff["mean_speed_rad_s"]


def test_leak_lowers_its_tyre_alone_by_its_rate(tmp_path: Path) -> None:
    result = driven(tmp_path, "--road", "flat", "--duration", "3", "--leak", "rr=5@1")
    lost = [250.0 - v for v in means(result, "final_pressure_kpa")]
    assert lost[3] == pytest.approx(2.0 * 5.0, abs=1.0)  # warming works against it, by less than 1 kPa
    assert max(map(abs, lost[:3])) < 1.0


def test_set_brings_a_tyre_to_its_pressure(tmp_path: Path) -> None:
    result = driven(tmp_path, "--road", "flat", "--duration", "3", "--set", "rl=130@1/0.5")
    assert result["wheels"]["rl"]["final_pressure_kpa"] == pytest.approx(130.0, abs=1.0)
    assert 130.0 < result["wheels"]["rl"]["pressure_kpa"] < 250.0


def test_load_rests_on_the_four_tyres(tmp_path: Path, smooth: dict[str, Any]) -> None:
    result = driven(tmp_path, "--road", "flat", "--duration", "3", "--load", "300")
    more = sum(means(result, "load_n")) - sum(means(smooth, "load_n"))
    assert more == pytest.approx(300.0 * GRAVITY, rel=0.01)  # what is left of the settling


def test_wheels_turn_at_the_speed_over_their_rolling_radius(smooth: dict[str, Any]) -> None:
    for wheel in WHEELS:
        figures = smooth["wheels"][wheel]
        rolled = figures["mean_speed_rad_s"] * figures["rolling_radius_m"] * 3.0
        assert rolled == pytest.approx(smooth["distance_m"], rel=2e-3)  # the slip of driving at 80 km/h


def test_seed_changes_the_road_and_the_saved_scenario_replays_the_drive(plain: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "again").mkdir()
    saved = str(Path(plain["log"]).with_name("drive.json"))
    replayed = driven(tmp_path / "again", "--scenario", saved)
    first, second = read_log(Path(plain["log"])), read_log(Path(replayed["log"]))
    assert differing(first, second) == []
    compare = [RERUN, "rrd", "compare", "--unordered", plain["recording"], replayed["recording"]]
    assert subprocess.run(compare, capture_output=True, check=False).returncode == 0
    other = driven(tmp_path, "--duration", "3", "--seed", "5")
    changed = differing(first, read_log(Path(other["log"])))
    assert {"truth/fl/road_height", "imu/accel", "wheel/fl/edges"} <= set(changed)


def differing(one: DriveLog, other: DriveLog) -> list[str]:
    """Signals that are not the same to the last bit."""
    return [name for name in sorted({*one, *other}) if name not in one or name not in other or one[name] != other[name]]


def test_estimators_say_of_the_saved_log_what_they_said_during_the_drive(plain: dict[str, Any], tmp_path: Path) -> None:
    said = tmp_path / "said.json"
    command = [sys.executable, "-m", "estimators", plain["log"], "--json", str(said)]
    subprocess.run(command, check=True, capture_output=True)
    document = json.loads(said.read_text())["estimators"]
    again = {
        f"est/{name}/{quantity}": (entry["value"], entry["std"])
        for name, method in document.items()
        for quantity, entry in method["estimates"].items()
    }
    assert again == {name: (entry["value"], entry["std"]) for name, entry in plain["estimates"].items()}


def test_table_shows_truth_and_estimates_of_every_wheel(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--road", "flat", "--duration", "2", "--out", str(tmp_path / "drive.rrd")]) == 0
    shown = capsys.readouterr().out
    for part in (
        *WHEELS,
        "pressure (kPa)",
        "stiffness (kN/m)",
        "rolling radius (mm)",
        "wheel_radius",
        "times real time",
    ):
        assert part in shown


def test_estimators_can_be_left_out(tmp_path: Path) -> None:
    result = driven(tmp_path, "--road", "flat", "--duration", "1", "--estimators", "none")
    assert result["estimates"] == {}
    assert not [name for name in read_log(tmp_path / "drive.rrd") if name.startswith("est/")]


def test_killed_drive_leaves_a_recording_that_opens(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "testbed.drive",
        "--duration",
        "3600",
        "--out",
        str(tmp_path / "drive.rrd"),
        "--quiet",
    ]
    part = tmp_path / "drive.part.rrd"
    with subprocess.Popen(command) as process:
        deadline = time.monotonic() + 60.0
        while not (part.is_file() and part.stat().st_size > 8e6):  # about 12 s of driving
            assert process.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.05)
        os.kill(process.pid, signal.SIGKILL)
    assert [path.name for path in tmp_path.iterdir()] == [part.name]
    log = read_log(part)
    assert log.span[1] > 5.0
    assert log["imu/accel"].time[-1] == pytest.approx(log["truth/fl/load"].time[-1], abs=5.0)
