"""Claims about recordings as log files: nothing is lost, nothing half-written passes for whole, faults come out."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
import rerun_cli

from estimators.drive_log import DriveLog, Signal
from estimators.readers import read_log
from estimators.readers.rrd import save_log
from estimators.readers.rrd_file import RecordingError

RERUN = str(Path(rerun_cli.__file__).with_name("rerun"))
NOTES = {"seed": 7, "car": {"mass_kg": 1800.5, "driven": ["rl", "rr"], "name": "Wägelchen"}, "leak": None, "wet": False}


def random_log(seed: int) -> DriveLog:
    """Signals of every kind on irregular clocks with repeated and late stamps, NaN, infinities and denormals."""
    rng = np.random.default_rng(seed)
    signals = {}
    for index in range(8):
        n = int(rng.choice([0, 1, 7, 400, 9000]))
        time = np.abs(np.cumsum(rng.normal(0.01, 0.05, n))) + 0.0
        time[n // 2 :] = time[: n - n // 2]  # repeated, and back in time
        width = int(rng.integers(0, 5))
        value = rng.normal(size=n if width == 0 else (n, width)) * 10.0 ** rng.integers(-300, 300)
        value.reshape(-1)[:: int(rng.integers(2, 9))] = rng.choice([np.nan, np.inf, -np.inf, -0.0, 5e-324])
        signals[f"imu/signal {index}"] = Signal(
            time, value, str(rng.choice(["m/s^2", "Pa", ""])), "chassis" * (index % 2)
        )
    signals["alarm/wheel_radius"] = Signal([1.5, 0.5, 0.5], ["rr low", "", "Ü 'quoted' \n line"])
    signals["alarm/silent"] = Signal([], np.array([], dtype=str))
    return DriveLog(signals, NOTES)


@pytest.mark.parametrize("seed", range(6))
def test_a_saved_log_comes_back_to_the_last_bit(tmp_path: Path, seed: int) -> None:
    log = random_log(seed)
    save_log(log, tmp_path / "log.rrd")
    loaded = read_log(tmp_path / "log.rrd")
    assert loaded.notes == NOTES
    assert set(loaded) == set(log)
    for name, signal in log.items():
        assert loaded[name] == signal, name
        assert loaded[name].value.tobytes() == signal.value.tobytes() or signal.value.dtype == object, name
    assert os.listdir(tmp_path) == ["log.rrd"]


def test_a_log_without_signals_comes_back(tmp_path: Path) -> None:
    save_log(DriveLog({}, NOTES), tmp_path / "log.rrd")
    assert read_log(tmp_path / "log.rrd") == DriveLog({}, NOTES)


def test_recorded_order_survives_reruns_own_compaction(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    log = DriveLog({"wheel/fl/edges": Signal(rng.permutation(30_000) * 1e-3, np.arange(30_000.0), "")})
    save_log(log, tmp_path / "log.rrd")
    command = [RERUN, "rrd", "optimize", str(tmp_path / "log.rrd"), "-o", str(tmp_path / "compact.rrd")]
    subprocess.run(command, check=True, capture_output=True)
    assert read_log(tmp_path / "compact.rrd") == log


def test_a_torn_recording_reads_to_its_last_whole_message_only_as_a_part(tmp_path: Path) -> None:
    log = DriveLog(
        {"imu/gyro": Signal(np.arange(60_000) * 1e-3, np.random.default_rng(0).normal(size=60_000), "rad/s")}
    )
    save_log(log, tmp_path / "log.rrd")
    whole = (tmp_path / "log.rrd").read_bytes()
    counts = []
    for length in np.linspace(5_000, len(whole) - 1, 12).astype(int):
        for name in ("torn.rrd", "torn.part.rrd"):
            (tmp_path / name).write_bytes(whole[:length])
        with pytest.raises(ValueError, match=r"torn\.rrd: the recording is cut short"):
            read_log(tmp_path / "torn.rrd")
        signal = read_log(tmp_path / "torn.part.rrd").get("imu/gyro", Signal([], []))
        counts.append(len(signal))
        assert np.array_equal(signal.value, log["imu/gyro"].value[: len(signal)])
    assert counts == sorted(counts)
    assert counts[-1] == 60_000  # only the footer was torn
    assert 0 < counts[6] < 60_000


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.rrd", b"", "empty file"),
        ("a.rrd", b"not a recording at all, really", "not a Rerun recording"),
        ("a.rrd", b"RRF2", "not a Rerun recording"),
        ("a.part.rrd", b"RRF2" + bytes(8), "cut short before its first"),
        ("a.part.rrd", b"RRF2" + bytes(100), "damaged recording|not of a drive|cut short"),
        ("a.xyz", b"1,2,3", r"unknown kind of log '\.xyz', want one of \.rrd, \.csv, \.mf4"),
        ("absent.rrd", None, "no such log"),
    ],
)
def test_what_is_no_recording_is_refused_in_one_line(
    tmp_path: Path, name: str, content: bytes | None, said: str
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=said) as caught:
        read_log(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_flipped_byte_never_gets_out_as_anything_but_a_value_error(tmp_path: Path) -> None:
    save_log(random_log(1), tmp_path / "log.rrd")
    whole = (tmp_path / "log.rrd").read_bytes()
    rng = np.random.default_rng(5)
    refusals = []
    for position in rng.integers(12, len(whole), 30):
        flipped = bytearray(whole)
        flipped[position : position + 40] = bytes(len(flipped[position : position + 40]))
        (tmp_path / "flipped.rrd").write_bytes(flipped)
        try:
            read_log(tmp_path / "flipped.rrd")
        except ValueError as error:
            refusals.append(str(error))
    assert refusals
    assert all("flipped.rrd: " in refusal and "\n" not in refusal for refusal in refusals)


def test_a_time_that_would_not_come_back_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"imu/gyro: time 1\.7e\+09 s is outside"):
        save_log(DriveLog({"imu/gyro": Signal([1.7e9], [0.0])}), tmp_path / "log.rrd")
    assert os.listdir(tmp_path) == []


def test_notes_that_json_cannot_hold_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="not a JSON value"):
        save_log(DriveLog({}, {"when": object()}), tmp_path / "log.rrd")


@pytest.mark.parametrize("name", ["", "/imu", "imu//gyro", "__properties/x"])
def test_a_name_that_is_no_path_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="signal name"):
        save_log(DriveLog({name: Signal([], [])}), tmp_path / "log.rrd")


def test_an_unwritable_place_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(RecordingError, match="cannot write here"):
        save_log(DriveLog({}), tmp_path / "file" / "log.rrd")
    (tmp_path / "folder.rrd").mkdir()
    with pytest.raises(RecordingError, match="is a folder"):
        save_log(DriveLog({}), tmp_path / "folder.rrd")
    with pytest.raises(ValueError, match=r"name ends in \.rrd"):
        save_log(DriveLog({}), tmp_path / "log.csv")
