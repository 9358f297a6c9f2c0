"""The command line of a campaign."""

from __future__ import annotations

import argparse
from pathlib import Path

from testbed.arguments import RECORDINGS, Parser
from testbed.campaign.pool import BACKENDS, Pool


def campaign_parser() -> Parser:
    """The parser of `python -m testbed.campaign`."""
    p = Parser(
        prog="testbed.campaign",
        description="Runs the drives of a campaign file, judges every estimator on them and writes a report. What is "
        "finished is kept: after a kill the same call goes on where it stopped.",
    )
    add = p.add_argument
    add("file", metavar="FILE", type=Path, help="campaign file (TOML)")
    add("--jobs", metavar="N", help="processes (default: one a core)")
    add("--out", metavar="DIR", type=Path, help="folder of results (default recordings/NAME of the file)")
    add("--backend", default="processes", help=f"{', '.join(BACKENDS)} (default %(default)s)")
    add("--address", metavar="A", help="of the cluster's scheduler, with --backend dask or ray")
    add("--dry-run", action="store_true", help="print what would run, how many drives, and how long")
    add("--replay", metavar="NUMBER", help="drive that one again and leave its recording DIR/drive-NUMBER.rrd")
    add("--json", metavar="FILE", type=Path, help="write every figure of the report as JSON here too")
    add("--quiet", action="store_true", help="no progress bar, no table")
    return p


def folder_of(options: argparse.Namespace) -> Path:
    """Where the results go."""
    return options.out or RECORDINGS / options.file.stem


def pool_of(options: argparse.Namespace) -> Pool:
    """Where the drives run. ValueError names what is not valid."""
    jobs = {} if options.jobs is None else {"jobs": whole_number(options.jobs, "--jobs")}
    return Pool(backend=options.backend, address=options.address, **jobs)


def whole_number(text: str, option: str) -> int:
    """ValueError names the option."""
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"{option} {text!r}: want a whole number") from None
