"""Bad input to `python -m testbed.drive`: exit status 2, one line that names it, nothing under the final name."""

from __future__ import annotations

import json
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from estimators.readers import read_log
from testbed.drive import main

SHARED = Path(__file__).resolve().parents[1].parent / "shared" / "data"


def refusal(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line with which a drive is refused."""
    try:
        status = main(["--quiet", "--duration", "1", *arguments])
    except SystemExit as left:  # argparse's own
        status = left.code
    said = capsys.readouterr()
    assert status == 2
    assert said.out == ""
    lines = said.err.splitlines()
    assert len(lines) == 1, said.err
    assert lines[0].startswith("testbed.drive: ")
    return lines[0]


# arguments, what the line must name: the bad value and the valid ones
REFUSED = [
    (["--road", "J"], ["'J'", "A..H"]),
    (["--road", ""], ["''", "A..H"]),
    (["--road", "A:0,D:300"], ["A:0"]),
    (["--road", "A:x,D"], ["A:x"]),
    (["--road", "gd=-1"], ["gd=-1", "m^3"]),
    (["--road", "gd=nan"], ["gd=nan", "m^3"]),
    (["--road", "nowhere.crg"], ["nowhere.crg"]),
    (["--road", "nowhere.txt"], ["nowhere.txt"]),
    (["--manoeuvre", "loop"], ["'loop'", "constant", "slalom"]),
    (["--estimators", "magic"], ["'magic'", "wheel_radius"]),
    (["--tyre", "stone"], ["stone", "suv-235-60r18"]),
    (["--tyre", "nowhere.tir"], ["nowhere.tir"]),
    (["--tyre", "nowhere.toml"], ["nowhere.toml"]),
    (["--driven", "left"], ["'left'", "front, rear, all"]),
    (["--fault", "wheel/rr"], ["'wheel/rr'", "SENSOR=KIND"]),
    (["--fault", "wheel/rr=bent@1"], ["'bent'", "stuck"]),
    (["--brake", "rl=3000"], ["rl=3000", "WHEEL=NM@START"]),
    (["--brake", "rl=3000@2-1"], ["rl=3000@2-1", "a later end"]),
    (["--brake", "rl=-1@2"], ["rl=-1@2", "10000 N m"]),
    (["--duration", "0"], ["duration 0", "0.01 to 86400"]),
    (["--duration", "-3"], ["duration -3", "0.01 to 86400"]),
    (["--duration", "nan"], ["'nan'"]),
    (["--duration", "1e9"], ["1e9", "0.01 to 86400"]),
    (["--duration", "long"], ["'long'"]),
    (["--speed", "-80"], ["-80", "0 to 200"]),
    (["--speed", "201"], ["201", "0 to 200"]),
    (["--speed", "inf"], ["'inf'"]),
    (["--pressure", "fx=180"], ["'fx'", "fl, fr, rl, rr"]),
    (["--pressure", "180"], ["'180'", "fl=180"]),
    (["--pressure", "fl=-5"], ["fl=-5", "0 to 500"]),
    (["--pressure", "fl=501"], ["fl=501", "0 to 500"]),
    (["--pressure", "fl=nan"], ["'nan'"]),
    (["--leak", "rr=-5@20"], ["rr=-5@20"]),
    (["--leak", "rr=5@-1"], ["rr=5@-1"]),
    (["--leak", "rr=five"], ["'five'"]),
    (["--set", "fl=130"], ["fl=130", "fl=130@30/1.5"]),
    (["--set", "fl=900@1"], ["900", "0 to 500"]),
    (["--load", "-1"], ["-1", "0 to 1000"]),
    (["--load", "5000"], ["5000", "0 to 1000"]),
    (["--load", "nan"], ["'nan'"]),
    (["--load-position", "1,2"], ["'1,2'", "x,y,z"]),
    (["--load-position", "9,0,0"], ["9", "3 m"]),
    (["--radius", "fl=50"], ["50", "-10 to 10"]),
    (["--friction", "0"], ["'0'", "2"]),
    (["--friction", "wet"], ["'wet'"]),
    (["--grade", "80"], ["80 %", "-30 to 30 %"]),
    (["--bank", "-21"], ["-21 %", "-20 to 20 %"]),
    (["--bank", "nan"], ["'nan'"]),
    (["--wind", "200"], ["200 km/h", "0 to 140 km/h"]),
    (["--wind", "20@400"], ["400 deg", "-360 to 360"]),
    (["--wind", "20/150"], ["150 %", "0 to 100 %"]),
    (["--wind", "20@"], ["'20@'", "30@90/25"]),
    (["--wind", "north"], ["'north'"]),
    (["--ambient", "-200"], ["-200 Celsius", "-40 to 60"]),
    (["--obstacle", "tree@5"], ["tree"]),
    (["--obstacle", "cleat@5:height=500,length=30"], ["500", "0.1 to 150 mm"]),
    (["--obstacle", "pothole@5:depth=500,length=300"], ["500", "0.1 to 300 mm"]),
    (["--pressure", "fl=200,fl=100"], ["fl=100", "twice"]),
    (["--road", "A:1e9,D"], ["A:1e9", "0.05 to"]),
    (["--estimators", ","], ["''", "wheel_radius"]),
    (["--sensors", ""], ["--sensors ''"]),
    (["--scenario", ""], ["--scenario ''"]),
    (["--out", ""], ["--out ''"]),
    (["--json", ""], ["--json ''"]),
    (["--obstacle", "cleat@50:height=x"], ["height"]),
    (["--seed", "-1"], ["-1", "0 to 2^63"]),
    (["--seed", "1.5"], ["'1.5'"]),
    (["--wings", "2"], ["--wings"]),
    (["--sensors", "nowhere.json"], ["nowhere.json"]),
    (["--scenario", "nowhere.json"], ["nowhere.json"]),
]


@pytest.mark.parametrize(("arguments", "named"), REFUSED, ids=[" ".join(a) for a, _ in REFUSED])
def test_bad_value_is_refused_by_name(
    arguments: list[str],
    named: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    line = refusal(capsys, "--out", str(tmp_path / "drive.rrd"), "--json", str(tmp_path / "drive.json"), *arguments)
    for part in named:
        assert part in line
    assert list(tmp_path.iterdir()) == []


SCENARIOS = [
    ("", "JSON"),
    ("{", "JSON"),
    ("[1]", "JSON object"),
    ('{"speeed": 10}', "'speeed'"),
    ('{"speed": "fast"}', "fast"),
    ('{"speed": NaN}', "nan"),
    ('{"duration": true}', "True"),
    ('{"road": 5}', "5"),
    ('{"seed": 1.5}', "1.5"),
    ('{"pressures": {"fl": "soft"}}', "soft"),
    ('{"pressures": 5}', "5"),
    ('{"leaks": {"fl": 5}}', "want rate, start"),
    ('{"leaks": 5}', "leaks 5"),
    ('{"speed": 1' + 400 * "0" + "}", "out of range"),
    ('{"obstacles": "cleat"}', "'cleat', want a list"),
    ('{"leaks": {"fl": {"rate": "x"}}}', "'x'"),
    ('{"obstacles": [5]}', "5"),
    ('{"obstacles": 5}', "want a list"),
    ('{"payload_position": [1, 2]}', "[1, 2]"),
    ('{"payload_position": [NaN, 0, 0]}', "nan"),
    ('{"sensors": 5}', "5"),
    ('{"step": 0.0003}', "0.0003"),
    ('{"scenario": 5}', "scenario"),
]


@pytest.mark.parametrize(("text", "named"), SCENARIOS, ids=[text for text, _ in SCENARIOS])
def test_malformed_scenario_file_is_refused(
    text: str, named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    saved = tmp_path / "saved.json"
    saved.write_text(text)
    assert named in refusal(capsys, "--scenario", str(saved), "--out", str(tmp_path / "drive.rrd"))
    assert list(tmp_path.iterdir()) == [saved]


SENSORS = [
    ("", "JSON"),
    ("[]", "JSON object"),
    ('{"imu/taste": {"noise": 1}}', "'imu/taste'"),
    ('{"imu/gyro": {"nose": 1}}', "'nose'"),
    ('{"imu/gyro": {"noise": -1}}', "-1"),
    ('{"imu/gyro": {"noise": NaN}}', "nan"),
    ('{"imu/gyro": {"noise": "low"}}', "'low'"),
    ('{"imu/gyro": {"noise": 1e308}}', "1e+308"),
    ('{"imu/gyro": 5}', "5"),
]


@pytest.mark.parametrize(("text", "named"), SENSORS, ids=[text for text, _ in SENSORS])
def test_malformed_sensor_settings_are_refused(
    text: str, named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = tmp_path / "sensors.json"
    settings.write_text(text)
    assert named in refusal(capsys, "--sensors", str(settings), "--out", str(tmp_path / "drive.rrd"))
    assert list(tmp_path.iterdir()) == [settings]


def truncated(name: str) -> Callable[[Path], None]:
    def write(target: Path) -> None:
        source = SHARED / name
        if not source.is_file():
            pytest.skip(f"needs {source}")
        content = source.read_bytes()
        target.write_bytes(content[: int(0.61 * len(content))])

    return write


def holding(content: bytes) -> Callable[[Path], None]:
    return lambda target: target.write_bytes(content) and None


def damaged_header(target: Path) -> None:
    source = SHARED / "krc_rms_course_2in.crg"
    if not source.is_file():
        pytest.skip(f"needs {source}")
    target.write_bytes(source.read_bytes().replace(b"5.0000000000000003e-02", b"nan                   ", 1))


FILES = [
    ("--road", "empty.crg", holding(b"")),
    ("--road", "noise.crg", holding(bytes(range(256)) * 9)),
    ("--road", "words.crg", holding(b"$CT\nnothing measured\n")),
    ("--road", "short.crg", truncated("belgian_block.crg")),
    ("--road", "short.crg", truncated("krc_rms_course_2in.crg")),
    ("--road", "empty.txt", holding(b"")),
    ("--road", "noise.txt", holding(bytes(range(128, 256)) * 9)),
    ("--road", "words.txt", holding(b"0 0\n0.25 high\n")),
    ("--road", "nan.crg", damaged_header),
    ("--road", "backwards.txt", holding(b"".join(b"%d 0\n" % -k for k in range(20)))),
    ("--road", "nan.txt", holding(b"".join(b"%d nan\n" % k for k in range(20)))),
    ("--tyre", "empty.tir", holding(b"")),
    ("--tyre", "noise.tir", holding(bytes(range(256)))),
    ("--tyre", "words.tir", holding(b"[MODEL]\nFITTYP = round\n")),
    ("--tyre", "short.tir", truncated("fed_alpha_335_65R22.5_40psi.tir")),
    ("--tyre", "empty.toml", holding(b"")),
    ("--tyre", "words.toml", holding(b"stiffness = high\n")),
]


@pytest.mark.parametrize(("option", "name", "write"), FILES, ids=[f"{n}{k}" for k, (_, n, _) in enumerate(FILES)])
def test_damaged_road_or_tyre_file_is_refused_by_name(
    option: str, name: str, write: Callable[[Path], None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path / name)
    assert name in refusal(capsys, option, str(tmp_path / name), "--out", str(tmp_path / "drive.rrd"))
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("content", [b"", b"RRF2", bytes(range(256)) * 20], ids=["empty", "head alone", "noise"])
def test_damaged_log_is_refused(content: bytes, tmp_path: Path) -> None:
    log = tmp_path / "drive.rrd"
    log.write_bytes(content)
    done = subprocess.run([sys.executable, "-m", "estimators", str(log)], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "drive.rrd" in done.stderr


OUTPUTS = [
    ("--out", "drive.txt", ".rrd"),
    ("--out", "taken.rrd", "folder"),
    ("--out", "file/drive.rrd", "file/drive.rrd"),
    ("--out", "/proc/drive.rrd", "/proc/drive.rrd"),
    ("--json", "taken.rrd", "folder"),
    ("--json", "file/drive.json", "file/drive.json"),
    ("--json", "fine.rrd", "is the recording"),
    ("--json", "/proc/drive.json", "/proc/drive.json"),
]


@pytest.mark.parametrize(("option", "name", "named"), OUTPUTS, ids=[f"{o} {n}" for o, n, _ in OUTPUTS])
def test_output_that_cannot_be_written_is_refused(
    option: str, name: str, named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "taken.rrd").mkdir()
    (tmp_path / "file").write_text("")
    arguments = ["--out", str(tmp_path / "fine.rrd"), option, str(tmp_path / name)]
    assert named in refusal(capsys, *arguments)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "taken.rrd"]


def test_load_position_and_ambient_at_their_limits_are_valid(tmp_path: Path) -> None:
    arguments = ["--quiet", "--duration", "0.1", "--out", str(tmp_path / "drive.rrd"), "--load", "100"]
    assert main([*arguments, "--load-position", "-0.8,0.4,0.2", "--ambient", "-40", "--grade", "-30"]) == 0


def test_json_goes_through_a_link_and_into_a_device(tmp_path: Path) -> None:
    """What is no file stays what it is: a result can go to a pipe, and a full device says so."""
    (tmp_path / "real.json").write_text("old")
    (tmp_path / "link.json").symlink_to(tmp_path / "real.json")
    arguments = ["--quiet", "--duration", "0.1", "--out", str(tmp_path / "drive.rrd"), "--json"]
    assert main([*arguments, str(tmp_path / "link.json")]) == 0
    assert (tmp_path / "link.json").is_symlink()
    assert json.loads((tmp_path / "real.json").read_text())["seed"] == 0
    (tmp_path / "full").symlink_to("/dev/full")
    assert main([*arguments, str(tmp_path / "full")]) == 2
    assert Path("/dev/full").is_char_device()


def test_second_drive_into_the_same_recording_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from testbed.recording import RecordingWriter

    with RecordingWriter(tmp_path / "drive.rrd", {}) as writer:
        writer.add("engine/torque", [0.0], [1.0], "N m")
        assert "another drive is writing it" in refusal(capsys, "--out", str(tmp_path / "drive.rrd"))
    assert [path.name for path in tmp_path.iterdir()] == ["drive.rrd"]
    assert main(["--quiet", "--duration", "0.1", "--out", str(tmp_path / "drive.rrd")]) == 0


def test_interrupted_drive_says_where_its_recording_is(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "testbed.drive", "--duration", "3600", "--out", "drive.rrd", "--quiet"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60.0
        while not ((tmp_path / "drive.part.rrd").is_file() and (tmp_path / "drive.part.rrd").stat().st_size > 1e6):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=60.0)[1]
    assert process.returncode == 130
    assert said.splitlines() == ["testbed.drive: interrupted; what was recorded is in drive.part.rrd"]
    assert read_log(tmp_path / "drive.part.rrd").span[1] > 0.5


def test_full_disk_is_told_and_leaves_nothing_under_the_final_names(tmp_path: Path) -> None:
    """A limit on file size stands for the full disk: the write that exceeds it fails in the same way."""
    command = [sys.executable, "-m", "testbed.drive", "--duration", "20", "--out", "drive.rrd", "--json", "drive.json"]
    limit = 1_000_000  # bytes, a second or two of driving
    done = subprocess.run(
        [*command, "--quiet"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
    )
    assert done.returncode == 2, done.stderr
    assert len(done.stderr.splitlines()) == 1, done.stderr
    assert "drive.rrd" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["drive.part.rrd"]


def test_drive_that_diverges_is_told_and_leaves_nothing_under_the_final_names(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Four times class H at 200 km/h throws any car."""
    out, result = tmp_path / "drive.rrd", tmp_path / "drive.json"
    road = ["--road", "gd=1", "--speed", "200", "--quiet"]
    assert main([*road, "--out", str(out), "--json", str(result)]) == 2
    lines = capfd.readouterr().err.splitlines()
    assert len(lines) == 1, lines
    assert "gd=1 at 200 km/h is more than it can take" in lines[0]
    assert not out.exists()
    assert not result.exists()


def test_failed_drive_leaves_an_earlier_result_as_it_was(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = tmp_path / "drive.json"
    result.write_text(json.dumps({"earlier": True}))
    refusal(capsys, "--road", "J", "--out", str(tmp_path / "drive.rrd"), "--json", str(result))
    assert json.loads(result.read_text()) == {"earlier": True}
