"""The seed's method on the study's drives: its three sources of acceleration, at 20 Hz, and its own thresholds.

Sources: accelerometer, front and rear pair, as `estimators.redundancy.sources` makes them (speed differenced over 0.5
s, the pitch's change taken out), each less its mean over the drive: the seed knows no offsets. Its simulation had
neither roads nor grades, so these are harder records than its own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.grid import LATENCY, Grid
from estimators.redundancy.global_value import kalman_mean, mean_square_error, plain_mean, weighted_mean
from estimators.redundancy.published import FALSE_ALARMS_FIRST, Judged, Parameters, judge
from estimators.redundancy.sources import CHANNELS, STEP, constants, force_sources, new_past, yaw_sources
from estimators.redundancy.tuning import Candidate, choose, rated
from estimators.scores.false_alarms import episodes
from testbed.study.sensor_faults.drives import Drive

NAMES = ("INS", "front odometers", "rear odometers")
FAULTS = ("bias 0.1", "bias 0.3", "bias 0.5", "scale 0.9", "scale 0.7", "scale 0.5", "stuck")
TABLE_1 = {
    "no fault": (3e-4, 4e-4, 4e-4), "bias 0.1": (1e-3, 6e-4, 6e-4), "bias 0.3": (1e-2, 1e-3, 8e-4),
    "bias 0.5": (3e-2, 2e-3, 1e-3), "scale 0.9": (0.9e-3, 1.02e-3, 1.02e-3), "scale 0.7": (2.4e-3, 1.1e-3, 1.05e-3),
    "scale 0.5": (5.2e-3, 1.3e-3, 1.2e-3), "stuck": (2e-2, 1e-3, 1e-3),
}  # fmt: skip
SIGMAS = (0.02, 0.04, 0.06, 0.1, 0.2, 0.4, 0.8)
THRESHOLDS = (0.02, 0.1, 0.25, 0.47, 0.6, 0.78, 0.9, 0.98)
ROC_BIASES = (0.02, 0.2, 0.4, 0.6, 0.8)  # m/s^2, Table 2
ROC_SIGMAS = (0.02, 0.4, 0.8)
ROC_THRESHOLDS = (1e-6, 1e-4, 1e-3, 0.01, 0.1, 0.3, 0.6, 0.9, 0.999, 1.0 - 1e-9)
MIDDLE = 0.25  # s by which a difference over 0.5 s lies behind
GAP = 1.0  # s between alarms that count as two
EXPOSED = (0.4, 0.7)  # share of the record in which a fault is there


@dataclass(frozen=True)
class Record:
    """time [s], (n,); said: acceleration of the three sources [m/s^2] and yaw, their yaw rates [rad/s], (n, 3) each;
    truth: acceleration, less its mean, (n,)."""

    time: NDArray[np.float64]
    said: NDArray[np.float64]
    yaw: NDArray[np.float64]
    truth: NDArray[np.float64]


def record(drive: Drive) -> Record:
    """Of a drive, where all sources speak."""
    c, past, grid = constants(Car()), new_past(), Grid(CHANNELS, STEP)
    yaw, yaw_h, yaw_r = np.empty(4), np.empty((4, 7)), np.empty(4)
    force, force_h, force_r = np.empty(4), np.empty((4, 5)), np.empty(4)
    rows, times = [], []
    for number, stretch in enumerate(drive.stretches):
        grid.add(stretch)
        cells, _ = grid.close(number + 1.0 + LATENCY)
        for time, cell in zip(cells.centre, cells.value, strict=True):
            v = yaw_sources(c, past, cell, yaw, yaw_h, yaw_r)
            force_sources(c, past, cell, v, yaw[0], force, force_h, force_r)
            rows.append(np.concatenate([force[:3], yaw[:3]]))
            times.append(float(time))
    table, clock = np.array(rows), np.array(times)
    whole = np.isfinite(table).all(axis=1)
    table, clock = table[whole], clock[whole]
    truth = np.interp(clock - MIDDLE, drive.time, drive.acceleration)
    said = table[:, :3] - table[:, :3].mean(axis=0)
    return Record(clock, said, table[:, 3:], truth - truth.mean())


def broken(said: NDArray[np.float64], fault: str, source: int) -> tuple[NDArray[np.float64], slice]:
    """A copy with a fault on one source in the exposed part, and that part."""
    n = len(said)
    where = slice(round(EXPOSED[0] * n), round(EXPOSED[1] * n))
    kind, _, number = fault.partition(" ")
    off = said.copy()
    part = off[where, source]
    if kind == "bias":
        part += float(number)
    elif kind == "scale":
        part *= float(number)
    else:
        part[:] = off[where.start - 1, source] if kind == "stuck" else 0.0
    return off, where


def global_values(said: NDArray[np.float64], truth: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Methods 1 to 3: mean, Kalman filter with equal sources, weighted mean, (n,) each."""
    variance = np.full(3, max(float(np.mean((said - truth[:, None]) ** 2)), 1e-6))
    return plain_mean(said), kalman_mean(said, variance, float(np.mean(np.diff(truth) ** 2))), weighted_mean(said)


def table_1(of: Record) -> dict[str, list[float]]:
    """Mean square error [m^2/s^4] of the three global values during each fault of the accelerometer."""
    found = {}
    for fault in ("no fault", *FAULTS):
        off, where = broken(of.said, "bias 0" if fault == "no fault" else fault, 0)
        values = global_values(off, of.truth)
        found[fault] = [mean_square_error(value[where], of.truth[where]) for value in values]
    return found


def candidates(of: Record) -> list[Candidate]:
    """Every (sigma, threshold), rated on the accelerometer's bias, scale error and total loss: equations 21, 22."""
    found = []
    for sigma in SIGMAS:
        for threshold in THRESHOLDS:
            parameters = Parameters(sigma, threshold)
            sound, records = judge(of.said, parameters), []
            for fault in ("bias 0.3", "scale 0.5", "zero"):
                off, where = broken(of.said, fault, 0)
                part, error = judge(off, parameters), (off - of.said)[where, 0]
                records.append((Judged(part.value[where], part.faulty[where], part.alone[where]), error))
            found.append(rated(parameters, sound, records, 0))
    return found


def chosen(every: list[Candidate], first: str, second: str, limit: float) -> Candidate | None:
    """By the seed's strategies; None where no candidate meets the first criterion."""
    try:
        return choose(every, first, limit, second)
    except ValueError:
        return None


def roc(of: Record) -> dict[str, list[list[float]]]:
    """Figure 15: for each sigma and bias the shares [false alarm, detection] over thresholds."""
    curves: dict[str, list[list[float]]] = {}
    for sigma in ROC_SIGMAS:
        for threshold in ROC_THRESHOLDS:
            parameters = Parameters(sigma, threshold)
            sound = float(judge(of.said, parameters).faulty[:, 0].mean())
            for bias in ROC_BIASES:
                off, where = broken(of.said, f"bias {bias}", 0)
                found = float(judge(off, parameters).faulty[where, 0].mean())
                curves.setdefault(f"{sigma:g}/{bias:g}", []).append([sound, found])
    return curves


def false_alarms(of: Record, parameters: Parameters = FALSE_ALARMS_FIRST) -> dict[str, Any]:
    """Of the seed's own thresholds on a sound drive: share of samples with any source accused, episodes, hours."""
    accused = judge(of.said, parameters).faulty.any(axis=1)
    onset = of.time[np.flatnonzero(np.diff(accused.astype(int), prepend=0) == 1)]
    hours = len(of.time) * STEP / 3600.0
    return {"share": float(accused.mean()), "episodes": episodes(onset, GAP), "hours": hours}
