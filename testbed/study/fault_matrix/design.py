"""python -m testbed.study.fault_matrix.design [DRIVES]: thresholds of `estimators.sensor_checks` from sound drives.

Prints LIMITS of `estimators/sensor_checks/numbers.py`. Drives are those of `sensor-faults`' mix, seeds of their own."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import CusumMean, empirical_threshold
from estimators.grid import LATENCY, Grid
from estimators.sensor_checks import kernel
from estimators.sensor_checks.numbers import HOURS, JUDGEMENTS
from estimators.sensor_checks.sensor_checks import CHANNELS
from testbed.study.fault_matrix.drives import Heard, heard
from testbed.study.sensor_faults.drives import DURATION, scenario

SEED = 555  # the study's default is 0
DRIVES = 60
GROUPS = ((0,), (1, 2, 3, 4), (5,))  # judgements that share a threshold


def evidence(drive: Heard) -> NDArray[np.float64]:
    """q of the six judgements on a sound drive, nothing ever accused, shape (n, 6)."""
    grid, state, parts = Grid(CHANNELS, kernel.STEP), kernel.new_state(), []
    for number, stretch in enumerate(drive.stretches):
        grid.add(stretch)
        cells, _ = grid.close(number + 1.0 + LATENCY)
        said = np.empty((len(cells.index), kernel.SAID))
        values, never = np.ascontiguousarray(cells.value), np.full(3, 1e9)
        kernel.follow(kernel.constants(drive.car), state, never, cells.index, values, said)
        parts.append(np.minimum(said[:, kernel.Q], kernel.LARGEST))
    return np.concatenate(parts)


def _one_sided(threshold: float) -> CusumMean:
    return CusumMean(kernel.DRIFT, threshold, "up")


def thresholds(record: Sequence[NDArray[np.float64]]) -> list[float]:
    """h of each group of judgements."""
    arl0, found = JUDGEMENTS * HOURS * 3600.0 / kernel.STEP, []
    for group in GROUPS:
        q = np.concatenate([drive[:, i] for i in group for drive in record])
        found.append(empirical_threshold(q[np.isfinite(q)], partial(_one_sided), arl0).threshold)
    return found


def main() -> int:
    """Exit status 0."""
    drives = int(sys.argv[1]) if len(sys.argv) > 1 else DRIVES
    record = []
    for number in range(drives):
        try:
            record.append(evidence(heard(scenario(SEED, number, DURATION))))
        except ValueError as error:  # a road that this car cannot take
            print(f"drive {number}: {error}", flush=True)
        print(f"{number + 1} of {drives}", flush=True)
    print([round(h, 1) for h in thresholds(record)])
    return 0


if __name__ == "__main__":
    sys.exit(main())
