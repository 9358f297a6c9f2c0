"""`RecordingWriter`: a drive's .rrd, written while it drives; its log file, lossless, and the picture of it.

Signals (`add`, `text`) come back from `estimators.readers.read_log` to the last bit. Poses, bodies, road and the bands
of one standard deviation are there for the eye only and no part of the log. While the drive runs the file is
`NAME.part.rrd`; `close()` adds the layout and gives it its final name. A killed process leaves the `.part.rrd`, which
the viewer opens and `read_log` reads to the last second sent; `abort()`, or an exception inside `with`, leaves the
same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
from numpy.typing import ArrayLike, NDArray
from rerun.chunk import Chunk

from estimators.drive_log import HIDDEN
from estimators.readers.rrd_chunks import (
    archetype_chunk,
    column,
    entity_path,
    kind_of,
    nanoseconds,
    notes_chunk,
    rows_chunk,
    signal_chunk,
    signal_meta,
)
from estimators.readers.rrd_file import RecordingError, RrdFile
from testbed.recording.blueprint import drive_layout
from testbed.recording.series import ACCUSED, RED, band, lines, red, share_of
from testbed.recording.stack import Stacks

__all__ = ["RecordingError", "RecordingWriter"]

BAND = "/band"  # an estimate's band is drawn at the estimate's entity + this
_BAND_ROWS = 25  # of a band per chunk at most: it is for the eye
_TRANSLATION = rr.Transform3D.descriptor_translation()
_QUATERNION = rr.Transform3D.descriptor_quaternion()
_VALUES = rr.Measurements.descriptor_values()
_VARIANCES = rr.Measurements.descriptor_variances()


class RecordingWriter:
    """Writes one drive. Every method copies what it is given, and raises RecordingError once the disk has failed."""

    def __init__(self, path: str | Path, notes: Mapping[str, Any]) -> None:
        """path: ends in .rrd. notes: JSON values. Raises ValueError or RecordingError with one line."""
        first = notes_chunk(notes)
        self._file = RrdFile(path)
        self._kinds: dict[str, tuple[str, str, str]] = {}  # name -> unit, frame, kind
        self._estimates: dict[
            str, tuple[NDArray[np.int64], NDArray[Any]]
        ] = {}  # est/... chunks that await their partner
        self._reach: dict[str, tuple[float, float]] = {}  # of each truth: lowest, highest
        self._drawn: set[str] = set()  # entities that show something in 3-D
        self._starts: dict[str, tuple[float, float, float]] = {}  # bodies that move, and where they are at first
        self._bands: dict[str, list[tuple[float, float]]] = {}  # estimate -> low and high end of each chunk's band
        self._accused: dict[str, str] = {}  # what is drawn red -> unit
        self._stacks = Stacks()
        self._file.send(lambda: first)

    @property
    def path(self) -> Path:
        """Where the finished recording will be."""
        return self._file.path

    @property
    def part(self) -> Path:
        """Where the recording is until then."""
        return self._file.part

    def add(self, name: str, time: ArrayLike, value: ArrayLike, unit: str, frame: str = "") -> None:
        """The next samples of a signal: time [s] (n,), value (n,) or (n, k) in `unit`, in recorded order."""
        ticks = nanoseconds(np.array(time, dtype=np.float64).reshape(-1), name)
        values = np.array(value)
        values = values.astype(object if values.dtype.kind in "UO" else np.float64, copy=False)
        if values.ndim not in (1, 2) or len(values) != len(ticks):
            raise ValueError(
                f"{name}: value has shape {values.shape}, want ({len(ticks)},) or ({len(ticks)}, k) as time"
            )
        kind = (unit, frame, kind_of(values))
        if name not in self._kinds:
            self._introduce(name, *kind)
        if self._kinds[name] != kind:
            raise ValueError(f"{name}: unit, frame and kind were {self._kinds[name]}, now {kind}")
        if len(ticks):
            self._file.send(partial(signal_chunk, name, ticks, values))
            if name.startswith("est/"):
                self._pair(name, ticks, values)
            elif name.startswith(HIDDEN) and values.dtype != object:
                low, high = self._reach.get(name, (np.inf, -np.inf))
                self._reach[name] = (min(low, float(values.min())), max(high, float(values.max())))

    def text(self, name: str, time: ArrayLike, strings: Sequence[str]) -> None:
        """Events such as alarms: time [s] (n,), n strings. An empty string ends the state that the last one began."""
        self.add(name, time, np.array(list(strings), dtype=object), "")

    def accused(self, name: str, time: ArrayLike, value: ArrayLike, unit: str) -> None:
        """Samples of a sensor that is accused, for the eye only: a broad red line under the signal's own. name: of the
        signal, of one axis with the axis. time [s] (n,), value (n,) or (n, k)."""
        ticks = nanoseconds(np.array(time, dtype=np.float64).reshape(-1), name)
        values = np.array(value, dtype=np.float64)
        if name not in self._accused:
            self._accused[name] = unit
            style = red(1 if values.ndim == 1 else values.shape[1])
            self._file.send(partial(archetype_chunk, entity_path(name + ACCUSED), style))
        if len(ticks):
            self._file.send(partial(signal_chunk, name + ACCUSED, ticks, values))

    def pose(self, entity: str, time: ArrayLike, position: ArrayLike, quaternion_wxyz: ArrayLike) -> None:
        """A body's poses in the world: time [s] (n,), position (n, 3) [m], unit quaternion (n, 4) in MuJoCo's order."""
        ticks = nanoseconds(np.array(time, dtype=np.float64).reshape(-1), entity)
        places = np.array(position, dtype=np.float32)
        turns = np.array(quaternion_wxyz, dtype=np.float32)
        if places.shape != (len(ticks), 3) or turns.shape != (len(ticks), 4):
            shapes = f"position {places.shape} and quaternion {turns.shape}"
            raise ValueError(f"{entity}: {shapes}, want ({len(ticks)}, 3) and ({len(ticks)}, 4)")
        if len(ticks):
            self._starts.setdefault(entity, (float(places[0, 0]), float(places[0, 1]), float(places[0, 2])))
            self._file.send(partial(_pose_chunk, entity_path(entity), ticks, places, turns[:, [1, 2, 3, 0]]))

    def show(self, entity: str, archetype: Any) -> None:
        """A Rerun archetype that stays for the whole drive, e.g. a body's shape. It must not change later.

        archetype: it, or a function without arguments that makes it, called in the writer's thread.
        """
        self._drawn.add(entity)
        path = entity_path(entity)
        self._file.send(lambda: archetype_chunk(path, archetype() if callable(archetype) else archetype))

    def close(self) -> None:
        """Finish the file with its layout under its final name. Raises RecordingError if that fails."""
        for stacked in self._stacks.rest():
            self._draw_band(*stacked)
        kinds = {name: (unit, kind) for name, (unit, _, kind) in self._kinds.items()}
        bands = {name: _usual(np.array(ends)) for name, ends in self._bands.items() if ends}
        kinds |= {name + ACCUSED: (unit, RED) for name, unit in self._accused.items()}
        self._file.close(drive_layout(kinds, bands, self._reach, self._drawn, self._starts))

    def abort(self) -> None:
        """Finish without the final name: what was recorded stays in `part`."""
        self._file.abort()

    def __enter__(self) -> RecordingWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.close()
        else:
            self.abort()

    def _introduce(self, name: str, unit: str, frame: str, kind: str) -> None:
        entity = entity_path(name)  # refuses a bad name before anything is kept
        self._kinds[name] = (unit, frame, kind)
        self._file.send(partial(signal_meta, name, unit, frame, kind))
        if kind != "text":
            self._file.send(partial(archetype_chunk, entity, lines(name, unit, _width(kind))))

    def _pair(self, name: str, ticks: NDArray[np.int64], values: NDArray[Any]) -> None:
        """Draws an estimate's band once the estimate and its `/std` have come for the same times."""
        base = name.removesuffix("/std")
        self._estimates[name] = (ticks, values)
        if base not in self._estimates or f"{base}/std" not in self._estimates:
            return
        (ticks, mean), (other, deviation) = self._estimates.pop(base), self._estimates.pop(f"{base}/std")
        if not np.array_equal(ticks, other) or mean.shape != deviation.shape or mean.dtype == object:
            return
        if share_of(base) is None:
            self._draw_band(base, ticks, mean, deviation)
        else:
            for stacked in self._stacks.add(base, ticks, mean):
                self._draw_band(*stacked)

    def _draw_band(self, base: str, ticks: NDArray[np.int64], mean: NDArray[Any], deviation: NDArray[Any]) -> None:
        """mean and half the width of what is drawn at an estimate's band."""
        if base not in self._bands:
            self._bands[base] = []
            unit, _, kind = self._kinds[base]
            self._file.send(partial(archetype_chunk, entity_path(base + BAND), band(base, unit, _width(kind))))
        low, high = mean - deviation, mean + deviation
        if (sure := np.isfinite(low) & np.isfinite(high)).any():
            self._bands[base].append((float(low[sure].min()), float(high[sure].max())))
        kept = slice(None, None, -(-len(ticks) // _BAND_ROWS))
        self._file.send(partial(_band_chunk, entity_path(base + BAND), ticks[kept], mean[kept], deviation[kept] ** 2))


def _usual(ends: NDArray[np.float64]) -> tuple[float, float]:
    """Where a band is worth looking: its median and its last place together; ends: low, high by chunk, shape (n, 2)."""
    shown = np.stack([np.median(ends, axis=0), ends[-1]])
    return float(shown[:, 0].min()), float(shown[:, 1].max())


def _width(kind: str) -> int:
    return int(kind.split()[1]) if kind.startswith("vector") else 1


def _pose_chunk(entity: str, ticks: NDArray[np.int64], places: NDArray[Any], turns: NDArray[Any]) -> Chunk:
    """places (n, 3), turns (n, 4) as x, y, z, w; float32."""
    places_column = pa.FixedSizeListArray.from_arrays(pa.array(places.reshape(-1)), 3)
    turns_column = pa.FixedSizeListArray.from_arrays(pa.array(np.ascontiguousarray(turns).reshape(-1)), 4)
    rows = len(ticks)
    columns = [column(_TRANSLATION, places_column, rows, 1), column(_QUATERNION, turns_column, rows, 1)]
    return rows_chunk(entity, ticks, columns)


def _band_chunk(entity: str, ticks: NDArray[np.int64], mean: NDArray[Any], variance: NDArray[Any]) -> Chunk:
    rows = len(ticks)
    width = 1 if mean.ndim == 1 else mean.shape[1]
    values = [np.ascontiguousarray(part).reshape(-1) for part in (mean, variance)]
    columns = [column(d, v, rows, width) for d, v in zip((_VALUES, _VARIANCES), values, strict=True)]
    return rows_chunk(entity, ticks, columns)
