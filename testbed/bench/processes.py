"""What a user waits for, and the memory it takes: fresh processes of `python -m testbed.drive` and of its start-up.

Kernels are compiled and files are in the system's cache (second run). Of several runs the fastest counts.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass

# run as `python -c CODE drive-arguments`; prints the largest resident memory so far [KiB]
_PEAK_OF_DRIVE = """
import re, sys
from testbed.drive import main
status = main(sys.argv[1:])
print(re.search(r"VmHWM:\\s*(\\d+) kB", open("/proc/self/status").read())[1])
sys.exit(status)
"""
# what `testbed.drive` does up to the first step of the drive, then the clock that all processes share
_FIRST_STEP = """
import sys, time
from testbed.drive import drive_parser, scenario_of
from pathlib import Path
options = drive_parser().parse_args(sys.argv[1:])
scenario = scenario_of(options)
from testbed.session import Session
session = Session(scenario, Path(options.out), None)
print(time.clock_gettime(time.CLOCK_MONOTONIC))
session.__exit__(None, None, None)
"""


@dataclass(frozen=True)
class ProcessCost:
    """start_up: process start to the car standing ready for the first step [s]; whole: all of a drive's process [s];
    peak_memory: largest resident memory of that process [MiB], with sensors, estimators and recording."""

    start_up: float
    whole: float
    peak_memory: float


def _output(command: Sequence[str]) -> str:
    done = subprocess.run([sys.executable, *command], check=True, stdout=subprocess.PIPE, text=True)
    return done.stdout.strip()


def process_cost(duration: float, repetitions: int) -> ProcessCost:
    """duration: [s] of the drive. Needs /proc (Linux) for the memory. CalledProcessError if a drive fails."""
    starts, walls = [], []
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["--road", "C", "--duration", f"{duration:g}", "--out", f"{folder}/bench.rrd"]
        peak = float(_output(["-c", _PEAK_OF_DRIVE, *arguments, "--quiet"])) / 1024.0
        for _ in range(repetitions):
            begun = time.clock_gettime(time.CLOCK_MONOTONIC)
            starts.append(float(_output(["-c", _FIRST_STEP, *arguments])) - begun)
            begun = time.clock_gettime(time.CLOCK_MONOTONIC)
            _output(["-m", "testbed.drive", *arguments])
            walls.append(time.clock_gettime(time.CLOCK_MONOTONIC) - begun)
    return ProcessCost(min(starts), min(walls), peak)
