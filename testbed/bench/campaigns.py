"""What a campaign costs beside its drives, and what a second process is worth.

Overhead: wall time of a campaign in this process (plan, drives, a part each, final table) / of the same drives bare
(`Session.run` with all estimators) - 1. Judgement and report come once a campaign, a second or two, and are left out.
Speed-up: wall time of a campaign in one process / in two, once both have loaded everything; that start-up, which a
campaign of minutes does not feel, is `worker_start_up_s`. Each drive is class C, 80 km/h. Variants alternate and the
fastest repetition of each counts.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from testbed.campaign.plan import campaign
from testbed.campaign.pool import Pool
from testbed.campaign.run import run_campaign
from testbed.scenario import Scenario
from testbed.session import Session


@dataclass(frozen=True)
class CampaignCost:
    """overhead, speed_up [-]; worker_start_up: until two processes have driven a first short drive each [s]."""

    overhead: float
    speed_up: float
    worker_start_up: float


def campaign_cost(duration: float, drives: int, repetitions: int) -> CampaignCost:
    """duration: of a drive [s]; drives: of a campaign, an even number of them."""
    content = {"runs": drives, "scenario": {"duration_s": duration}}
    one, two = Pool(jobs=1), Pool(jobs=2)
    _wall(_campaign, {"runs": 1, "scenario": {"duration_s": 1.5}}, one)
    start_up = _wall(_campaign, {"runs": 2, "scenario": {"duration_s": 1.5}}, two)
    walls = [
        (_wall(_bare, content), _wall(_campaign, content, one), _wall(_campaign, content, two))
        for _ in range(repetitions)
    ]
    bare, alone, together = (min(column) for column in zip(*walls, strict=True))
    return CampaignCost(alone / bare - 1.0, alone / together, start_up)


def _wall(job: Callable[..., None], *arguments: Any) -> float:
    begun = time.perf_counter()
    job(*arguments)
    return time.perf_counter() - begun


def _bare(content: dict[str, Any]) -> None:
    """The drives of a campaign and nothing else."""
    for task in campaign(content).tasks:
        for _ in Session(Scenario.from_notes(task["scenario"]), None, task["estimators"]).run():
            pass


def _campaign(content: dict[str, Any], pool: Pool) -> None:
    with tempfile.TemporaryDirectory() as folder:
        rows = run_campaign(campaign(content), Path(folder), pool, lambda done, total: None, lambda line: None)
    failed = [row["error"] for row in rows if row["error"]]
    if failed:
        raise RuntimeError(failed[0])
