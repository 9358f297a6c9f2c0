"""A campaign's drives as its final table, `drives.parquet` in the output folder: a row a drive, in the file's order,
the same whether it was run at once or killed and taken up again (but for the time that each took)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from testbed.campaign.drive_row import drive_row
from testbed.campaign.engine import run_tasks
from testbed.campaign.parts import Row, write_table
from testbed.campaign.plan import Campaign
from testbed.campaign.pool import Pool

TABLE = "drives.parquet"


def run_campaign(
    campaign: Campaign, folder: Path, pool: Pool, finished: Callable[[int, int], None], warn: Callable[[str], None]
) -> list[Row]:
    """Rows of `testbed.campaign.drive_row`; one that failed has its number, variables and error. Errors and callbacks
    as of `engine.run_tasks`."""
    rows = run_tasks(drive_row, campaign.tasks, folder, pool, finished, warn)
    rows = [_identity(task) | row for task, row in zip(campaign.tasks, rows, strict=True)]
    write_table(folder / TABLE, rows)
    return rows


def _identity(task: dict[str, Any]) -> Row:
    return {"number": task["number"], **task["variables"]}
