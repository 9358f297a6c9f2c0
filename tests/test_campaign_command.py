"""`python -m testbed.campaign`: the same table whatever happens on the way, and a line for what does."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from distributed import LocalCluster

from estimators.drive_log import WHEELS
from estimators.readers import read_log
from testbed.campaign.__main__ import INTERRUPTED, main
from testbed.campaign.drive_row import drive_row
from testbed.campaign.engine import run_tasks
from testbed.campaign.plan import read_campaign
from testbed.campaign.pool import Pool
from testbed.drive import main as drive
from tests.campaigns import ROOT, campaign_file, command, table

SLOW = 120.0  # s that a busy machine may take


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the small campaign, run at once in this process."""
    folder = tmp_path_factory.mktemp("plain")
    assert main([str(campaign_file(folder)), "--jobs", "1", "--quiet", "--out", str(folder)]) == 0
    return folder


def parts(folder: Path) -> list[Path]:
    return sorted((folder / "parts").glob("*.parquet"))


def wait_for_parts(folder: Path, count: int) -> None:
    end = time.monotonic() + SLOW
    while len(parts(folder)) < count:
        assert time.monotonic() < end
        time.sleep(0.02)


def test_table_holds_every_drive_with_what_was_said_and_true(plain: Path) -> None:
    rows = pq.read_table(plain / "drives.parquet").to_pylist()
    assert [(row["road"], row["speed_kmh"]) for row in rows] == [("flat", 50), ("flat", 90), ("C", 50), ("C", 90)]
    for row in rows:
        assert row["error"] is None
        assert row["time_s"] == pytest.approx([1.0, 2.0, 3.0])
        assert row["distance_m"] == pytest.approx(3.0 * row["speed_kmh"] / 3.6, rel=0.02)
        assert row["pressure_kpa/fl"][-1] == pytest.approx(row["pressure_kpa.fl"], rel=0.01)
        values = row["wheel_radius/fl/relative_pressure_change/value"]
        assert len(values) == 3
        assert all(abs(v) < 1e6 for v in values)  # from the first second on
    assert not list(plain.glob("*.part"))


def test_report_scores_and_worst_drive_are_there(plain: Path) -> None:
    scores = json.loads((plain / "scores.json").read_text())
    assert scores["drives"] == 4
    worst = scores["worst"]["wheel_radius"]
    assert (plain / f"drive-{worst}.rrd").is_file()
    page = (plain / "report.html").read_text()
    assert "&lt;rough&gt;" in page
    assert f'href="drive-{worst}.rrd"' in page
    assert f"--scenario {plain / 'worst-wheel_radius.json'}" in page


def test_plain_drive_replays_to_the_same_numbers_by_its_scenario(plain: Path, tmp_path: Path) -> None:
    worst = json.loads((plain / "worst-wheel_radius.json").read_text())
    row = pq.read_table(plain / "drives.parquet").to_pylist()[worst["number"]]
    result, out = tmp_path / "drive.json", tmp_path / "drive.rrd"
    words = ["--scenario", plain / "worst-wheel_radius.json", "--json", result, "--out", out, "--quiet"]
    assert drive([*map(str, words), "--estimators", "wheel_radius"]) == 0
    found = json.loads(result.read_text())
    assert found["distance_m"] == row["distance_m"]
    for wheel in WHEELS:
        for name, value in found["wheels"][wheel].items():
            assert value == row[f"{wheel}/{name}"], name
        said = found["estimates"][f"est/wheel_radius/{wheel}/relative_pressure_change"]["value"]
        assert said == row[f"wheel_radius/{wheel}/relative_pressure_change/value"][-1]


def test_replay_by_number_leaves_a_recording_of_a_changed_car_too(tmp_path: Path) -> None:
    """With a calibration before it, a softer spring and a wrong mass: nothing a scenario could say."""
    changed = "[calibration]\nduration_s = 2\n[vehicle]\nfront.spring_rate = 0.8\n[believed]\nchassis_mass = 0.9\n"
    path = campaign_file(tmp_path, changed)
    assert main([str(path), "--replay", "3", "--out", str(tmp_path), "--quiet"]) == 0
    log = read_log(tmp_path / "drive-3.rrd")
    row = drive_row(read_campaign(path).tasks[3])
    said = log["est/wheel_radius/fl/relative_pressure_change"].value
    assert said.tolist() == row["wheel_radius/fl/relative_pressure_change/value"]
    assert log.notes["car"]["chassis_mass"] == pytest.approx(0.9 * 1788.0)


def test_killed_campaign_goes_on_in_two_processes_to_the_same_table(plain: Path, tmp_path: Path) -> None:
    path, out = campaign_file(tmp_path), tmp_path / "out"
    process = command(path, "--jobs", "2", "--quiet", "--out", out)
    wait_for_parts(out, 2)
    process.kill()
    process.communicate()
    before = {part: part.stat().st_mtime_ns for part in parts(out)}
    assert not (out / "drives.parquet").exists()
    assert main([str(path), "--jobs", "2", "--quiet", "--out", str(out)]) == 0
    assert table(out) == table(plain)
    assert {part: part.stat().st_mtime_ns for part in parts(out) if part in before} == before


def test_dask_cluster_that_loses_a_worker_gives_the_same_rows(plain: Path, tmp_path: Path) -> None:
    tasks = read_campaign(campaign_file(tmp_path)).tasks
    with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:

        def kill_one(done: int, total: int) -> None:
            if done == 1:
                os.kill(cluster.workers[0].pid, signal.SIGKILL)

        pool = Pool(backend="dask", address=cluster.scheduler_address)
        rows = run_tasks(drive_row, tasks, tmp_path, pool, finished=kill_one)
    wanted = pq.read_table(plain / "drives.parquet").to_pylist()
    for row, other in zip(rows, wanted, strict=True):
        assert {k: repr(v) for k, v in row.items() if k != "wall_s"} == {
            k: repr(v) for k, v in other.items() if k != "wall_s"
        }


def test_interrupted_campaign_says_what_is_kept(tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = command(campaign_file(tmp_path), "--jobs", "2", "--quiet", "--out", out)
    wait_for_parts(out, 1)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=SLOW)
    assert process.returncode == INTERRUPTED
    (line,) = errors.splitlines()
    assert "interrupted" in line
    assert f"of 4 drives are kept in {out}" in line


def test_drive_that_fails_is_a_row_and_counted_in_the_report(tmp_path: Path) -> None:
    path = tmp_path / "failing.toml"
    path.write_text(
        'estimators = ["wheel_radius"]\n[scenario]\nroad = "flat"\nduration_s = 2\n'
        "[vehicle]\nfront.spring_rate = { sweep = [1.0, 1e9] }\n"
    )
    assert main([str(path), "--jobs", "1", "--quiet", "--out", str(tmp_path)]) == 0
    good, bad = pq.read_table(tmp_path / "drives.parquet").to_pylist()
    assert good["error"] is None
    assert bad["error"].startswith("Diverged: ")
    assert bad["vehicle.front.spring_rate"] == 1e9
    assert bad["time_s"] is None
    assert json.loads((tmp_path / "scores.json").read_text())["failed"] == [{"number": 1, "error": bad["error"]}]
    assert "1 of 2 drives failed" in (tmp_path / "report.html").read_text()


def test_full_disk_is_one_line_and_what_was_finished_is_kept(tmp_path: Path) -> None:
    code = (
        "import resource, sys; from testbed.campaign.__main__ import main; "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, resource.RLIM_INFINITY)); sys.exit(main(sys.argv[1:]))"
    )
    words = [sys.executable, "-c", code, str(campaign_file(tmp_path)), "--jobs", "1", "--quiet", "--out", str(tmp_path)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False, timeout=SLOW)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "File too large" in line
    assert "0 of 4 drives are kept" in line
    assert parts(tmp_path) == []


def test_dry_run_says_what_would_run_and_how_long(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(campaign_file(tmp_path)), "--dry-run", "--jobs", "2", "--out", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().out
    for words in ("Is a low tyre found", "4 drives, about 12 s of driving", "swept   flat, C", "uniform of 150, 250"):
        assert words in told
    assert "with 2 processes of this machine" in told
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("more", "arguments", "message"),
    [
        ("wings = 2", [], "unknown field 'wings' of [scenario]; valid: road"),
        ("friction = 3", [], "friction 3 is not a text"),
        ("", ["--jobs", "two"], "--jobs 'two': want a whole number"),
        ("", ["--backend", "dask"], "backend dask needs the address"),
        ("", ["--backend", "abacus"], "unknown backend 'abacus'; valid: processes, dask, ray"),
        ("", ["--replay", "9"], "no drive 9; valid: 0 to 3"),
        ("", ["--out", "/dev/null/x"], "/dev/null/x: Not a directory"),
    ],
)
def test_bad_input_is_one_line_and_status_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: str, arguments: list[Any], message: str
) -> None:
    out = [] if "--out" in arguments else ["--out", str(tmp_path / "out")]
    assert main([str(campaign_file(tmp_path, more)), *out, *arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line
    assert not (tmp_path / "out" / "parts").exists()
