"""Runs many tasks and loses none: what is finished is on disk at once, what fails is a row with its error, and a second
call goes on where the first one stopped.

rows = run_tasks(work, tasks, folder, pool)

work: a module's function from a task to a row, both JSON values (lists of numbers in a row are time series). A row
that is kept carries beside them

    task_key       digest of code, work and task, the part's name
    error          None, or what the work raised, in one line
    wall_s         time that the work took [s]; no two runs agree in it, so it is not compared

A worker that dies takes its task back to the queue. When workers die without anything finished, tasks run one at a time
until it is known which one kills them; that one becomes a row too, but not a part, so a second call tries it again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from testbed.campaign.code_version import code_version
from testbed.campaign.parts import Parts, Row, task_key
from testbed.campaign.pool import Pool, Work, WorkerLost, results

RESTARTS = (
    3  # times that a task may lose its worker while it runs alone; and tasks lost so before the campaign gives up
)
CODE = "code_version"  # of the worker, on its way here


class CampaignError(RuntimeError):
    """The campaign cannot go on; what was finished is kept."""


def attempt(work: Work, task: dict[str, Any]) -> Row:
    """The work's row, or the row of its failure."""
    start = time.perf_counter()
    try:
        row, error = work(task), None
    except Exception as failure:  # whatever goes wrong in one drive must not end the others
        row, error = {}, " ".join(f"{type(failure).__name__}: {failure}".split())
    return row | {"error": error, "wall_s": time.perf_counter() - start, CODE: code_version()}


def run_tasks(
    work: Work,
    tasks: Sequence[dict[str, Any]],
    folder: Path,
    pool: Pool,
    finished: Callable[[int, int], None] = lambda done, all_: None,
    warn: Callable[[str], None] = lambda line: None,
) -> list[Row]:
    """Rows in the order of the tasks.

    finished: told (tasks done, different tasks in all) at the start and after each; warn: told a line about a damaged
    part.
    Raises ValueError where the pool cannot be had, OSError when the disk fails, CampaignError when workers only die or
    run other code than this process.
    """
    keys = [task_key(f"{work.__module__}.{work.__qualname__}", task) for task in tasks]
    by_key = dict(zip(keys, tasks, strict=True))
    parts = Parts(folder)
    rows, damaged = parts.read(by_key)
    for line in damaged:
        warn(line)
    finished(len(rows), len(by_key))
    barren = lost = 0  # losses in a row without a finished task; tasks given up
    while waiting := [key for key in by_key if key not in rows]:
        batch = waiting[:1] if barren else waiting
        before = len(rows)
        try:
            with results(pool, partial(attempt, work), [by_key[key] for key in batch]) as stream:
                for number, row in stream:
                    _same_code(row.pop(CODE))
                    key = batch[number]
                    rows[key] = {"task_key": key} | row
                    parts.write(key, rows[key])
                    finished(len(rows), len(by_key))
            barren = 0
        except WorkerLost as loss:
            barren = 0 if len(rows) > before else barren + 1
            if barren <= RESTARTS:
                continue
            lost += 1
            if lost >= RESTARTS and len(rows) < lost:
                raise CampaignError(f"workers only die ({loss})") from None
            rows[batch[0]] = {"task_key": batch[0], "error": f"WorkerLost: {loss}", "wall_s": None}
            finished(len(rows), len(by_key))
            barren = 0
    return [rows[key] for key in keys]


def _same_code(theirs: str) -> None:
    if theirs != code_version():
        raise CampaignError("a worker runs other code than this process; bring both to one version")
