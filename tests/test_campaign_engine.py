"""The campaign engine loses nothing: rows on disk at once, failures and dead workers as rows, a second call goes on."""

from __future__ import annotations

import errno
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from testbed.campaign import engine
from testbed.campaign.code_version import AFTERWARDS, ROOT, code_version
from testbed.campaign.engine import CampaignError, run_tasks
from testbed.campaign.parts import Row, task_key, write_table
from testbed.campaign.pool import Pool
from tests.campaign_work import dying, dying_once, large, refusing, square

TASKS = [{"x": x} for x in range(5)]
ONE, TWO = Pool(jobs=1), Pool(jobs=2)


def same(rows: list[Row]) -> list[str]:
    """Rows as texts that are equal where the numbers are (NaN too), without the time that each took."""
    return [repr(sorted((k, v) for k, v in row.items() if k != "wall_s")) for row in rows]


def test_rows_come_in_the_order_of_the_tasks_and_on_disk(tmp_path: Path) -> None:
    rows = run_tasks(square, TASKS, tmp_path, TWO)
    assert [row["square"] for row in rows] == [0, 1, 4, 9, 16]
    assert {p.stem for p in (tmp_path / "parts").iterdir()} == {row["task_key"] for row in rows}


def test_second_call_does_nothing_again_and_gives_the_same_rows(tmp_path: Path) -> None:
    note = tmp_path / "note"
    tasks = [{"x": x, "note": str(note)} for x in range(4)]
    first = run_tasks(square, tasks[:2], tmp_path, ONE)
    told: list[tuple[int, int]] = []
    rows = run_tasks(square, tasks, tmp_path, ONE, lambda *counts: told.append(counts))
    assert sorted(note.read_text().split()) == ["0", "1", "2", "3"]
    assert told == [(2, 4), (3, 4), (4, 4)]
    assert same(rows[:2]) == same(first)
    assert same(run_tasks(square, tasks, tmp_path, TWO)) == same(rows)


def test_equal_tasks_are_done_once(tmp_path: Path) -> None:
    task = {"x": 3, "note": str(tmp_path / "note")}
    assert len(run_tasks(square, [task, task], tmp_path, ONE)) == 2
    assert (tmp_path / "note").read_text() == "3\n"


def test_failure_is_a_row_with_its_error_in_one_line(tmp_path: Path) -> None:
    rows = run_tasks(refusing, TASKS, tmp_path, ONE)
    assert [row["error"] for row in rows] == [None, "ValueError: 1 is odd valid: even", None, rows[3]["error"], None]
    assert rows[4]["square"] == 16


def test_lost_worker_costs_no_row(tmp_path: Path) -> None:
    rows = run_tasks(dying_once, [t | {"flag": str(tmp_path / "flag")} for t in TASKS], tmp_path, TWO)
    assert [row["square"] for row in rows] == [0, 1, 4, 9, 16]
    assert (tmp_path / "flag").exists()


def test_task_that_kills_its_worker_is_a_row_and_is_tried_again_by_the_next_call(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine, "RESTARTS", 2)
    rows = run_tasks(dying, [t | {"deadly": t["x"] == 1} for t in TASKS[:3]], tmp_path, TWO)
    assert [row["error"] is None for row in rows] == [True, False, True]
    assert rows[1]["error"].startswith("WorkerLost: ")
    assert not (tmp_path / "parts" / f"{rows[1]['task_key']}.parquet").exists()


def test_workers_that_only_die_end_the_campaign(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "RESTARTS", 1)
    with pytest.raises(CampaignError, match="workers only die"):
        run_tasks(dying, [t | {"deadly": True} for t in TASKS], tmp_path, TWO)


def test_part_that_was_cut_short_is_told_and_done_again(tmp_path: Path) -> None:
    rows = run_tasks(square, TASKS, tmp_path, ONE)
    part = tmp_path / "parts" / f"{rows[2]['task_key']}.parquet"
    part.write_bytes(part.read_bytes()[:-20])
    lines: list[str] = []
    assert same(run_tasks(square, TASKS, tmp_path, ONE, warn=lines.append)) == same(rows)
    assert len(lines) == 1
    assert str(part) in lines[0]
    assert "\n" not in lines[0]


@pytest.fixture
def small_disk() -> Iterator[None]:
    """No file may grow beyond 100 kB."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.usefixtures("small_disk")
def test_full_disk_names_the_file_and_keeps_what_was_finished(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="large") as failed:
        run_tasks(large, TASKS[:3], tmp_path, ONE)
    assert failed.value.errno == errno.EFBIG
    assert failed.value.filename.endswith(".parquet")
    assert len(list((tmp_path / "parts").iterdir())) == 2


def test_worker_with_other_code_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "code_version", lambda: "0123456789abcdef")
    with pytest.raises(CampaignError, match="other code"):
        run_tasks(square, TASKS, tmp_path, TWO)


def test_key_depends_on_task_and_work_and_not_on_order() -> None:
    assert task_key("work", {"a": 1, "b": 2}) == task_key("work", {"b": 2, "a": 1})
    assert len({task_key("work", {"a": 1}), task_key("work", {"a": 2}), task_key("other", {"a": 1})}) == 3


def test_code_that_is_left_out_of_the_version_takes_no_part_in_a_drive() -> None:
    code = "import sys, testbed.campaign.drive_row; print('\\n'.join(m for m in sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split()
    paths = [name.replace(".", "/") + "/" for name in loaded if name.startswith(("testbed", "estimators"))]
    assert [path for path in paths if path.startswith(AFTERWARDS)] == []
    assert all(list(ROOT.glob(f"{name.rstrip('/')}*")) for name in AFTERWARDS)
    assert len(code_version()) == 16


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"backend": "cluster"}, "unknown backend 'cluster'; valid: processes, dask, ray"),
        ({"jobs": 0}, "0 jobs; valid: a whole number of 1 or more"),
        ({"backend": "dask"}, "backend dask needs the address of its cluster"),
        ({"address": "tcp://here:1"}, "belongs to a cluster"),
    ],
)
def test_pool_refuses_what_is_not_valid(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Pool(**arguments)


def test_backend_that_is_not_installed_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("testbed.campaign.pool.find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r"backend ray is not installed; pip install 'vehicle-testbed\[ray\]'"):
        Pool(backend="ray", address="auto")


def test_scheduler_that_cannot_be_reached_is_told_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("testbed.campaign.pool.TIMEOUT", 0.5)
    with pytest.raises(ValueError, match=r"no Dask scheduler at tcp://127\.0\.0\.1:9"):
        run_tasks(square, TASKS, tmp_path, Pool(backend="dask", address="tcp://127.0.0.1:9"))


def test_table_with_columns_that_rows_lack_is_whole(tmp_path: Path) -> None:
    import pyarrow.parquet as pq

    write_table(tmp_path / "t.parquet", [{"a": 1, "s": [1.0, 2.0]}, {"a": 2, "error": "bad"}])
    assert pq.read_table(tmp_path / "t.parquet").to_pylist() == [
        {"a": 1, "s": [1.0, 2.0], "error": None},
        {"a": 2, "s": None, "error": "bad"},
    ]
    assert [p.name for p in tmp_path.iterdir()] == ["t.parquet"]
