"""Claims about a drive's recording: written live, lossless, whole or absent, and laid out from what it holds."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import rerun_cli
from rerun.chunk import RrdReader

from estimators.drive_log import WHEELS, DriveLog, Signal
from estimators.readers import read_log
from testbed.recording import RecordingError, RecordingWriter
from testbed.recording.screenshot import main as screenshot
from tests.recording_contents import flat, layout, rows

RERUN = str(Path(rerun_cli.__file__).with_name("rerun"))
SECONDS = 4


def drive(writer: RecordingWriter, seconds: int = SECONDS, seed: int = 0, start: int = 0) -> dict[str, Signal]:
    """A small synthetic drive, a second at a time; what was recorded."""
    rng = np.random.default_rng(seed)
    pieces: dict[str, list[Signal]] = {}
    writer.show("world/car/chassis", rr.Boxes3D(half_sizes=[[2.0, 0.9, 0.4]]))
    for second in range(start, start + seconds):
        fast, slow = second + np.arange(1000) * 1e-3, second + np.arange(100) * 1e-2
        said = {"imu/accel": Signal(fast, rng.normal(size=(1000, 3)), "m/s^2", "chassis")}
        for wheel in WHEELS:
            said[f"hub/{wheel}/accel_z"] = Signal(np.roll(fast, 3), rng.normal(size=1000), "m/s^2")  # late samples
            said[f"truth/{wheel}/pressure"] = Signal(slow, 250e3 + rng.normal(size=100), "Pa")
            said[f"est/wheel_radius/{wheel}/pressure"] = Signal(slow, 250e3 + rng.normal(size=100), "Pa")
            said[f"est/wheel_radius/{wheel}/pressure/std"] = Signal(slow, np.full(100, 4e3), "Pa")
        said["truth/chassis/velocity"] = Signal(slow, rng.normal(size=(100, 3)), "m/s", "world")
        said["alarm/wheel_radius"] = Signal([second + 0.5], ["rr: low"])
        for name, piece in said.items():
            writer.add(name, piece.time, piece.value, piece.unit, piece.frame)
            pieces.setdefault(name, []).append(piece)
        position = np.stack([20.0 * slow, 0.0 * slow, 0.6 + 0.0 * slow], axis=1)
        writer.pose("world/car/chassis", slow, position, np.tile([1.0, 0.0, 0.0, 0.0], (100, 1)))
    return {name: joined(parts) for name, parts in pieces.items()}


def joined(parts: list[Signal]) -> Signal:
    times, values = [p.time for p in parts], [p.value for p in parts]
    return Signal(np.concatenate(times), np.concatenate(values), parts[0].unit, parts[0].frame)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Signal]]:
    path = tmp_path_factory.mktemp("drive") / "drive.rrd"
    with RecordingWriter(path, {"seed": 3}) as writer:
        signals = drive(writer)
    return path, signals


def test_a_drive_comes_back_to_the_last_bit_and_alone(recorded: tuple[Path, dict[str, Signal]]) -> None:
    path, signals = recorded
    assert read_log(path) == DriveLog(signals, {"seed": 3})
    assert os.listdir(path.parent) == ["drive.rrd"]


def test_an_array_may_be_refilled_once_it_was_added(tmp_path: Path) -> None:
    ticks, values, places, turns = np.arange(3.0), np.ones(3), np.ones((3, 3), np.float32), np.ones((3, 4), np.float32)
    with RecordingWriter(tmp_path / "a.rrd", {}) as writer:
        for second in range(20):
            values[:], places[:] = second, second
            writer.add("engine/torque", ticks + 3 * second, values, "N m")
            writer.pose("world/car/chassis", ticks + 3 * second, places, turns)
            values[:], places[:] = -1.0, -1.0
    assert read_log(tmp_path / "a.rrd")["engine/torque"].value.tolist() == np.repeat(np.arange(20.0), 3).tolist()
    moved = np.concatenate([flat(b, "Transform3D:translation") for b in rows(tmp_path / "a.rrd", "/world/car/chassis")])
    assert moved[::9].tolist() == np.arange(20.0).tolist()


def test_the_same_drive_gives_the_same_recording_and_another_does_not(tmp_path: Path) -> None:
    for name, seed in (("a.rrd", 1), ("b.rrd", 1), ("c.rrd", 2)):
        with RecordingWriter(tmp_path / name, {"seed": 0}) as writer:
            drive(writer, seconds=2, seed=seed)
    compare = [RERUN, "rrd", "compare", "--unordered", str(tmp_path / "a.rrd")]
    assert subprocess.run([*compare, str(tmp_path / "b.rrd")], capture_output=True, check=False).returncode == 0
    assert subprocess.run([*compare, str(tmp_path / "c.rrd")], capture_output=True, check=False).returncode != 0


def test_a_finished_recording_passes_reruns_own_check(recorded: tuple[Path, dict[str, Signal]]) -> None:
    done = subprocess.run([RERUN, "rrd", "verify", str(recorded[0])], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_an_empty_signal_keeps_its_place(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.rrd", {}) as writer:
        writer.add("imu/gyro", [], np.empty((0, 3)), "rad/s", "chassis")
        writer.text("alarm/none", [], [])
    log = read_log(tmp_path / "a.rrd")
    assert log["imu/gyro"] == Signal([], np.empty((0, 3)), "rad/s", "chassis")
    assert log["alarm/none"].value.dtype == object


def test_what_does_not_fit_is_refused_by_name(tmp_path: Path) -> None:
    with RecordingWriter(tmp_path / "a.rrd", {}) as writer:
        writer.add("imu/gyro", [0.0], [[1.0, 2.0, 3.0]], "rad/s")
        with pytest.raises(ValueError, match="imu/gyro: unit, frame and kind were"):
            writer.add("imu/gyro", [1.0], [[1.0, 2.0, 3.0]], "deg/s")
        with pytest.raises(ValueError, match="imu/gyro: unit, frame and kind were"):
            writer.add("imu/gyro", [1.0], [1.0], "rad/s")
        with pytest.raises(ValueError, match=r"engine/torque: value has shape \(3,\)"):
            writer.add("engine/torque", [0.0, 1.0], [1.0, 2.0, 3.0], "N m")
        with pytest.raises(ValueError, match="engine/torque: time nan"):
            writer.add("engine/torque", [np.nan], [1.0], "N m")
        with pytest.raises(ValueError, match=r"world/car: position \(1, 2\)"):
            writer.pose("world/car", [0.0], [[1.0, 2.0]], [[1.0, 0.0, 0.0, 0.0]])
    assert set(read_log(tmp_path / "a.rrd")) == {"imu/gyro"}


def test_a_drive_that_fails_leaves_what_it_recorded_but_no_recording(tmp_path: Path) -> None:
    with pytest.raises(FloatingPointError), RecordingWriter(tmp_path / "a.rrd", {}) as writer:  # noqa: PT012
        signals = drive(writer, seconds=2)
        raise FloatingPointError("diverged")
    assert os.listdir(tmp_path) == ["a.part.rrd"]
    assert read_log(tmp_path / "a.part.rrd") == DriveLog(signals, {})


def test_a_killed_drive_reads_to_the_last_second_sent(tmp_path: Path) -> None:
    code = (
        "import sys, time; sys.path.insert(0, sys.argv[2])\n"
        "from testbed.recording import RecordingWriter\n"
        "from test_recording import drive\n"
        "writer = RecordingWriter(sys.argv[1], {'seed': 1})\n"
        "for second in range(1000):\n"
        "    drive(writer, 1, seed=second, start=second); print(second, flush=True); time.sleep(0.05)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "a.rrd"), str(Path(__file__).parent)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        last = -1
        while last < 9:
            last = int(child.stdout.readline())
        time.sleep(0.04)  # what the writer's thread may take for the second it was given
        child.send_signal(signal.SIGKILL)
        while select.select([child.stdout], [], [], 0.2)[0] and (line := child.stdout.readline()):
            last = int(line)
    assert os.listdir(tmp_path) == ["a.part.rrd"]
    log = read_log(tmp_path / "a.part.rrd")
    assert log.notes == {"seed": 1}
    assert log.span[1] >= last - 1 + 0.999
    assert len(log["imu/accel"]) >= 1000 * last


@pytest.fixture
def tiny_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of 1 MB."""
    mount = tmp_path / "disk"
    mount.mkdir()
    done = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(mount)], capture_output=True, check=False
    )
    if done.returncode != 0:
        pytest.skip("needs the right to mount a small tmpfs")
    yield mount
    subprocess.run(["umount", "-l", str(mount)], check=True)


def test_a_full_disk_is_a_fault_and_leaves_no_recording(tiny_disk: Path) -> None:
    started = time.monotonic()
    writer = RecordingWriter(tiny_disk / "a.rrd", {})
    with pytest.raises(RecordingError, match=r"a\.rrd: recording failed: .*[Nn]o space left") as caught:
        drive(writer, seconds=60)
    writer.abort()
    assert "\n" not in str(caught.value)
    assert time.monotonic() - started < 10.0
    assert not (tiny_disk / "a.rrd").exists()
    assert len(read_log(tiny_disk / "a.part.rrd")["imu/accel"]) > 0


def test_a_disk_that_fills_as_the_layout_joins_leaves_all_that_was_recorded(tiny_disk: Path) -> None:
    writer = RecordingWriter(tiny_disk / "a.rrd", {})
    signals = drive(writer, seconds=3)  # 0.6 MB: once fits, twice does not
    with pytest.raises(RecordingError, match="all of it is in"):
        writer.close()
    assert os.listdir(tiny_disk) == ["a.part.rrd"]
    assert read_log(tiny_disk / "a.part.rrd") == DriveLog(signals, {})


def test_a_band_is_the_estimate_and_its_variance(recorded: tuple[Path, dict[str, Signal]]) -> None:
    path, signals = recorded
    batches = rows(path, "/est/wheel_radius/fl/pressure/band")
    values = np.concatenate([flat(batch, "Measurements:values") for batch in batches])
    assert set(values) <= set(signals["est/wheel_radius/fl/pressure"].value)
    assert len(values) == 25 * SECONDS
    assert {float(v) for b in batches for v in flat(b, "Measurements:variances")} == {4e3**2}


def test_the_layout_asks_only_for_what_the_recording_holds(recorded: tuple[Path, dict[str, Signal]]) -> None:
    path, _ = recorded
    chunks = RrdReader(path).stream().to_chunks()
    entities = {chunk.entity_path for chunk in chunks}
    asked, followed = layout(path)
    exact = {query for query in asked if not query.endswith("/**")}
    assert exact <= entities
    assert asked - exact == {"/world/**"}
    assert {f"/truth/{wheel}/pressure" for wheel in WHEELS} <= exact
    assert {f"/est/wheel_radius/{wheel}/pressure/band" for wheel in WHEELS} <= exact
    assert "/alarm/wheel_radius" in exact
    assert followed == {"/world/car/chassis"}
    drawn = {c.entity_path for c in chunks if any("Boxes3D" in f.name for f in c.to_record_batch().schema)}
    assert followed <= drawn  # the viewer's camera ignores an entity that draws nothing


def test_every_wheel_has_its_colour_and_every_line_its_unit(recorded: tuple[Path, dict[str, Signal]]) -> None:
    styles = {}
    for chunk in RrdReader(recorded[0]).stream().to_chunks():
        batch = chunk.to_record_batch()
        if "SeriesLines:names" in batch.schema.names:
            colours = batch.column("SeriesLines:colors").flatten().to_pylist()
            styles[chunk.entity_path] = (batch.column("SeriesLines:names").flatten().to_pylist(), colours)
    assert styles["/truth/fl/pressure"][0] == ["fl truth [Pa]"]
    assert styles["/est/wheel_radius/rr/pressure"][0] == ["rr wheel_radius [Pa]"]
    assert styles["/imu/accel"][0] == ["x [m/s^2]", "y [m/s^2]", "z [m/s^2]"]
    for wheel in WHEELS:
        assert styles[f"/truth/{wheel}/pressure"][1] == styles[f"/hub/{wheel}/accel_z"][1]
    of_wheels = {styles[f"/truth/{wheel}/pressure"][1][0] for wheel in WHEELS}
    assert len(of_wheels) == 4
    for colour in {
        colour for _, colours in styles.values() for colour in colours
    }:  # neither black nor white ground hides it
        assert 80 < sum((colour >> shift) & 255 for shift in (8, 16, 24)) / 3 < 180


def test_the_viewer_draws_every_view_of_a_recording(recorded: tuple[Path, dict[str, Signal]], tmp_path: Path) -> None:
    if not list(Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json")):
        pytest.skip("needs a software Vulkan driver: apt-get install mesa-vulkan-drivers libvulkan1")
    arguments = [str(recorded[0]), str(tmp_path / "a.png"), "--time", "2", "--size", "800x600"]
    assert screenshot(arguments) == 0  # it ends with 2 if a view reports that it cannot draw
    picture = (tmp_path / "a.png").read_bytes()
    assert picture[1:4] == b"PNG"
    assert int.from_bytes(picture[16:20], "big") == 800


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--time", "99"], "--time 99: the recording runs from 0 to 3.999 s"),
        (["--size", "big"], "--size big: want WIDTHxHEIGHT"),
    ],
)
def test_a_picture_that_cannot_be_is_refused(
    recorded: tuple[Path, dict[str, Signal]],
    tmp_path: Path,
    arguments: list[str],
    said: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert screenshot([str(recorded[0]), str(tmp_path / "a.png"), *arguments]) == 2
    assert said in capsys.readouterr().err
    assert os.listdir(tmp_path) == []
