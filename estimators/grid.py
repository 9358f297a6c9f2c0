"""Signals on one common clock: averages over equal cells of time, computed the same however the stream is cut.

Each scalar channel is (signal, column). A cell's value is the mean of its finite samples, moved from their mean time to
the cell's centre along their own least-squares slope, so that channels sampled at other moments compare at the same
instant. A cell closes `LATENCY` after its end; refused, missing and non-finite samples are flagged, at most once in 10
s per cause. Left out: interpolation; a cell without a sample is NaN.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.arrival import Intake
from estimators.drive_log import Signal
from estimators.estimator import Flag

LATENCY = 0.2  # [s] that a sample may be handed over after its stamp
SILENCE = 1.0  # [s] without a usable sample that is worth a flag
REPEAT = 10.0  # [s] before the same flag is raised again
_NANO = 1_000_000_000


@dataclass(frozen=True)
class Channel:
    """One scalar of a signal: column of an (n, k) value, None for an (n,) value. frozen_after: time [s] after which an
    unchanged value other than zero is a stuck sensor's and refused."""

    signal: str
    column: int | None = None
    frozen_after: float = np.inf


@dataclass(frozen=True)
class Cells:
    """Closed cells that hold at least one sample: index (time / step), centre [s], value (n, channels), NaN where
    missing.
    """

    index: NDArray[np.int64]
    centre: NDArray[np.float64]
    value: NDArray[np.float64]


class Grid:
    """Collects samples and gives cells of `step` [s] once they are complete."""

    def __init__(self, channels: tuple[Channel, ...], step: float) -> None:
        self._channels = channels
        self._step = round(step * _NANO)
        self._intake = {channel.signal: Intake() for channel in channels}
        self._waiting: list[tuple[NDArray, NDArray]] = [(np.empty(0), np.empty(0)) for _ in channels]
        self._seen: list[float | None] = [None] * len(channels)
        self._run = [(np.nan, 0.0)] * len(channels)  # value and beginning of the run that the last sample is in
        self._silent = [False] * len(channels)
        self._closed = -(1 << 62)  # first cell that is still open
        self._raised: dict[str, float] = {}

    def add(self, samples: Mapping[str, Signal]) -> list[Flag]:
        """Take samples as they arrived; flags for the refused ones."""
        complaints: list[tuple[float, str]] = []
        for name in self._intake:
            if name not in samples:
                continue
            signal = samples[name]
            good, refused = self._intake[name].accept(signal.time)
            complaints += [(time, f"{name}: {why}, sample refused") for time, why in refused]
            for i, channel in enumerate(self._channels):
                if channel.signal == name:
                    complaints += self._store(i, channel, signal, good)
        return self._flags(complaints)

    def _store(self, i: int, channel: Channel, signal: Signal, good: NDArray[np.bool_]) -> list[tuple[float, str]]:
        """Keep the usable samples of one channel."""
        values, want = signal.value, 1 if channel.column is None else 2
        if (
            values.dtype.kind != "f"
            or values.ndim != want
            or (values.ndim == 2 and values.shape[1] <= (channel.column or 0))
        ):
            shape = "text" if values.dtype.kind != "f" else f"of shape {values.shape}"
            wanted = "(n,)" if channel.column is None else "(n, 3)"
            return [
                (float(t), f"{channel.signal}: value is {shape}, want {wanted}, not used") for t in signal.time[good]
            ]
        column = values if channel.column is None else values[:, channel.column]
        finite = np.isfinite(column)
        complaints = [(float(t), f"{channel.signal}: not a finite number") for t in signal.time[good & ~finite]]
        kept = good & finite
        frozen = self._frozen(i, channel, signal.time[kept], column[kept])
        if frozen.any():
            stuck = f"{channel.signal}: unchanged for {channel.frozen_after:g} s, taken for stuck"
            complaints += [(float(t), stuck) for t in signal.time[kept][frozen]]
            kept[np.flatnonzero(kept)[frozen]] = False
        time, value = self._waiting[i]
        self._waiting[i] = (np.concatenate([time, signal.time[kept]]), np.concatenate([value, column[kept]]))
        return complaints

    def _frozen(self, i: int, channel: Channel, time: NDArray, value: NDArray) -> NDArray[np.bool_]:
        """Which samples repeat a value other than zero for too long; remembers the run that the last one is in."""
        if not len(value) or np.isinf(channel.frozen_after):
            return np.zeros(len(value), dtype=bool)
        last, since = self._run[i]
        begins = np.concatenate([[value[0] != last], np.diff(value) != 0.0])
        start = np.maximum.accumulate(np.where(begins, time, -np.inf))
        start = np.where(np.isneginf(start), since, start)
        self._run[i] = (float(value[-1]), float(start[-1]))
        return (time - start > channel.frozen_after) & (value != 0.0)

    def close(self, until: float) -> tuple[Cells, list[Flag]]:
        """All cells that are complete at the clock `until` [s], in time order."""
        end = int(np.floor((until - LATENCY) * _NANO / self._step + 1e-6))  # first cell that stays open
        parts, complaints, first = [], [], None
        for i in range(len(self._channels)):
            time, value = self._waiting[i]
            cell = np.rint(time * _NANO).astype(np.int64) // self._step
            done = cell < end
            self._waiting[i] = (time[~done], value[~done])
            ready = done & (cell >= self._closed)
            if (done & ~ready).any():
                complaints.append((float(time[done & ~ready][0]), f"{self._channels[i].signal}: handed over too late"))
            parts.append((time[ready], value[ready], cell[ready]))
            if ready.any():
                first = min(float(time[ready][0]), np.inf if first is None else first)
        self._closed = max(self._closed, end)
        for i, (time, _, _) in enumerate(parts):
            complaints += self._gaps(i, time, first, end * self._step / _NANO)
        return self._average(parts), self._flags(complaints)

    def _gaps(self, i: int, time: NDArray, first: float | None, clock: float) -> list[tuple[float, str]]:
        """Silences of a channel, each reported once at the moment it became one."""
        if self._seen[i] is None:
            if first is None:
                return []
            self._seen = [first if seen is None else seen for seen in self._seen]
        marks = np.concatenate([[self._seen[i]], time])
        starts = marks[:-1][np.diff(marks) > SILENCE].tolist()
        if self._silent[i] and starts and starts[0] == self._seen[i]:
            starts = starts[1:]
        if len(time):
            self._silent[i] = False
        if clock - marks[-1] > SILENCE and not self._silent[i]:
            self._silent[i] = True
            starts.append(marks[-1])
        self._seen[i] = float(marks[-1])
        return [(t + SILENCE, f"{self._channels[i].signal}: no usable sample for {SILENCE:g} s") for t in starts]

    def _average(self, parts: list[tuple[NDArray, NDArray, NDArray]]) -> Cells:
        index = np.unique(np.concatenate([cell for _, _, cell in parts]))
        out = np.full((len(index), len(parts)), np.nan)
        centre = (index + 0.5) * (self._step / _NANO)
        for i, (time, value, cell) in enumerate(parts):
            if len(cell):
                out[:, i] = _cell_values(time, value, np.searchsorted(index, cell), centre)
        return Cells(index, centre, out)

    def _flags(self, complaints: list[tuple[float, str]]) -> list[Flag]:
        """Complaints in time order, the same text at most once in `REPEAT` seconds."""
        flags = []
        for time, text in sorted(complaints):
            if time - self._raised.get(text, -np.inf) >= REPEAT:
                self._raised[text] = time
                flags.append(Flag(time, text))
        return flags


def _cell_values(time: NDArray, value: NDArray, place: NDArray, centre: NDArray) -> NDArray[np.float64]:
    """Mean of each cell at its centre. `place`: row of each sample. Sums run in sample order, so they are
    reproducible.
    """
    cells = len(centre)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        count = np.bincount(place, minlength=cells).astype(np.float64)
        ahead = time - centre[place]
        mean_time = np.bincount(place, ahead, cells) / count
        mean = np.bincount(place, value, cells) / count
        spread = np.bincount(place, (ahead - mean_time[place]) ** 2, cells)
        slope = np.bincount(place, (ahead - mean_time[place]) * (value - mean[place]), cells)
        slope = np.where((count > 2) & (spread > 0.0), slope / spread, 0.0)
        at_centre = mean - slope * mean_time
    return np.where(np.isfinite(at_centre), at_centre, np.nan)
