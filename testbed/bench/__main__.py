"""python -m testbed.bench [--json FILE]: the testbed's speed as ratios, each beside its bar, and as JSON.

Everything is measured in one run on the same machine: variants alternate, so other work on it falls on all of them, and
medians of ratios or fastest repetitions count (each module says which). The drive is class C, 80 km/h, 1 kHz, all
sensors.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table

from estimators.whole_file import check_writable, write_json
from testbed.arguments import Parser


@dataclass(frozen=True)
class Effort:
    """How long to measure: seconds of drive, drives of a campaign, and repetitions of each figure."""

    loop_seconds: int
    drive: float
    thread_drive: float
    campaign_drives: int
    repetitions: int
    filterpy_samples: int = 300


FULL = Effort(loop_seconds=60, drive=60.0, thread_drive=120.0, campaign_drives=6, repetitions=5)
WHOLE_DRIVE = 60.0  # s of the drive in a process of its own
QUICK = Effort(loop_seconds=5, drive=5.0, thread_drive=5.0, campaign_drives=2, repetitions=1)

# JSON key -> bar ("<=" or ">="), its value, what it is of
BARS: dict[str, tuple[str, float, str]] = {
    "loop_over_mj_step": ("<=", 2.0, "aim 1.3"),
    "realtime_factor": (">=", 30.0, "all sensors"),
    "recording_overhead": ("<=", 0.25, "whole drive"),
    "two_thread_speedup": (">=", 1.7, "all sensors"),
    "peak_memory_mib": ("<=", 1536.0, "whole drive"),
    "start_up_s": ("<=", 3.0, "to first step"),
    "drive_60s_s": ("<=", 15.0, "whole process"),
    "campaign_overhead": ("<=", 0.10, "over bare drives"),
    "two_process_speedup": (">=", 1.8, "processes warm"),
    "itpms_cpu_share": ("<=", 0.02, "of one core, real time"),
    "imm_over_filterpy_speedup": (">=", 50.0, "aim 100"),
    "imm_four_wheels_cpu_share": ("<=", 0.10, "1 kHz, aim 0.05"),
}


def measure(effort: Effort) -> dict[str, float]:
    """All figures by JSON key; those of BARS first."""
    from testbed.bench.processes import process_cost  # before this process grows

    process = process_cost(WHOLE_DRIVE, effort.repetitions)
    from testbed.bench.campaigns import campaign_cost
    from testbed.bench.drives import drive_speed, two_thread_speedups
    from testbed.bench.filter_bank import filter_bank_cost
    from testbed.bench.itpms_cost import itpms_cpu_share
    from testbed.bench.loop_cost import loop_cost

    loop = loop_cost(effort.loop_seconds)
    speed = drive_speed(effort.drive, effort.repetitions)
    threads, bare_threads = two_thread_speedups(effort.thread_drive, effort.repetitions)
    campaigns = campaign_cost(effort.drive, effort.campaign_drives, effort.repetitions)
    filters = filter_bank_cost(effort.filterpy_samples, effort.repetitions)
    return {
        "loop_over_mj_step": loop.ratio,
        "realtime_factor": speed.sensors,
        "recording_overhead": speed.recording_overhead,
        "two_thread_speedup": threads,
        "peak_memory_mib": process.peak_memory,
        "start_up_s": process.start_up,
        "drive_60s_s": process.whole,
        "campaign_overhead": campaigns.overhead,
        "two_process_speedup": campaigns.speed_up,
        "itpms_cpu_share": itpms_cpu_share(effort.drive, effort.repetitions),
        "imm_over_filterpy_speedup": filters.speedup,
        "imm_four_wheels_cpu_share": filters.share,
        "loop_step_us": 1e6 * loop.loop_step,
        "mj_step_us": 1e6 * loop.bare_step,
        "bare_thread_speedup": bare_threads,
        "worker_start_up_s": campaigns.worker_start_up,
        "realtime_with_estimators": speed.estimators,
        "realtime_with_recording": speed.recording,
    }


def met(key: str, value: float) -> bool:
    """Whether a figure of BARS keeps its bar."""
    way, bar, _ = BARS[key]
    return value <= bar if way == "<=" else value >= bar


def print_table(console: Console, figures: dict[str, float]) -> None:
    """Every figure; those that have a bar with it."""
    table = Table(title="testbed.bench", box=box.SIMPLE_HEAD)
    for heading in ("", "measured", "bar", "", ""):
        table.add_column(heading, no_wrap=True)
    for key, value in figures.items():
        way, bar, what = BARS.get(key, ("", 0.0, ""))
        verdict = "" if key not in BARS else "[green]kept[/]" if met(key, value) else "[red]missed[/]"
        table.add_row(key, f"{value:.4g}", f"{way} {bar:g}" if way else "", verdict, what)
    console.print(table)
    load = os.getloadavg()[0]
    console.print(
        f"{os.cpu_count()} cores, load {load:.1f}: medians of ratios and fastest repetitions", highlight=False
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 measured (whatever the bars say), 2 when the JSON file cannot be written."""
    parser = Parser(prog="testbed.bench", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", metavar="FILE", type=Path, help="write the figures as JSON")
    parser.add_argument("--quick", action="store_true", help="a quarter of a minute; short drives, so rough figures")
    options = parser.parse_args(arguments)
    effort = QUICK if options.quick else FULL
    try:
        if options.json:
            check_writable(options.json)
        figures = measure(effort)
        print_table(Console(), figures)
        if options.json:
            write_json(options.json, figures | {"effort": dataclasses.asdict(effort)})
    except OSError as error:
        print(f"testbed.bench: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
