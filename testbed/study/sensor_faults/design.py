"""python -m testbed.study.sensor_faults.design [DRIVES]: thresholds of `estimators.redundancy` from sound drives.

Half a minute a drive; 60 of them by default. Prints the table that stands in `estimators/redundancy/numbers.py`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.detectors import CusumMean, empirical_threshold
from estimators.grid import LATENCY, Grid
from estimators.redundancy import monitor
from estimators.redundancy.numbers import FORCE_DRIFT, HOURS, SOURCES, YAW_DRIFT
from estimators.redundancy.sources import CHANNELS, FORCE, STEP, YAW, constants
from testbed.study.sensor_faults.drives import DURATION, Drive, driven, scenario

SEED = 77_003  # the study's default is 0
DRIVES = 60


def residuals(drive: Drive, car: Car) -> NDArray[np.float64]:
    """x of both comparisons on a sound drive, nothing ever accused, shape (n, 8); NaN where nothing was judged."""
    grid, state, parts = Grid(CHANNELS, STEP), monitor.new_state(), []
    never = np.full((2, 4), 1e9)
    for number, stretch in enumerate(drive.stretches):
        grid.add(stretch)
        cells, _ = grid.close(number + 1.0 + LATENCY)
        said = np.empty((len(cells.index), monitor.SAID))
        values, none = np.ascontiguousarray(cells.value), np.zeros((len(cells.index), 4))
        monitor.follow(constants(car), state, never, cells.index, values, none, said)
        parts.append(said[:, monitor.YAW_X : monitor.YAW_X + SOURCES])
    return np.concatenate(parts)


def _two_sided(drift: float, threshold: float) -> CusumMean:
    return CusumMean(drift, threshold, "both")


def thresholds(record: Iterable[NDArray[np.float64]]) -> NDArray[np.float64]:
    """h of each source, shape (2, 4), from residuals of sound drives. Torque, on which no alarm hangs, takes the
    accelerometer's."""
    x = np.concatenate(list(record))
    arl0 = SOURCES * HOURS * 3600.0 / STEP
    found = np.full(SOURCES, np.nan)
    for i in range(SOURCES - 1):
        drift = YAW_DRIFT if i < len(YAW) else FORCE_DRIFT
        samples = x[np.isfinite(x[:, i]), i]
        found[i] = empirical_threshold(samples, partial(_two_sided, drift), arl0).threshold
    found[-1] = found[len(YAW)]
    return found.reshape(2, len(FORCE))


def main() -> int:
    """Exit status 0."""
    drives = int(sys.argv[1]) if len(sys.argv) > 1 else DRIVES
    record = []
    for number in range(drives):
        try:
            asked = scenario(SEED, number, DURATION)
            record.append(residuals(driven(asked), Car(driven_axle=asked.driven)))
        except ValueError as error:  # a road that this car cannot take
            print(f"drive {number}: {error}", flush=True)
        print(f"{number + 1} of {drives}", flush=True)
    print(np.array2string(thresholds(record), precision=2, separator=", "))
    return 0


if __name__ == "__main__":
    sys.exit(main())
