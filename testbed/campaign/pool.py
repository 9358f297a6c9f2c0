"""Where the drives of a campaign run: processes of this machine, or the workers of a Dask or Ray cluster, by joblib.

The numbers do not depend on it: a task is plain data, its work a module's function, and everything random in it comes
from the task's own seed.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import joblib

BACKENDS = ("processes", "dask", "ray")
MODULES = {"dask": "distributed", "ray": "ray"}
TIMEOUT = 10.0  # s to reach a cluster's scheduler

Work = Callable[[dict[str, Any]], dict[str, Any]]


@dataclass(frozen=True)
class Pool:
    """backend: of BACKENDS; jobs: processes (on a cluster, its workers decide); address: of a cluster's scheduler.
    ValueError names what is not valid."""

    backend: str = "processes"
    jobs: int = os.cpu_count() or 1
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


def _processes(pool: Pool) -> AbstractContextManager[Any]:
    return joblib.parallel_config(backend="loky", n_jobs=pool.jobs, inner_max_num_threads=1)


@contextmanager
def _dask(pool: Pool) -> Iterator[None]:
    from distributed import Client

    try:
        client = Client(pool.address, timeout=TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ValueError(f"no Dask scheduler at {pool.address}: {error}") from None
    try:
        if not client.scheduler_info()["workers"]:
            raise ValueError(f"the Dask scheduler at {pool.address} has no workers")
        with joblib.parallel_config(backend="dask", client=client, n_jobs=-1):
            yield
    finally:
        client.close()


@contextmanager
def _ray(pool: Pool) -> Iterator[None]:
    import ray
    from ray.util.joblib import register_ray

    try:
        ray.init(address=pool.address, logging_level="ERROR")
    except (ConnectionError, ValueError, RuntimeError) as error:
        raise ValueError(f"no Ray cluster at {pool.address}: {str(error).splitlines()[0]}") from None
    try:
        register_ray()
        with joblib.parallel_config(backend="ray", n_jobs=-1):
            yield
    finally:
        ray.shutdown()


_OPEN: Mapping[str, Callable[[Pool], AbstractContextManager[Any]]] = {
    "processes": _processes, "dask": _dask, "ray": _ray,
}  # fmt: skip


def results(pool: Pool, work: Work, tasks: Sequence[dict[str, Any]]) -> Iterator[tuple[int, dict[str, Any]]]:
    """(number of the task, its row) as they are finished, in no order. ValueError where a cluster cannot be reached."""
    with _OPEN[pool.backend](pool):
        parallel = joblib.Parallel(return_as="generator_unordered", pre_dispatch="all", batch_size=1)
        yield from parallel(joblib.delayed(_numbered)(work, i, task) for i, task in enumerate(tasks))


def _numbered(work: Work, number: int, task: dict[str, Any]) -> tuple[int, dict[str, Any]]:
    return number, work(task)
