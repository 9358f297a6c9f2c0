"""python -m testbed.study NAME: one study as a table, figures and JSON. With --list: which there are.

Exit status: 0 done, 1 done and the study objects to what it found (one line each on stderr), 2 bad input or a file that
cannot be written (one line on stderr).
"""

from __future__ import annotations

import argparse
import copy
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from estimators.whole_file import check_writable, write_json
from testbed.arguments import RECORDINGS, Parser
from testbed.campaign.engine import CampaignError
from testbed.campaign.pool import Pool
from testbed.drive import INTERRUPTED
from testbed.study.registry import find_study, studies
from testbed.study.runner import Outcome, run_study
from testbed.study.study import Study
from testbed.study.table import print_table

MOST_RUNS = 100_000
WIDTH = 130  # characters of a line that goes to a file


def _whole(lowest: int, highest: int = 2**63 - 1):
    """Parser of a whole number within limits."""

    def parse(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = lowest - 1
        if not lowest <= value <= highest:
            raise argparse.ArgumentTypeError(f"{text!r}, want a whole number from {lowest} to {highest}")
        return value

    return parse


def study_parser() -> Parser:
    """The parser of `python -m testbed.study`."""
    p = Parser(prog="testbed.study", description="Runs a study: a table, figures and JSON with confidence intervals.")
    add = p.add_argument
    add("name", nargs="?", help="of the study, see --list")
    add("--list", action="store_true", help="name, question and default runs of every study")
    add("--runs", type=_whole(1, MOST_RUNS), help="repetitions (default: see --list); earlier ones are reused")
    add("--seed", type=_whole(0), default=0, help="of all repetitions (default %(default)s)")
    add("--small", action="store_true", help="a form of seconds, for a first look; its figures are not the study's")
    add("--jobs", type=_whole(1, 1024), default=os.cpu_count() or 1, help="processes (default %(default)s)")
    add("--data", metavar="FILE", help="measured data in place of the study's own (studies that read a file)")
    add("--json", metavar="FILE", help="write every figure of the table as JSON")
    add("--out", metavar="DIR", help="finished runs and figures (default recordings/study-NAME)")
    return p


def _print_list(console: Console) -> None:
    for name, study in studies().items():
        console.print(f"[bold]{name}[/] ({study.runs} runs): {study.about} {study.paper}", highlight=False)


def _print_outcome(console: Console, study: Study, outcome: Outcome) -> None:
    print_table(console, f"{study.name}: {study.about}", study.printed(outcome.table))
    for file in outcome.figures:
        console.print(f"figure {file}", highlight=False)
    for file in outcome.pages:
        console.print(f"page {file}", highlight=False)
    console.print(
        f"{outcome.runs} runs, {outcome.tasks} tasks ({outcome.reused} reused, {outcome.failed} failed), "
        f"{outcome.wall:.0f} s", highlight=False,
    )  # fmt: skip
    for error in outcome.errors:
        console.print(f"[red]failed[/] {error}", highlight=False)


def _with_data(study: Study, file: str | None) -> Study:
    """The study, reading another file. ValueError if it reads none."""
    if file is None:
        return study
    if study.data is None:
        valid = ", ".join(name for name, other in studies().items() if other.data is not None)
        raise ValueError(f"--data is {file!r}, but {study.name} reads no measured data; those that do: {valid}")
    changed = copy.copy(study)
    changed.data = Path(file)
    return changed


def _complain(message: str) -> None:
    print(f"testbed.study: {' '.join(message.split())}", file=sys.stderr)


def main(arguments: Sequence[str] | None = None) -> int:
    """See the module."""
    parser = study_parser()
    options = parser.parse_args(arguments)
    console = Console(width=None if sys.stdout.isatty() else WIDTH)
    logging.getLogger("absl").setLevel(logging.ERROR)  # MuJoCo's warning of a drive that diverges: a row says so
    if options.list:
        _print_list(console)
        return 0
    try:
        if options.name is None:
            raise ValueError(f"want the name of a study; valid: {', '.join(studies())}")
        study = _with_data(find_study(options.name), options.data)
        folder = Path(options.out) if options.out else RECORDINGS / f"study-{study.name}"
        if options.json:
            check_writable(Path(options.json))
        folder.mkdir(parents=True, exist_ok=True)
        columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed} of {task.total}"))
        with Progress(*columns, TimeRemainingColumn(), console=console, disable=not console.is_terminal) as progress:
            bar = progress.add_task(study.name, total=None)
            outcome = run_study(
                study, options.runs or study.runs, options.seed, options.small, folder, Pool(jobs=options.jobs),
                lambda done, wanted: progress.update(bar, completed=done, total=wanted), _complain,
            )  # fmt: skip
        if options.json:
            write_json(Path(options.json), outcome.as_json())
    except OSError as error:
        _complain(f"{error.filename}: {error.strerror}" if error.filename else str(error))
        return 2
    except (ValueError, CampaignError) as error:
        _complain(str(error))
        return 2
    except KeyboardInterrupt:
        _complain("interrupted; finished runs are kept")
        return INTERRUPTED
    _print_outcome(console, study, outcome)
    for line in outcome.objections:
        _complain(line)
    return 1 if outcome.objections else 0


if __name__ == "__main__":
    sys.exit(main())
