"""Runs a study: what of it is finished in its folder is taken from there, the rest is done, and both become figures."""

from __future__ import annotations

import io
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl

from estimators.whole_file import write_whole
from testbed.campaign.engine import run_tasks
from testbed.campaign.pool import Pool
from testbed.study.study import Row, Study, StudyRow

DOTS_PER_INCH = 150


@dataclass(frozen=True)
class Outcome:
    """runs: repetitions; tasks, reused, failed: their tasks, those found finished, those whose work raised an error;
    errors: different ones, in one line each; table; figures, pages: files; objections; wall: time it took [s]."""

    study: str
    runs: int
    tasks: int
    reused: int
    failed: int
    errors: list[str]
    table: list[StudyRow]
    figures: list[Path]
    pages: list[Path]
    objections: list[str]
    wall: float

    def as_json(self) -> dict[str, Any]:
        """The study's JSON form."""
        return {"study": self.study, "runs": self.runs, "rows": [row.as_json() for row in self.table]}


def run_study(
    study: Study,
    runs: int,
    seed: int,
    small: bool,
    folder: Path,
    pool: Pool,
    finished: Callable[[int, int], None] = lambda done, all_: None,
    warn: Callable[[str], None] = lambda line: None,
) -> Outcome:
    """The outcome of `runs` repetitions; parts and figures are kept in the folder.

    finished: told (tasks done, tasks in all); warn: told a line about a damaged part. ValueError if no task could be
    done, OSError when the disk fails, CampaignError when workers only die.
    """
    start = time.perf_counter()
    tasks = study.tasks(runs, seed, small)
    found: list[int] = []

    def progress(done: int, wanted: int) -> None:
        found.append(done)
        finished(done, wanted)

    every = run_tasks(study.work, tasks, folder, pool, progress, warn)
    good = [row for row in every if row["error"] is None]
    errors = sorted({row["error"] for row in every if row["error"] is not None})
    if not good:
        raise ValueError(f"study {study.name}: no run could be done: {errors[0] if errors else 'there is none'}")
    return Outcome(
        study.name, runs, len(every), found[0], len(every) - len(good), errors, study.table(good),
        _drawn(study, good, folder), _told(study, good, folder), study.objections(good), time.perf_counter() - start,
    )  # fmt: skip


def _drawn(study: Study, rows: list[Row], folder: Path) -> list[Path]:
    """Files of the study's figures. No screen is needed."""
    files = []
    with mpl.rc_context({"font.size": 9.0, "axes.grid": True, "grid.alpha": 0.3}):
        for name, figure in study.figures(rows).items():
            files.append(folder / f"{name}.png")
            picture = io.BytesIO()
            figure.savefig(picture, format="png", dpi=DOTS_PER_INCH)
            write_whole(files[-1], picture.getvalue())
    return files


def _told(study: Study, rows: list[Row], folder: Path) -> list[Path]:
    """Files of the study's pages."""
    files = []
    for name, page in study.pages(rows).items():
        files.append(folder / f"{name}.html")
        write_whole(files[-1], page.encode())
    return files
