"""The recording of a drive: its signals, the car's poses, and the road piece by piece as the car comes to it.

The road is drawn for the eye in pieces of PIECE metres along the car's way, from the window that the tyres read: a
piece holds the square of road around the car when it has moved on by that much.

All of it happens in a thread of its own, behind the drive: it works while the compiled loop, which leaves the
interpreter free, computes on. Stretches are written together, BATCH steps at a time, since a chunk costs by its number
more than by its size; that many steps take a tenth of a second, and a killed drive loses no more. Of signals that come
once a second or so (estimates, direct tyre pressure) it loses up to SPARSE samples; alarms never wait.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import Signal
from testbed.recording import RecordingWriter
from testbed.recording.road import road_piece
from testbed.recording.scene import Scene
from testbed.simulation import Simulation, Stretch
from testbed.truth import change_signals, truth_signals

PIECE = 20.0  # m of road a piece, along the car's way
MARGIN = 5.0  # m of road drawn to the sides of the car's way
STEP = 0.1  # m between the drawn nodes
BATCH = 4000  # steps written together, at least
SPARSE = 12  # samples of a slow signal that wait for one another
NOBODY: Mapping[str, Signal] = {}
AHEAD = 3  # stretches that the drive may be ahead of its recording: bounds memory


class DriveRecording:
    """Writes one drive to `path`; see `RecordingWriter` for what is left when a drive does not finish."""

    def __init__(self, path: Path, simulation: Simulation, notes: Mapping[str, Any]) -> None:
        self._simulation = simulation
        self._writer = RecordingWriter(path, notes)
        self._scene = Scene(self._writer, simulation.model)
        self._thread = ThreadPoolExecutor(1, thread_name_prefix=f"recording {path.name}")
        self._pending: deque[Future[None]] = deque()
        self._waiting: dict[str, list[Signal]] = {}
        self._poses: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
        self._steps = 0
        self._pieces = 0
        self._drawn_to = np.array(simulation.data.qpos[:2])
        self._draw_road(self._drawn_to - [1.5 * PIECE, 0.0], self._drawn_to)

    def add(self, signals: Mapping[str, Signal], stretch: Stretch, accused: Mapping[str, Signal] = NOBODY) -> None:
        """A stretch: what was sensed and estimated, and the trace, which holds the truth and where the car was;
        accused: samples to be drawn red.

        Raises RecordingError (here or in a later call) once the disk has failed.
        """
        self._pending.append(self._thread.submit(self._record, signals, stretch, accused))
        while len(self._pending) > AHEAD:
            self._pending.popleft().result()

    def _record(self, signals: Mapping[str, Signal], stretch: Stretch, accused: Mapping[str, Signal]) -> None:
        car = self._simulation
        truth = truth_signals(stretch, car.scenario.step, car.scenario.active_steering)
        truth |= change_signals(stretch, car.tyre.p0, car.nominal_radius)
        for name, signal in (*signals.items(), *truth.items()):
            self._waiting.setdefault(name, []).append(signal)
        for name, signal in accused.items():
            self._writer.accused(name, signal.time, signal.value, signal.unit)
        self._poses.append((stretch.pose_time, stretch.poses))
        self._steps += len(stretch.rows)
        for place in stretch["position"][:: max(len(stretch.rows) // 20, 1), :2]:
            self._reach(place)
        self._reach(stretch["position"][-1, :2])
        if self._steps >= BATCH:
            self._write()

    def _write(self, last: bool = False) -> None:
        """Writes what waits, slow signals only once there is enough of them, or at the last."""
        waiting, poses = self._waiting, self._poses
        self._waiting, self._poses, self._steps = {}, [], 0
        for name, parts in waiting.items():
            if not last and parts[0].value.dtype != object and sum(map(len, parts)) < SPARSE:
                self._waiting[name] = parts
                continue
            time, value = (np.concatenate([getattr(part, what) for part in parts]) for what in ("time", "value"))
            self._writer.add(name, time, value, parts[0].unit, parts[0].frame)
        if poses:
            time, placed = (np.concatenate(parts) for parts in zip(*poses, strict=True))
            self._scene.poses(time, placed[:, :, :3], placed[:, :, 3:])

    def _reach(self, place: np.ndarray) -> None:
        """Draws another piece of road once the car has come far enough."""
        if np.hypot(*(place - self._drawn_to)) >= PIECE:
            self._draw_road(self._drawn_to, place)
            self._drawn_to = np.array(place)

    def _draw_road(self, start: np.ndarray, end: np.ndarray) -> None:
        low, high = np.minimum(start, end), np.maximum(start, end)
        spread = np.where(high - low < 0.5 * PIECE, MARGIN, 0.5 * STEP)
        low, high = np.floor((low - spread) / STEP), np.ceil((high + spread) / STEP)
        x, y = (np.arange(low[i], high[i] + 1.0) * STEP for i in (0, 1))
        road_piece(self._writer, self._pieces, x, y, self._simulation.road.heights(x, y))
        self._pieces += 1

    def close(self) -> None:
        """Draws the last metres of road and gives the recording its final name. RecordingError where that fails."""
        try:
            while self._pending:
                self._pending.popleft().result()
            self._write(last=True)
            place = np.array(self._simulation.data.qpos[:2])
            self._draw_road(self._drawn_to, place + 0.75 * PIECE * self._heading())
        except BaseException:
            self.abort()
            raise
        self._thread.shutdown()
        self._writer.close()

    def abort(self) -> None:
        """Leaves what was recorded in the `.part.rrd`."""
        self._thread.shutdown()
        with suppress(OSError):  # a fault of the disk, while another is being told
            self._write(last=True)
        self._writer.abort()

    def _heading(self) -> np.ndarray:
        matrix = self._simulation.data.xmat[self._simulation.index.chassis]
        return np.array([matrix[0], matrix[3]])
