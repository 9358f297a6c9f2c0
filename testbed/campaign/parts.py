"""Finished tasks on disk: one Parquet part a task, named by a digest of the code, the work and the task.

A part appears under its name whole or not at all, so a killed campaign keeps what was finished. A part that was cut
short by something else is named in one line and its task is done again.
"""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from estimators.whole_file import write_whole
from testbed.campaign.code_version import code_version

Row = dict[str, Any]


def task_key(work: str, task: Mapping[str, Any]) -> str:
    """Digest of the code, the work's name and the task (JSON values): what a finished part is found by."""
    text = json.dumps([code_version(), work, task], sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:24]


class Parts:
    """The folder `FOLDER/parts`. OSError where it cannot be made or written."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "parts"
        self.folder.mkdir(parents=True, exist_ok=True)

    def path(self, key: str) -> Path:
        return self.folder / f"{key}.parquet"

    def read(self, keys: Iterable[str]) -> tuple[dict[str, Row], list[str]]:
        """Rows of those of the keys that are finished, and a line for each part that cannot be read."""
        rows: dict[str, Row] = {}
        damaged = []
        for key in keys:
            path = self.path(key)
            if not path.is_file():
                continue
            try:
                (rows[key],) = pq.read_table(path).to_pylist()
            except (pa.ArrowException, OSError, ValueError) as error:
                why = str(error).split("\n", 1)[0].removesuffix(".")
                damaged.append(f"{path}: not a whole part ({why}); its drive is done again")
        return rows, damaged

    def write(self, key: str, row: Row) -> None:
        """Keeps a finished row."""
        write_table(self.path(key), [row])


def write_table(path: Path, rows: Sequence[Row]) -> None:
    """Rows as Parquet (a column that a row lacks is null there), whole or not at all. OSError names the file."""
    columns = dict.fromkeys(name for row in rows for name in row)
    table = pa.table({name: pa.array([row.get(name) for row in rows]) for name in columns})
    sink = io.BytesIO()
    pq.write_table(table, sink)
    write_whole(path, sink.getvalue())
