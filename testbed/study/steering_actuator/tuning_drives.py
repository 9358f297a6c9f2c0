"""Drives that everything was tuned on, and nothing is told of: both sets of the scenarios, TUNING_SEED."""

from __future__ import annotations

from collections.abc import Iterator

from testbed.simulation import Diverged
from testbed.study.steering_actuator.heard import Heard, heard
from testbed.study.steering_actuator.scenarios import CASES, Case

TUNING_SEED, REPETITIONS = 7301, 3  # the study's own is 0


def tuning_drives(repetitions: int = REPETITIONS) -> Iterator[tuple[int, Case, Heard]]:
    """Number of the repetition, scenario, drive; a drive that the car cannot drive to its end is left out."""
    for number in range(repetitions):
        for case in CASES:
            try:
                yield number, case, heard(case.scenario(TUNING_SEED, number))
            except (ValueError, Diverged):
                continue
