"""python -m testbed.study.road_classes.learn: drive anew what the study expects, and keep it in `expected.json`.

For a change that is meant to change the figures; commit the file with it and say what moved. --paired learns only the
roads of the gate in `make test` (16 drives and 64 with a moved start, two minutes) and leaves the statistics of the
whole study as they are. Learnt roads are none that the study drives on.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from estimators.whole_file import write_whole
from testbed.arguments import RECORDINGS, Parser
from testbed.campaign.engine import run_tasks
from testbed.campaign.pool import Pool
from testbed.study.road_classes.cells import FULL, NONE, SMALL, Cell, Change, tasks
from testbed.study.road_classes.expectations import FILE, learn_paired, learn_unpaired, load
from testbed.study.road_classes.measure import measure
from testbed.study.study import run_seed

RUNS, PAIRED_RUNS = 10, 2
LEARNING, GATE = 1, 2  # purposes of `run_seed`; the study itself has 0
MOVED = tuple(Change({}, {}, speed=1.0 + 1e-4 * k) for k in (-2, -1, 1, 2))
FOLDER = RECORDINGS / "study-road-classes-learn"


def gate_seeds() -> list[int]:
    """Seeds of the paired check."""
    return [run_seed(0, number, GATE) for number in range(PAIRED_RUNS)]


def _drives(cells: Sequence[Cell], seeds: list[int], changes: Sequence[Change], pool: Pool) -> list[dict[str, Any]]:
    wanted = [task for change in changes for task in tasks(cells, seeds, change)]
    rows = run_tasks(
        measure, wanted, FOLDER, pool, lambda done, all_: print(f"\r{done} of {all_} ", end="", flush=True)
    )
    failed = [row["error"] for row in rows if row["error"]]
    if failed:
        raise ValueError(f"{len(failed)} drives failed, the first by {failed[0]}; nothing was learnt")
    return rows


def learn(path: Path, pool: Pool, paired_only: bool) -> None:
    """Writes the expectations."""
    content = dict(load(path)) if paired_only else {}
    if not paired_only:
        seeds = [run_seed(0, number, LEARNING) for number in range(RUNS)]
        content["unpaired"] = learn_unpaired(_drives(FULL, seeds, [NONE], pool))
    plain = _drives(SMALL, gate_seeds(), [NONE], pool)
    content["paired"] = learn_paired(plain, _drives(SMALL, gate_seeds(), MOVED, pool))
    write(path, content)


def write(path: Path, content: dict[str, Any]) -> None:
    """A line for each figure, so that a change shows as what it is."""
    text = json.dumps(content, indent=1, allow_nan=False)
    text = re.sub(r"[\[{][^\[\]{}]*[\]}]", lambda innermost: " ".join(innermost[0].split()), text)
    write_whole(path, (text + "\n").encode())


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 learnt, 2 not."""
    parser = Parser(prog="testbed.study.road_classes.learn", description="Learns what the study road-classes expects.")
    parser.add_argument("--paired", action="store_true", help="only what the gate in the tests compares with")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes (default %(default)s)")
    options: argparse.Namespace = parser.parse_args(arguments)
    try:
        learn(FILE, Pool(jobs=options.jobs), options.paired)
    except (OSError, ValueError) as error:
        print(f"testbed.study.road_classes.learn: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
