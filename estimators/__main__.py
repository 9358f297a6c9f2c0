"""python -m estimators LOG [NAME ...]: the methods on any log, simulated or real; a table, alarms, JSON.

A first word that names a command (`COMMANDS`) runs that with the words after it instead. Exit status 0 when what was
asked could be done, 2 with one line on stderr when not.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from estimators import design_cusum
from estimators.arguments import Parser
from estimators.car import Car
from estimators.drive_log import DriveLog
from estimators.faults import FORM, inject
from estimators.registry import registered
from estimators.runner import Bank, calibrations_of, run_bank

EPILOG = f"Instead of LOG a command with options of its own: {design_cusum.NAME}."
COMMANDS = {design_cusum.NAME: design_cusum.run}


def parser() -> Parser:
    """The command line."""
    command = Parser(prog="python -m estimators", description="Run estimators on a drive log.", epilog=EPILOG)
    add = command.add_argument
    add("log", nargs="?", type=Path, metavar="LOG", help="a .rrd recording, or a .csv or .mf4 log")
    add("names", nargs="*", metavar="NAME", help="estimators to run (default: all, see --list)")
    add("--column-map", type=Path, metavar="FILE", help="what the columns of a .csv or .mf4 log mean")
    add("--car", type=Path, metavar="FILE", help="JSON: fields of estimators.car.Car, over those in the log")
    add("--calibration", type=Path, metavar="FILE", help="start from what an earlier --json file learnt")
    add("--fault", action="append", default=[], metavar="FAULT", help=f"of a sensor, laid over the log: {FORM}")
    add("--fault-seed", type=int, metavar="N", help="of random faults (default: the log's own seed, or 0)")
    add("--json", type=Path, metavar="FILE", help="write estimates (SI), radius ratios, alarms, flags, calibration")
    add("--list", action="store_true", help="list the estimators and what they read")
    return command


def fault_seed(asked: int | None, log: DriveLog) -> int:
    """The seed of random faults: as asked, or the one with which the drive's own faults would be drawn. ValueError for
    a negative one."""
    scenario = log.notes.get("scenario", {})
    seed = asked if asked is not None else scenario.get("seed", 0) if isinstance(scenario, dict) else 0
    if not isinstance(seed, int) or seed < 0:
        raise ValueError(f"--fault-seed {seed}: want a whole number of 0 or more")
    return seed


def run_on_log(options: argparse.Namespace, console: Console) -> None:
    """Read, run, print, write. ValueError or OSError with one line when that is not possible."""
    from estimators.readers import read_log  # file formats are imported when a file is read
    from estimators.report import document, print_report, read_calibration, read_json_object, usable_signals
    from estimators.whole_file import check_writable, write_json

    if options.json:
        check_writable(options.json)

    calibrations = read_calibration(options.calibration) if options.calibration else {}
    log = read_log(options.log, options.column_map)
    car = Car.from_notes(log.notes)
    if options.car:
        car = Car.from_notes({"car": asdict(car) | read_json_object(options.car)})
    bank = Bank(options.names or None, car, {**calibrations_of(log.notes), **calibrations})
    if options.fault:
        log = inject(log, options.fault, fault_seed(options.fault_seed, log), car.ring_teeth)
    present = usable_signals(log)
    missing = bank.missing(present)
    if set(missing) == set(bank.names):
        lacking = sorted({signal for signals in missing.values() for signal in signals})
        raise ValueError(f"{options.log}: no usable signal, {', '.join(bank.names)} need {', '.join(lacking)}")
    result = document(str(options.log), log, car, bank, run_bank(bank, log))
    result["faults"] = options.fault
    print_report(console, result)
    if options.json:
        write_json(options.json, result)


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status."""
    console = Console()
    words = sys.argv[1:] if arguments is None else list(arguments)
    try:
        if words and words[0] in COMMANDS:
            COMMANDS[words[0]](words[1:], console)
            return 0
        options = parser().parse_intermixed_args(words)
        if options.list:
            for name, kind in registered().items():
                console.print(f"{name}: reads {', '.join(kind.reads)}", highlight=False, soft_wrap=True)
            return 0
        if options.log is None:
            raise ValueError("no LOG given, want a .rrd, .csv or .mf4 file; --list shows the estimators")
        run_on_log(options, console)
    except (ValueError, OSError) as error:
        print(f"estimators: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
