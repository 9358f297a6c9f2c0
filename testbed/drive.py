"""python -m testbed.drive --road C: one drive, its recording (which is its log), and a table.

Scenario -> simulation -> sensors -> estimators, second by second, all into the recording as they come.
"""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from estimators.report import read_calibration
from estimators.whole_file import check_writable, write_json
from testbed.arguments import RECORDINGS, drive_parser, scenario_of
from testbed.scenario import Scenario
from testbed.summary import Summary, print_summary

INTERRUPTED = 130  # exit status of a program that Ctrl-C ended


def default_recording(scenario: Scenario) -> Path:
    """recordings/ROAD.rrd"""
    stem = Path(scenario.road).stem if os.sep in scenario.road else scenario.road
    kept = "".join(c if c.isalnum() or c in "-_" else "-" for c in stem)
    return RECORDINGS / f"{kept}.rrd"


def drive(
    scenario: Scenario,
    recording: Path | None,
    estimators: Sequence[str] | None = None,
    progress: Progress | None = None,
    calibrations: Mapping[str, Mapping[str, Any]] | None = None,
) -> dict[str, Any]:
    """Runs one drive. recording: path of the .rrd, None for none; estimators: names, None for all; calibrations: what
    they learnt of this car before, by name.

    Returns the result as JSON values. Raises ValueError for a bad scenario or a drive that diverges, OSError when the
    recording cannot be written.
    """
    from testbed.session import (
        Session,
        Variant,
    )  # the estimators' and recorder's imports, after the arguments are known good

    start = time.perf_counter()
    session = Session(scenario, recording, estimators, Variant(calibrations=calibrations))
    summary = Summary(session.simulation.element.law)
    task = progress.add_task(scenario.road, total=scenario.duration) if progress else None
    with session:
        begun = time.perf_counter()
        for stretch, said in session.run():
            summary.add(stretch)
            summary.say(said)
            if progress and task is not None:
                progress.update(task, completed=float(stretch["time"][-1]))
        loop_wall = time.perf_counter() - begun
    result = {
        "road": session.simulation.road.name,
        "seed": scenario.seed,
        "sim_s": scenario.duration,
        "wall_s": time.perf_counter() - start,
        "realtime_factor": scenario.duration / loop_wall,
        "recording": str(recording) if recording else None,
        "log": str(recording) if recording else None,
        "scenario": scenario.as_notes(),
        "calibration": session.bank.calibrations(),
    }
    return result | summary.as_json()


def _complain(message: str) -> int:
    print(f"testbed.drive: {' '.join(message.split())}", file=sys.stderr)
    return 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 done, 2 bad input or a file that cannot be written, 130 interrupted (one line on stderr says
    which)."""
    options = drive_parser().parse_args(arguments)
    console = Console(stderr=False, quiet=options.quiet)
    logging.getLogger("absl").setLevel(logging.ERROR)  # MuJoCo's warning of a drive that diverges: told below
    os.environ.setdefault("RUST_LOG", "error")  # rerun's warning of a full disk: told below
    recording: Path | None = None
    try:
        scenario = scenario_of(options)
        recording = Path(options.out) if options.out else default_recording(scenario)
        if options.json:
            if Path(options.json).resolve() == recording.resolve():
                raise ValueError(f"--json {options.json}: is the recording; want another file")
            check_writable(Path(options.json))
        names = options.estimators.split(",") if options.estimators is not None else None
        learnt = read_calibration(Path(options.calibration)) if options.calibration else None
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.completed:.0f} s"),
            TimeRemainingColumn(),
        )
        with Progress(*columns, console=console, disable=options.quiet) as progress:
            result = drive(scenario, recording, [] if names == ["none"] else names, progress, learnt)
        if options.json:
            write_json(Path(options.json), result)
    except OSError as error:
        return _complain(f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except ValueError as error:
        return _complain(str(error))
    except KeyboardInterrupt:
        part = recording.with_suffix(".part.rrd") if recording else None
        _complain(f"interrupted; what was recorded is in {part}" if part and part.exists() else "interrupted")
        return INTERRUPTED
    if not options.quiet:
        print_summary(console, result)
        console.print(f"{result['realtime_factor']:.0f} times real time; recording {result['recording']}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
