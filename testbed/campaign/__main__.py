"""python -m testbed.campaign FILE: many drives, every estimator judged on them, one report.

DIR/parts/        a finished drive each, from which a killed campaign goes on
DIR/drives.parquet    the final table, a row a drive
DIR/scores.json       every figure of the report
DIR/report.html       the report
DIR/worst-ESTIMATOR.json, DIR/drive-NUMBER.rrd    the worst drive of each estimator: to replay, and its recording
"""

from __future__ import annotations

import logging
import os
import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from estimators.whole_file import check_writable, write_json
from testbed.campaign.arguments import campaign_parser, folder_of, pool_of, whole_number
from testbed.campaign.engine import CampaignError
from testbed.campaign.plan import Campaign, read_campaign
from testbed.campaign.progress import drive_progress, duration_text, print_plan
from testbed.warm import warm_once

INTERRUPTED = 130


class _Kept:
    """How many drives are on disk, for when a campaign ends early."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._done, self._total = folder, 0, 0

    def __call__(self, done: int, total: int) -> None:
        self._done, self._total = done, total

    def __str__(self) -> str:
        if not self._total:
            return ""
        return f"; {self._done} of {self._total} drives are kept in {self._folder}, the same call goes on from there"


def _complain(*words: object) -> None:
    print("testbed.campaign: " + " ".join("".join(map(str, words)).split()), file=sys.stderr)


def _dry_run(console: Console, campaign: Campaign, options: Namespace) -> None:
    from testbed.campaign.estimate import measured_cost

    jobs = pool_of(options).jobs
    print_plan(console, campaign)
    cost = measured_cost(campaign)
    wall = duration_text(cost.wall(campaign, jobs))
    rate = f"a drive sets up in {cost.set_up:.2f} s and runs {1.0 / cost.per_second:.0f} times real time"
    console.print(f"{wall} with {jobs} processes of this machine, where {rate}", highlight=False)


def _run(console: Console, campaign: Campaign, options: Namespace, kept: _Kept) -> None:
    from testbed.campaign.judge import judge
    from testbed.campaign.replay import record_worst
    from testbed.campaign.report import write_report
    from testbed.campaign.report_console import print_scores
    from testbed.campaign.run import run_campaign

    folder, pool = folder_of(options), pool_of(options)
    folder.mkdir(parents=True, exist_ok=True)
    if options.json:
        check_writable(options.json)
    warm_once()
    with drive_progress(console) as bar:

        def finished(done: int, total: int) -> None:
            kept(done, total)
            bar(done, total)

        rows = run_campaign(campaign, folder, pool, finished, _complain)
    scores = judge(campaign, rows)
    record_worst(campaign, rows, scores["worst"], folder)
    for path in [folder / "scores.json", *([options.json] if options.json else [])]:
        write_json(path, scores)
    report = write_report(campaign, rows, scores, options.file, folder)
    print_scores(console, scores)
    console.print(f"report {report}", highlight=False, soft_wrap=True)


def _replay(console: Console, campaign: Campaign, options: Namespace) -> None:
    from testbed.campaign.replay import replay

    recording, row = replay(campaign, whole_number(options.replay, "--replay"), folder_of(options))
    console.print(f"{row['distance_m']:.0f} m; recording {recording}", highlight=False, soft_wrap=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 done (drives that failed are in the table), 2 bad input, a disk or a pool that fails, 130 for
    Ctrl-C; one line on stderr says which, and what is kept."""
    options = campaign_parser().parse_args(arguments)
    console = Console(quiet=options.quiet)
    for name in ("absl", "distributed"):  # what goes wrong is told below
        logging.getLogger(name).setLevel(logging.ERROR)
    os.environ.setdefault("RUST_LOG", "error")
    kept = _Kept(folder_of(options))
    try:
        campaign = read_campaign(options.file)
        if options.dry_run:
            _dry_run(console, campaign, options)
        elif options.replay is not None:
            _replay(console, campaign, options)
        else:
            _run(console, campaign, options, kept)
    except KeyboardInterrupt:
        _complain("interrupted", kept)
        return INTERRUPTED
    except OSError as error:
        _complain(f"{error.filename}: {error.strerror}" if error.filename else error, kept)
        return 2
    except (ValueError, CampaignError) as error:
        _complain(error, kept)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
