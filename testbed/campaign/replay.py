"""A drive of a campaign again, with its recording: the worst of each estimator, or one that is asked for by number.

`testbed.drive --scenario FILE` replays what a scenario says. A drive that also had a calibration before it, a changed
car or estimators that were told something else is replayed whole here, or with `testbed.campaign FILE --replay NUMBER`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from estimators.whole_file import write_json
from testbed.campaign.drive_row import recorded_drive
from testbed.campaign.parts import Row
from testbed.campaign.plan import Campaign


def is_plain(task: Mapping[str, Any]) -> bool:
    """Whether the scenario alone says all of a drive."""
    return not any(task[name] for name in ("calibration", "vehicle", "tyre", "believed"))


def replay(campaign: Campaign, number: int, folder: Path) -> tuple[Path, Row]:
    """The recording `drive-NUMBER.rrd` in the folder, and the drive's row. ValueError for a number out of range."""
    if not 0 <= number < len(campaign.tasks):
        raise ValueError(f"no drive {number}; valid: 0 to {len(campaign.tasks) - 1}")
    folder.mkdir(parents=True, exist_ok=True)
    recording = folder / f"drive-{number}.rrd"
    return recording, recorded_drive(campaign.tasks[number], recording)


def record_worst(campaign: Campaign, rows: list[Row], worst: Mapping[str, int], folder: Path) -> None:
    """For each estimator `worst-ESTIMATOR.json`, which replays its worst drive, and that drive's recording; a recording
    that is there already is left. worst: number of the drive by estimator."""
    for name, number in worst.items():
        told, task = folder / f"worst-{name}.json", campaign.tasks[number]
        content = {"scenario": task["scenario"], "number": number, "task_key": rows[number]["task_key"]}
        if not (folder / f"drive-{number}.rrd").is_file() or _read(told) != content:
            replay(campaign, number, folder)
            write_json(told, content)


def _read(path: Path) -> Any:
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return None
