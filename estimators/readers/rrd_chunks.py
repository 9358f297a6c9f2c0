"""Signals as Rerun chunks and back, to the last bit.

A signal `a/b` is the entity `/a/b`: one row a sample on the duration timeline `time` [ns, exact], its numbers in the
component `Scalars:scalars` (float64, k to a row), its text in `TextLog:text` and again in `StateChange:state` so that
the viewer can draw it as a lane. A static row beside it holds the name, unit, frame and kind (`Signal:...`); an entity
without that row is not a signal. The recorded order is the order of row ids, which Rerun hands out ascending.

Chunks are built through Rerun's column protocols from arrow arrays, a fifth of the time its archetype classes take.
Left out: signals whose times lie beyond 26 days, where a nanosecond grid in float64 no longer comes back exactly.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
from numpy.typing import NDArray
from rerun.chunk import Chunk

TIMELINE = "time"
NOTES = "notes"
_NOTES_ENTITY = f"/__properties/{NOTES}"
_LONGEST_NS = 2**51  # [ns], 26 days: below it seconds -> ns -> seconds is exact in float64
_TEXT_TYPE = "rerun.components.Text"
SCALARS = rr.Scalars.descriptor_scalars()
_TEXT = rr.TextLog.descriptor_text()
_STATE = rr.StateChange.descriptor_state()
_META = {
    part: rr.ComponentDescriptor(f"Signal:{part}", archetype="Signal", component_type=_TEXT_TYPE)
    for part in ("name", "unit", "frame", "kind")
}
_JSON = rr.ComponentDescriptor("Notes:json", archetype="Notes", component_type=_TEXT_TYPE)


@dataclass(frozen=True)
class Column:
    """One component's values, offsets[i]:offsets[i+1] of them in row i (rerun's ComponentColumn protocol)."""

    descriptor: Any
    values: pa.Array
    offsets: pa.Array

    def component_descriptor(self) -> Any:
        return self.descriptor

    def as_arrow_array(self) -> pa.Array:
        return pa.ListArray.from_arrays(self.offsets, self.values)


@dataclass(frozen=True)
class Clock:
    """The rows' times [ns], int64 (rerun's TimeColumnLike protocol)."""

    nanoseconds: NDArray[np.int64]

    def timeline_name(self) -> str:
        return TIMELINE

    def as_arrow_array(self) -> pa.Array:
        return pa.Array.from_buffers(
            pa.duration("ns"), len(self.nanoseconds), [None, pa.py_buffer(np.ascontiguousarray(self.nanoseconds))]
        )


@lru_cache(maxsize=64)
def offsets(rows: int, width: int) -> pa.Array:
    """Where each of `rows` rows of `width` values starts, and the end; int32."""
    return pa.array(np.arange(rows + 1, dtype=np.int32) * np.int32(width))


def column(descriptor: Any, values: NDArray[Any] | pa.Array, rows: int, width: int) -> Column:
    """A column with the same number of values in every row; values is flat, length rows * width."""
    return Column(descriptor, values if isinstance(values, pa.Array) else pa.array(values), offsets(rows, width))


def nanoseconds(time: NDArray[np.float64], name: str) -> NDArray[np.int64]:
    """Seconds as whole nanoseconds, shape kept. Raises ValueError on times that are not finite or beyond 26 days."""
    ticks = np.rint(np.asarray(time, dtype=np.float64) * 1e9)
    if ticks.size and not (ticks.min() > -_LONGEST_NS and ticks.max() < _LONGEST_NS):  # false of NaN too
        worst = np.asarray(time)[~(np.abs(ticks) < _LONGEST_NS)][0]
        limit = _LONGEST_NS / 1e9
        raise ValueError(f"{name}: time {worst:g} s is outside +-{limit:.0f} s, count from the start of the drive")
    return ticks.astype(np.int64)


def entity_path(name: str) -> str:
    """A signal's name as an escaped entity path. Raises ValueError on an empty part or one that Rerun reserves."""
    parts = name.split("/")
    if not all(parts) or name.startswith("__"):
        raise ValueError(f"signal name {name!r}: want parts joined by single slashes, such as wheel/fl/speed")
    return str(rr.new_entity_path(parts))


def kind_of(value: NDArray[Any]) -> str:
    """`text`, `scalar` or `vector k`."""
    if value.dtype == object:
        return "text"
    return "scalar" if value.ndim == 1 else f"vector {value.shape[1]}"


def static_chunk(entity: str, columns: Iterable[Any]) -> Chunk:
    """One timeless row at an entity."""
    return Chunk.from_columns(entity, [], columns)


def archetype_chunk(entity: str, archetype: Any) -> Chunk:
    """A Rerun archetype as one timeless row."""
    batches = archetype.as_component_batches()
    arrays = [(b.component_descriptor(), b.as_arrow_array()) for b in batches]
    return static_chunk(entity, [column(descriptor, array, 1, len(array)) for descriptor, array in arrays])


def signal_meta(name: str, unit: str, frame: str, kind: str) -> Chunk:
    """The static row that makes an entity a signal."""
    texts = {"name": name, "unit": unit, "frame": frame, "kind": kind}
    return static_chunk(
        entity_path(name), [column(_META[part], pa.array([text]), 1, 1) for part, text in texts.items()]
    )


def signal_chunk(name: str, ticks: NDArray[np.int64], value: NDArray[Any]) -> Chunk:
    """Samples of a signal: ticks [ns] (n,), value (n,) or (n, k) float64 or (n,) str. Neither may change later."""
    rows = len(ticks)
    if value.dtype == object:
        text = pa.array(value.tolist(), pa.string())
        columns = [column(_TEXT, text, rows, 1), column(_STATE, text, rows, 1)]
    else:
        width = 1 if value.ndim == 1 else value.shape[1]
        columns = [column(SCALARS, np.ascontiguousarray(value).reshape(-1), rows, width)]
    return rows_chunk(entity_path(name), ticks, columns)


def rows_chunk(entity: str, ticks: NDArray[np.int64], columns: Iterable[Any]) -> Chunk:
    """Rows in the order given. Rerun sorts a new chunk by time: one with late rows gets its times afterwards."""
    late = bool((ticks[1:] < ticks[:-1]).any())
    chunk = Chunk.from_columns(entity, [Clock(np.arange(len(ticks)) if late else ticks)], columns)
    if not late:
        return chunk
    batch = chunk.to_record_batch()
    index = batch.schema.get_field_index(TIMELINE)
    kept = {key: text for key, text in batch.schema.field(index).metadata.items() if key != b"rerun:is_sorted"}
    field = batch.schema.field(index).with_metadata(kept)
    (unsorted,) = Chunk.from_record_batch(batch.set_column(index, field, Clock(ticks).as_arrow_array()))
    return unsorted


def notes_chunk(notes: Mapping[str, Any]) -> Chunk:
    """The log's notes as JSON in a recording property. Raises ValueError on what JSON cannot hold."""
    try:
        text = json.dumps(dict(notes), ensure_ascii=False)
    except TypeError as error:
        raise ValueError(f"notes hold something that is not a JSON value: {error}") from None
    return static_chunk(_NOTES_ENTITY, [column(_JSON, pa.array([text]), 1, 1)])


def read_notes(batch: pa.RecordBatch) -> dict[str, Any] | None:
    """Notes in a chunk's record batch, None if it holds none."""
    if "Notes:json" not in batch.schema.names:
        return None
    return dict(json.loads(batch.column("Notes:json")[0].as_py()[0]))


def read_meta(batch: pa.RecordBatch) -> dict[str, str] | None:
    """Name, unit, frame and kind in a chunk's record batch, None if it holds none."""
    if "Signal:name" not in batch.schema.names:
        return None
    return {part: batch.column(f"Signal:{part}")[0].as_py()[0] for part in _META}


def row_ids(batch: pa.RecordBatch) -> NDArray[np.uint64]:
    """Row ids as (n, 2) unsigned words, ascending in recorded order."""
    ids = batch.column("rerun.controls.RowId")
    raw = np.frombuffer(ids.buffers()[1], dtype=">u8").reshape(-1, 2)
    return raw[ids.offset : ids.offset + len(ids)].astype(np.uint64)


def read_rows(batch: pa.RecordBatch, kind: str) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Times [s] (n,) and values (n,) or (n, k) of a chunk of a signal, in row order."""
    time = batch.column(TIMELINE).cast(pa.int64()).to_numpy(zero_copy_only=False) / 1e9
    if kind == "text":
        texts = batch.column("TextLog:text").flatten().to_pylist()
        return time, np.array(texts, dtype=object)
    flat = batch.column("Scalars:scalars").flatten().to_numpy(zero_copy_only=False)
    return time, flat if kind == "scalar" else flat.reshape(len(time), int(kind.split()[1]))
