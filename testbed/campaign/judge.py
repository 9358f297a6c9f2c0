"""Rows of a campaign -> every figure of its report, each with its 95 % interval: `here` and `ci95`, null where the
drives do not tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from testbed.campaign.judge_alarms import judge_alarms
from testbed.campaign.judge_columns import Drives
from testbed.campaign.judge_estimates import errors, judge_estimates
from testbed.campaign.judge_maps import judge_maps
from testbed.campaign.plan import Campaign


def judge(campaign: Campaign, rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """JSON values: `estimates` by method and quantity, `alarms` by method, `maps`, `failed` drives, `worst` drives."""
    drives = Drives(rows)
    failed = [{"number": row["number"], "error": row["error"]} for row in rows if row["error"] is not None]
    scores: dict[str, Any] = {
        "question": campaign.question,
        "drives": len(rows),
        "failed": failed,
        "hours": float(drives.ends.sum()) / 3600.0,
        "low_percent": 100.0 * campaign.low,
        "estimates": [],
        "alarms": [],
        "maps": None,
    }
    if len(drives):
        scores["estimates"] = judge_estimates(drives)
        scores["alarms"] = judge_alarms(drives, campaign.estimators, campaign.low)
        scores["maps"] = judge_maps(campaign, drives)
    return scores | {"worst": worst_drives(drives)}


def worst_drives(drives: Drives) -> dict[str, int]:
    """Number of the drive on which each method errs most: the root mean square of its errors over that of the campaign,
    mean over its quantities. A method without an estimate that has a truth has none."""
    sizes: dict[str, list[np.ndarray]] = {}
    for (method, _), group in groupby(drives.names(), key=lambda n: (n.method, n.quantity)):
        error = errors(drives, list(group))
        seen = np.isfinite(error).any(axis=1)
        if seen.any() and np.nanmax(np.abs(error)) > 0.0:
            squares = np.full(len(error), np.nan)
            squares[seen] = np.nanmean(error[seen] ** 2, axis=1)
            sizes.setdefault(method, []).append(np.sqrt(squares / np.nanmean(squares)))
    numbers = [row["number"] for row in drives.rows]
    return {method: numbers[int(np.nanargmax(np.mean(size, axis=0)))] for method, size in sizes.items()}
