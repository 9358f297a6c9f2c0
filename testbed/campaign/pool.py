"""Where the drives of a campaign run: processes of this machine, or the workers of a Dask or Ray cluster, by joblib.

The numbers do not depend on it: a task is plain data, its work a module's function, and everything random in it comes
from the task's own seed. A process computes with one thread, so as many processes as cores fill the machine.
"""

from __future__ import annotations

import os
import socket
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any

import joblib
from joblib.externals.loky.process_executor import BrokenProcessPool

BACKENDS = ("processes", "dask", "ray")
MODULES = {"dask": "distributed", "ray": "ray"}
TIMEOUT = 10.0  # s to reach a cluster's scheduler
WATCH = 0.5  # s between looks at whether the parent still is
BATCH = 4  # tasks a worker that are given together where rows cannot be had one by one

Work = Callable[[dict[str, Any]], dict[str, Any]]
Numbered = tuple[int, dict[str, Any]]


class WorkerLost(RuntimeError):
    """A worker died in its task; says how, in one line."""


@dataclass(frozen=True)
class Pool:
    """backend: of BACKENDS; jobs: processes, where 1 is this one, which no drive may bring down (on a cluster, its
    workers decide); address: of a cluster's scheduler. ValueError names what is not valid."""

    backend: str = "processes"
    jobs: int = field(default_factory=joblib.cpu_count)
    address: str | None = None

    def __post_init__(self) -> None:
        if self.backend not in BACKENDS:
            raise ValueError(f"unknown backend {self.backend!r}; valid: {', '.join(BACKENDS)}")
        if self.jobs < 1:
            raise ValueError(f"{self.jobs} jobs; valid: a whole number of 1 or more")
        if self.backend == "processes":
            if self.address is not None:
                raise ValueError(f"address {self.address!r} belongs to a cluster; valid backends: dask, ray")
            return
        if self.address is None:
            raise ValueError(f"backend {self.backend} needs the address of its cluster")
        if find_spec(MODULES[self.backend]) is None:
            raise ValueError(f"backend {self.backend} is not installed; pip install 'vehicle-testbed[{self.backend}]'")


Stream = Callable[[Sequence[Any]], Generator[Numbered, None, None]]


def _one_by_one(calls: Sequence[Any]) -> Generator[Numbered, None, None]:
    yield from joblib.Parallel(return_as="generator_unordered", pre_dispatch="all", batch_size=1)(calls)


def _end_with(parent: int) -> None:
    """Ends this process soon after its parent was killed: it would drive on for nobody, and hold the output open."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(WATCH)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _processes(pool: Pool) -> Iterator[Stream]:
    own = {"initializer": _end_with, "initargs": (os.getpid(),)} if pool.jobs > 1 else {}
    with joblib.parallel_config(backend="loky", n_jobs=pool.jobs, inner_max_num_threads=1, **own):
        try:
            yield _one_by_one
        except BrokenProcessPool as lost:
            raise WorkerLost(_first_line(lost)) from None


@contextmanager
def _dask(pool: Pool) -> Iterator[Stream]:
    from distributed import Client, KilledWorker

    try:
        client = Client(pool.address, timeout=TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ValueError(f"no Dask scheduler at {pool.address}: {_first_line(error)}") from None
    try:
        if not client.scheduler_info()["workers"]:
            raise ValueError(f"the Dask scheduler at {pool.address} has no workers")
        with joblib.parallel_config(backend="dask", client=client, n_jobs=-1):
            yield _one_by_one
    except KilledWorker as lost:
        raise WorkerLost(_first_line(lost)) from None
    finally:
        client.close()


def _knock(address: str) -> None:
    """OSError where nobody listens at HOST:PORT, which takes Ray minutes to say."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if port.isdigit():
        socket.create_connection((host, int(port)), TIMEOUT).close()


@contextmanager
def _ray(pool: Pool) -> Iterator[Stream]:
    import ray
    from ray.exceptions import RayActorError, WorkerCrashedError
    from ray.util.joblib import register_ray

    try:
        _knock(str(pool.address))
        ray.init(address=pool.address, logging_level="ERROR", log_to_driver=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise ValueError(f"no Ray cluster at {pool.address}: {_first_line(error)}") from None

    def in_batches(calls: Sequence[Any]) -> Generator[Numbered, None, None]:
        """joblib has no generator for Ray: a batch's rows come when all of them are there."""
        size = BATCH * joblib.effective_n_jobs(-1)
        for start in range(0, len(calls), size):
            yield from joblib.Parallel(batch_size=1)(calls[start : start + size])

    try:
        register_ray()
        with joblib.parallel_config(backend="ray", n_jobs=-1):
            yield in_batches
    except (RayActorError, WorkerCrashedError) as lost:
        raise WorkerLost(_first_line(lost)) from None
    finally:
        ray.shutdown()


_OPEN: Mapping[str, Callable[[Pool], AbstractContextManager[Stream]]] = {
    "processes": _processes, "dask": _dask, "ray": _ray,
}  # fmt: skip


def _first_line(error: Exception) -> str:
    return next(iter(str(error).splitlines()), type(error).__name__)


@contextmanager
def results(pool: Pool, work: Work, tasks: Sequence[dict[str, Any]]) -> Iterator[Iterator[Numbered]]:
    """(number of the task, its row) as they are finished, in no order; leaving it ends what still runs. ValueError
    where a cluster cannot be reached, WorkerLost when a worker dies."""
    calls = [joblib.delayed(_numbered)(work, i, task) for i, task in enumerate(tasks)]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module="joblib")  # that it was left before the last row, or lost a worker
        with _OPEN[pool.backend](pool) as stream, closing(stream(calls)) as rows:
            yield rows


def _numbered(work: Work, number: int, task: dict[str, Any]) -> Numbered:
    return number, work(task)
