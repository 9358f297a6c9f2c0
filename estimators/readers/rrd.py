"""Recordings as drive logs: `read_rrd` and `save_log`, each the other's inverse to the last bit.

A finished recording has a footer. One that a killed drive left (`NAME.part.rrd`) has none and may end inside a message:
it is read to its last whole message. A file under its final name that has no footer has lost its end, and is refused.
"""

from __future__ import annotations

import tempfile
import warnings
from collections import defaultdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from rerun.chunk import Chunk, RrdReader

from estimators.drive_log import DriveLog, Signal
from estimators.readers.rrd_chunks import (
    kind_of,
    nanoseconds,
    notes_chunk,
    read_meta,
    read_notes,
    read_rows,
    row_ids,
    signal_chunk,
    signal_meta,
)
from estimators.readers.rrd_file import RrdFile
from estimators.readers.rrd_frames import whole_length

_ROWS = 8192  # of one chunk in a saved log


def read_rrd(path: str | Path) -> DriveLog:
    """All signals and notes of a recording; whatever else it shows (bodies, road) is not in a log.

    Raises ValueError with one line and the path on a file that is no recording, holds no signal, or is cut short.
    """
    path = Path(path)
    try:
        whole, finished = whole_length(path)
    except OSError as error:
        raise ValueError(f"{path}: cannot read: {error.strerror}") from None
    if not finished and ".part" not in path.suffixes:
        cure = path.with_suffix(".part.rrd").name
        raise ValueError(f"{path}: the recording is cut short (no footer); rename it {cure} to read what is left of it")
    try:
        if finished:
            return _log_of(_chunks(path), path)
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "whole.rrd"
            with path.open("rb") as torn:
                copy.write_bytes(torn.read(whole))
            return _log_of(_chunks(copy), path)
    except (RuntimeError, pa.ArrowException) as error:
        reason = str(error).splitlines()[0]
        raise ValueError(f"{path}: damaged recording (.rrd): {reason}") from None


def _chunks(path: Path) -> list[Chunk]:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="RRD file has no footer")
        return list(RrdReader(path).stream().to_chunks())


def _log_of(chunks: list[Chunk], path: Path) -> DriveLog:
    notes: dict[str, Any] | None = None
    metas: dict[str, dict[str, str]] = {}
    rows: dict[str, list[pa.RecordBatch]] = defaultdict(list)
    for chunk in chunks:
        batch = chunk.to_record_batch()
        if not chunk.is_static:
            rows[chunk.entity_path].append(batch)
        elif (found := read_notes(batch)) is not None:
            notes = found
        elif (meta := read_meta(batch)) is not None:
            metas[chunk.entity_path] = meta
    if not metas and notes is None:
        raise ValueError(f"{path}: a Rerun recording, but not of a drive: it holds no signals")
    return DriveLog({meta["name"]: _signal(rows[entity], meta) for entity, meta in metas.items()}, notes or {})


def _signal(batches: list[pa.RecordBatch], meta: dict[str, str]) -> Signal:
    kind, unit, frame = meta["kind"], meta["unit"], meta["frame"]
    if not batches:
        empty = np.empty((0,) if not kind.startswith("vector") else (0, int(kind.split()[1])))
        return Signal([], empty.astype(object) if kind == "text" else empty, unit, frame)
    ids = np.concatenate([row_ids(batch) for batch in batches])
    parts = [read_rows(batch, kind) for batch in batches]
    time, value = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.lexsort((ids[:, 1], ids[:, 0]))
    return Signal(time[order], value[order], unit, frame)


def save_log(log: DriveLog, path: str | Path) -> None:
    """Write a log to an .rrd file; `read_rrd` gives the same log back. Raises RecordingError on a failed write."""
    notes = notes_chunk(log.notes)
    ticks = {name: nanoseconds(signal.time, name) for name, signal in log.items()}
    metas = [signal_meta(name, s.unit, s.frame, kind_of(s.value)) for name, s in log.items()]
    file = RrdFile(path)
    try:
        for chunk in (notes, *metas):
            file.send(partial(_itself, chunk))
        for name, signal in log.items():
            for start in range(0, len(signal), _ROWS):
                piece = slice(start, start + _ROWS)
                file.send(partial(signal_chunk, name, ticks[name][piece], signal.value[piece]))
    except BaseException:
        file.abort()
        raise
    file.close()


def _itself(chunk: Chunk) -> Chunk:
    return chunk
