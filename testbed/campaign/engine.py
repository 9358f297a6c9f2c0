"""Runs many tasks and loses none: what is finished is on disk at once, what fails is a row with its error, and a second
call goes on where the first one stopped.

rows = run_tasks(work, tasks, folder, pool)

work: a module's function from a task to a row, both JSON values (lists of numbers in a row are time series). A row
that is kept carries beside them

    task_key       digest of code, work and task, the part's name
    error          None, or what the work raised, in one line
    wall_s         time that the work took [s]; no two runs agree in it, so it is not compared
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from joblib.externals.loky.process_executor import BrokenProcessPool

from testbed.campaign.parts import Parts, Row, task_key
from testbed.campaign.pool import Pool, Work, results

RESTARTS = 3  # times in a row that a pool may lose a worker without a finished task before the campaign gives up


class CampaignError(RuntimeError):
    """The campaign cannot go on; what was finished is kept."""


def attempt(work: Work, task: dict[str, Any]) -> Row:
    """The work's row, or the row of its failure."""
    start = time.perf_counter()
    try:
        row, error = work(task), None
    except Exception as failure:  # whatever goes wrong in one drive must not end the others
        row, error = {}, " ".join(f"{type(failure).__name__}: {failure}".split())
    return row | {"error": error, "wall_s": time.perf_counter() - start}


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
    Raises ValueError where the pool cannot be had, OSError when the disk fails, CampaignError when workers only die.
    """
    keys = [task_key(f"{work.__module__}.{work.__qualname__}", task) for task in tasks]
    parts = Parts(folder)
    rows, damaged = parts.read(keys)
    for line in damaged:
        warn(line)
    wanted = len(set(keys))
    finished(len(rows), wanted)
    barren = 0
    while waiting := [i for i, key in enumerate(keys) if key not in rows]:
        before = len(rows)
        try:
            for number, row in results(pool, partial(attempt, work), [tasks[i] for i in waiting]):
                key = keys[waiting[number]]
                rows[key] = {"task_key": key} | row
                parts.write(key, rows[key])
                finished(len(rows), wanted)
        except BrokenProcessPool as lost:
            barren = 0 if len(rows) > before else barren + 1
            if barren >= RESTARTS:
                raise CampaignError(
                    f"workers die without finishing a drive ({str(lost).splitlines()[0]}); "
                    f"{len(rows)} finished drives are kept in {parts.folder}"
                ) from None
    return [rows[key] for key in keys]
