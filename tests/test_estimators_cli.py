"""Claims about `python -m estimators`: what it prints and writes, and one line with status 2 for every bad input."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from estimators.__main__ import main
from estimators.drive_log import WHEELS
from tests.synthetic_drive import Noise, drive, varied_speed

COLUMN_MAP = """
[time]
column = "t"
""" + "".join(f'[signals."wheel/{w}/speed"]\ncolumn = "{w}"\nunit = "rad/s"\n' for w in WHEELS)


def write_csv(path: Path, seconds: float, radius_change: Sequence[float] = (0.0, 0.0, 0.0, 0.0)) -> Path:
    """A log of a real kind: time and four wheel speeds."""
    log = drive(varied_speed(seconds), radius_change=radius_change, noise=Noise(0.01), seed=1)
    columns = [log["wheel/fl/speed"].time, *(log[f"wheel/{w}/speed"].value for w in WHEELS)]
    np.savetxt(path, np.column_stack(columns), delimiter=",", header="t," + ",".join(WHEELS), comments="", fmt="%.9g")
    return path


@pytest.fixture
def mapped(tmp_path: Path) -> tuple[str, list[str]]:
    """A 20 s log and the options that read it."""
    column_map = tmp_path / "map.toml"
    column_map.write_text(COLUMN_MAP)
    return str(write_csv(tmp_path / "drive.csv", 20.0)), ["--column-map", str(column_map)]


def refused(capsys: pytest.CaptureFixture[str], arguments: Sequence[str]) -> str:
    """The one line on stderr of a refusal."""
    assert main(arguments) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1
    assert "Traceback" not in line
    return line


def test_a_log_gives_a_table_and_json_of_the_same_estimates(
    mapped: tuple[str, list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, options = mapped
    out = tmp_path / "out.json"
    assert main([log, "wheel_radius", *options, "--json", str(out)]) == 0
    printed = capsys.readouterr().out
    said = json.loads(out.read_text())["estimators"]["wheel_radius"]
    assert said["missing_signals"] == []
    assert {"value", "std", "unit", "time_s"} == set(said["estimates"]["static_residual"])
    words = {word for name in said["estimates"] for word in name.replace("/", " ").replace("_", " ").split()}
    assert all(word in printed for word in words)
    assert "no alarms" in printed
    assert any("imu/gyro" in flag["text"] for flag in said["flags"])
    assert not list(tmp_path.glob("*.part"))


def test_what_one_drive_learnt_calibrates_the_next(
    mapped: tuple[str, list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Wheel speeds alone calibrate the static residual only; the second drive's change is the loss of one wheel."""
    _, options = mapped
    learnt, out = tmp_path / "learnt.json", tmp_path / "out.json"
    tyres = np.array([2e-3, 0.0, -1e-3, 0.0])
    assert main([str(write_csv(tmp_path / "first.csv", 130.0, tyres)), *options, "--json", str(learnt)]) == 0
    low = tyres + np.array([0.0, 0.0, 0.0, -2.5e-3])
    second = str(write_csv(tmp_path / "second.csv", 20.0, low))
    assert main([second, *options, "--calibration", str(learnt), "--json", str(out)]) == 0
    change = json.loads(out.read_text())["estimators"]["wheel_radius"]["estimates"]["static_residual_change"]
    assert change["value"] == pytest.approx(2.5e-3, abs=4e-4)
    assert change["std"] < 2.5e-4  # a tenth of the loss


def test_a_car_file_replaces_fields_of_the_car(mapped: tuple[str, list[str]], tmp_path: Path) -> None:
    log, options = mapped
    car, out = tmp_path / "car.json", tmp_path / "out.json"
    car.write_text('{"driven_axle": "rear", "rear_track": 1.64}')
    assert main([log, *options, "--car", str(car), "--json", str(out)]) == 0
    written = json.loads(out.read_text())["car"]
    assert (written["driven_axle"], written["rear_track"], written["front_track"]) == ("rear", 1.64, 1.606)


def test_list_names_the_estimators(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--list"]) == 0
    assert "wheel_radius: reads wheel/fl/speed" in capsys.readouterr().out


def test_bad_arguments_are_refused(
    mapped: tuple[str, list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, options = mapped
    assert "no LOG" in refused(capsys, [])
    assert "--nonsense" in refused(capsys, [log, "--nonsense"])
    assert "missing.csv" in refused(capsys, [str(tmp_path / "missing.csv"), *options])
    line = refused(capsys, [log, "magic", *options])
    assert "'magic'" in line
    assert "wheel_radius" in line
    (tmp_path / "broken.csv").write_text("t,fl,fr\n1,x\n")
    assert "broken.csv" in refused(capsys, [str(tmp_path / "broken.csv"), *options])


def test_a_log_without_wheel_speeds_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "map.toml").write_text('[time]\ncolumn = "t"\n[signals."imu/temperature"]\ncolumn = "x"\nunit = "K"\n')
    (tmp_path / "other.csv").write_text("t,x\n0,1\n1,2\n2,3\n")
    line = refused(capsys, [str(tmp_path / "other.csv"), "--column-map", str(tmp_path / "map.toml")])
    assert "no usable signal" in line
    assert "wheel/fl/speed" in line


def test_an_unwritable_json_is_refused_and_leaves_nothing(
    mapped: tuple[str, list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, options = mapped
    before = sorted(tmp_path.iterdir())
    assert "out.json" in refused(capsys, [log, *options, "--json", str(Path(log) / "out.json")])
    (tmp_path / "folder").mkdir()
    assert "folder" in refused(capsys, [log, *options, "--json", str(tmp_path / "folder")])
    assert sorted(tmp_path.iterdir()) == sorted([*before, tmp_path / "folder"])


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ("{", "no JSON"),
        ("[1]", "want a JSON object"),
        ("{}", "holds no calibration"),
        ('{"calibration": {"wheel_radius": {"delta99": {}}}}', "no residual 'delta99', valid: static_residual"),
        ('{"calibration": {"wheel_radius": {"delta12": {"level": "x", "std": 1}}}}', "finite 'level' and 'std'"),
        ('{"calibration": {"magic": {}}}', "no estimator 'magic'"),
    ],
)
def test_a_bad_calibration_is_refused(
    mapped: tuple[str, list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str], content: str, complaint: str
) -> None:
    log, options = mapped
    bad = tmp_path / "bad.json"
    bad.write_text(content)
    assert complaint in refused(capsys, [log, *options, "--calibration", str(bad)])
