"""An .rrd file as it is written: a bounded queue, one thread that encodes and writes, and faults that come out.

The file is `NAME.part.rrd` while it grows, a name that the viewer opens, and becomes `NAME.rrd` in one step when it is
finished. A killed process leaves the `.part.rrd` with every chunk that was sent. A full disk, a vanished folder or a
stuck one raises RecordingError at the next `send` or at `close`, and leaves nothing under the final name. Two writers
of one name would spoil each other's file: the second is refused.
"""

from __future__ import annotations

import fcntl
import os
import queue
import subprocess
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import rerun_cli
from rerun.chunk import Chunk, LazyChunkStream

APPLICATION = "vehicle-testbed"
_QUEUE = 512  # chunks in flight: bounds memory, a few seconds of a drive
_PATIENCE = 60.0  # [s] without progress until a stuck disk is a fault
_POLL = 0.005  # [s] between looks at a full queue


class RecordingError(OSError):
    """A recording that cannot be written; one line, with the path."""


class RrdFile:
    """Sends chunks to disk in the order they come. Not itself safe to use from several threads."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        if self.path.suffix != ".rrd":
            raise ValueError(f"{path}: a recording's name ends in .rrd")
        self.part = self.path.with_suffix(".part.rrd")
        if self.path.is_dir():
            raise RecordingError(f"{path}: is a folder, want a file name that ends in .rrd")
        try:
            self.part.parent.mkdir(parents=True, exist_ok=True)
            self._held = self.part.open("ab")
            fcntl.flock(self._held, fcntl.LOCK_EX | fcntl.LOCK_NB)  # until it is closed or its process ends
            self._held.truncate(0)
        except BlockingIOError:
            self._held.close()
            raise RecordingError(f"{path}: another drive is writing it; choose another name") from None
        except OSError as error:
            raise RecordingError(f"{path}: cannot write here: {error.strerror}") from None
        # SimpleQueue: handing a chunk over takes a fifth of queue.Queue's time; `_put` keeps it short
        self._queue: queue.SimpleQueue[Callable[[], Chunk] | None] = queue.SimpleQueue()
        self._fault: BaseException | None = None
        self._thread = threading.Thread(target=self._write, name=f"recording {self.path.name}", daemon=True)
        self._thread.start()

    def _chunks(self) -> Iterator[Chunk]:
        while (build := self._queue.get()) is not None:
            yield build()

    def _write(self) -> None:
        try:
            stream = LazyChunkStream.from_iter(self._chunks())
            stream.write_rrd(self.part, application_id=APPLICATION, recording_id=str(uuid.uuid4()))
        except (RuntimeError, ValueError, OSError) as error:  # rerun reports a failed write as one of these
            self._fault = error

    def _check(self) -> None:
        if self._thread.is_alive():
            return
        reason = str(self._fault or "the writer stopped").strip().splitlines()[-1]
        raise RecordingError(f"{self.path}: recording failed: {reason}; what was written before is in {self.part}")

    def send(self, build: Callable[[], Chunk]) -> None:
        """Queue a chunk, built in the writer's thread by `build()`. Raises RecordingError if writing has failed."""
        self._put(build)

    def _put(self, item: Callable[[], Chunk] | None) -> None:
        self._check()
        deadline = time.monotonic() + _PATIENCE
        while self._queue.qsize() >= _QUEUE:
            self._check()
            if time.monotonic() > deadline:
                raise RecordingError(f"{self.path}: the disk took nothing for {_PATIENCE:.0f} s")
            time.sleep(_POLL)
        self._queue.put(item)

    def _finish(self) -> None:
        """Ends the stream and waits for the last byte."""
        self._put(None)
        self._thread.join(_PATIENCE)
        if self._thread.is_alive():
            raise RecordingError(f"{self.path}: the disk took nothing for {_PATIENCE:.0f} s")
        if self._fault is not None:
            self._check()

    def close(self, blueprint: Any = None) -> None:
        """Finish, join the blueprint (a rerun.blueprint.Blueprint) in, and give the file its final name."""
        self._finish()
        finished = self.part
        layout = self.path.with_suffix(".part.rbl")
        joined = self.path.with_suffix(".joined.part.rrd")
        try:
            if blueprint is not None:
                blueprint.save(APPLICATION, str(layout))
                _join(layout, self.part, joined)
                finished = joined
            os.replace(finished, self.path)
            self.part.unlink(missing_ok=True)
        except OSError as error:
            reason = error.strerror or error
            rest = f"all of it is in {self.part}" if self.part.exists() else f"{self.part} has vanished"
            raise RecordingError(f"{self.path}: recording failed: {reason}; {rest}") from None
        finally:
            self._held.close()
            layout.unlink(missing_ok=True)
            joined.unlink(missing_ok=True)

    def abort(self) -> None:
        """Finish without the final name: everything sent stays in the `.part.rrd`. Never raises a fault of the disk."""
        try:
            self._finish()
        except RecordingError:
            return
        finally:
            self._held.close()


def _join(layout: Path, recording: Path, joined: Path) -> None:
    """Both files' messages in one finished file (`rerun rrd route`: nothing is decoded, 1.5 ms per MB)."""
    program = Path(rerun_cli.__file__).with_name("rerun")
    command = [str(program), "rrd", "route", str(layout), str(recording), "-o", str(joined)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if line.startswith("Error")] or done.stderr.splitlines()
        raise OSError(lines[-1] if lines else f"rerun rrd route ended with status {done.returncode}")
