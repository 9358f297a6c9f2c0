"""Speed of whole drives in this process: simulation and all sensors, with estimators, with recording, in threads.

Each figure is of the drive under way (`Session.run` to its end, and the finishing of the recording where there is one),
after one drive that loads every kernel. Variants alternate; a speed is of the fastest repetition, since other work on
the machine can only slow a drive down, and so is each side of an overhead or a speed-up.
"""

from __future__ import annotations

import gc
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from testbed.bench.loop_cost import bare_drive
from testbed.scenario import Scenario
from testbed.session import Session


@dataclass(frozen=True)
class DriveSpeed:
    """Simulated seconds per wall second: simulation and all sensors; the same with all estimators; all with recording.
    recording_overhead: wall time of a drive with recording / without it - 1, both with sensors and estimators."""

    sensors: float
    estimators: float
    recording: float
    recording_overhead: float


def _wall(scenario: Scenario, recording: Path | None, estimators: tuple[str, ...] | None) -> float:
    """Wall time [s] of a drive from its first step to the finished recording. estimators: None for all."""
    session = Session(scenario, recording, estimators)
    gc.collect()
    begun = time.perf_counter()
    with session:
        for _ in session.run():
            pass
    return time.perf_counter() - begun


def drive_speed(duration: float, repetitions: int) -> DriveSpeed:
    """duration: [s] of each drive, over a class C road at 80 km/h."""
    scenario = Scenario(duration=duration)
    walls: list[tuple[float, float, float]] = []
    with tempfile.TemporaryDirectory() as folder:
        recording = Path(folder) / "bench.rrd"
        _wall(Scenario(duration=2.0), recording, None)
        for _ in range(repetitions):
            walls.append((_wall(scenario, None, ()), _wall(scenario, None, None), _wall(scenario, recording, None)))
    sensors, estimators, recorded = (duration / min(column) for column in zip(*walls, strict=True))
    return DriveSpeed(sensors, estimators, recorded, estimators / recorded - 1.0)


def two_thread_speedups(duration: float, repetitions: int) -> tuple[float, float]:
    """Wall time one after the other / in two threads: of two drives (simulation and all sensors), and of as many bare
    MuJoCo steps, which is what the machine has to give at the time."""
    drives: list[tuple[float, float]] = []
    bare: list[tuple[float, float]] = []
    for _ in range(repetitions):
        alone = sum(_wall(Scenario(duration=duration, seed=seed), None, ()) for seed in (1, 2))
        sessions = [Session(Scenario(duration=duration, seed=seed), None, ()) for seed in (1, 2)]
        gc.collect()
        drives.append((alone, _together([partial(_run, session) for session in sessions])))
        steps = [partial(bare_drive, session.simulation, duration) for session in sessions]
        bare.append((_together(steps[:1]) + _together(steps[1:]), _together(steps)))
    of_drives, of_bare = (min(a for a, _ in pairs) / min(t for _, t in pairs) for pairs in (drives, bare))
    return of_drives, of_bare


def _together(jobs: Sequence[Callable[[], None]]) -> float:
    """Wall time [s] of jobs, each in a thread of its own."""
    threads = [threading.Thread(target=job) for job in jobs]
    begun = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return time.perf_counter() - begun


def _run(session: Session) -> None:
    for _ in session.run():
        pass
