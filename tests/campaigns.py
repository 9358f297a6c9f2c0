"""A small campaign for the tests: its file, and what must not differ between two runs of it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from estimators.drive_log import WHEELS
from testbed.campaign.plan import Campaign

ROOT = Path(__file__).resolve().parents[1]
FILE = """
question = "Is a low tyre found on a <rough> road?"
seed = 2
low_percent = 10
estimators = ["wheel_radius"]
[scenario]
road = { sweep = ["flat", "C"] }
speed_kmh = { sweep = [50, 90] }
duration_s = 3
pressure_kpa.fl = { uniform = [150, 250] }
"""


def campaign_file(folder: Path, more: str = "") -> Path:
    """FILE, and what is added to it, in the folder."""
    path = folder / "small.toml"
    path.write_text(FILE + more)
    return path


def table(folder: Path) -> list[list[tuple[str, str]]]:
    """Rows of the final table as texts that are equal where every number is, NaN too; without the wall times."""
    rows: list[dict[str, Any]] = pq.read_table(folder / "drives.parquet").to_pylist()
    return [[(name, repr(value)) for name, value in row.items() if name != "wall_s"] for row in rows]


def command(*arguments: object) -> subprocess.Popen[str]:
    """`python -m testbed.campaign` on its way."""
    words = [sys.executable, "-m", "testbed.campaign", *map(str, arguments)]
    return subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def made_up_rows(plan: Campaign, seconds: int = 60, noise: float = 4e3) -> list[dict[str, Any]]:
    """Rows as of drives that were never driven: every drive's front left tyre leaks evenly from nominal to the pressure
    that was drawn for it; estimates of all wheels are the truth and Gaussian noise of `noise` [Pa], told as their std;
    an alarm names the front left tyre 5 s after it is low."""
    rng = np.random.default_rng(1)
    time = np.arange(1.0, seconds + 1.0)
    rows: list[dict[str, Any]] = []
    for task in plan.tasks:
        final = task["variables"]["pressure_kpa.fl"]
        pressure = {w: np.full(seconds, 250.0) for w in WHEELS} | {"fl": np.linspace(250.0, final, seconds)}
        row = {"number": task["number"], **task["variables"], "error": None, "task_key": f"{task['number']:024d}"}
        row |= {"time_s": time.tolist(), "nominal_pressure_kpa": 250.0, "wall_s": 1.0}
        for wheel in WHEELS:
            truth = 1e3 * (pressure[wheel] - 250.0)
            name = f"wheel_radius/{wheel}/relative_pressure_change"
            row[f"pressure_kpa/{wheel}"] = pressure[wheel].tolist()
            row[f"{name}/truth"] = truth.tolist()
            row[f"{name}/value"] = (truth + rng.normal(0.0, noise, seconds)).tolist()
            row[f"{name}/std"] = [noise] * seconds
        low = time[pressure["fl"] <= (1.0 - plan.low) * 250.0]
        row["alarms"] = json.dumps([[low[0] + 5.0, "wheel_radius", ["fl"]]] if len(low) and low[0] < 50 else [])
        rows.append(row)
    return rows
