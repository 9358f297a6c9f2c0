"""How long a campaign takes, from a drive of a few seconds on this machine."""

from __future__ import annotations

import dataclasses
import os
import time
from dataclasses import dataclass

from testbed.campaign.plan import Campaign
from testbed.scenario import Scenario
from testbed.session import Session

TRIED = 5.0  # s of the first drive that are driven
START_UP = 5.0  # s until the workers have loaded everything


@dataclass(frozen=True)
class Cost:
    """set_up: of a drive, up to its first step [s]; per_second: wall time per simulated second [-]."""

    set_up: float
    per_second: float

    def wall(self, campaign: Campaign, jobs: int) -> float:
        """Wall time of the whole campaign [s] on so many processes of this machine."""
        drives = sum(1 + bool(task["calibration"]) for task in campaign.tasks)
        work = drives * self.set_up + campaign.driven_seconds * self.per_second
        return START_UP + work / min(jobs, os.cpu_count() or 1, len(campaign.tasks))


def measured_cost(campaign: Campaign) -> Cost:
    """Of the campaign's first drive, shortened. ValueError where it cannot be driven."""
    scenario = Scenario.from_notes(campaign.tasks[0]["scenario"])
    short = dataclasses.replace(scenario, duration=min(TRIED, scenario.duration))
    _drive(dataclasses.replace(short, duration=min(1.0, short.duration)), campaign)  # loads every kernel
    return _drive(short, campaign)


def _drive(scenario: Scenario, campaign: Campaign) -> Cost:
    begun = time.perf_counter()
    session = Session(scenario, None, campaign.estimators)
    ready = time.perf_counter()
    for _ in session.run():
        pass
    return Cost(ready - begun, (time.perf_counter() - ready) / scenario.duration)
