"""The evolving state of a `Watch`: alarms as they come, the same however the cells are cut.

An alarm starts its sum anew. The error is there since the last zero of the sum that told it, and taken back once BACK
has passed without another alarm. Its size is the weighted mean since then, TARGET sum(w e) / sum(w d), with standard
deviation TARGET sqrt(sum(w^2)) / sum(w d). A cell that is missing, and the ORDER after it, change nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import Monitor
from estimators.steering_actuator.residuals import STEP
from estimators.steering_actuator.watch import ORDER, Watch

BACK = round(5.0 / STEP)  # cells
FARTHEST = 1e9  # of z: so that what is made of it stays finite
NEVER = -(1 << 60)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Told:
    """An alarm: cell, the cell since which, of what (UP, DOWN, VARIANCE); size and its standard deviation [rad]."""

    cell: int
    since: int
    kind: int
    size: float
    std: float


@dataclass(frozen=True)
class Said:
    """s [rad], evidence (largest statistic over its threshold) of each cell, (n,), and the alarms in order."""

    s: Array
    evidence: Array
    alarms: list[Told]


class Watching:
    """Takes cells that follow one another."""

    def __init__(self, watch: Watch) -> None:
        self.watch = watch
        self._detectors = watch.detectors()
        self._monitors = [Monitor(detector, "restart") for detector in self._detectors]
        self._zero = [NEVER] * len(self._monitors)  # cell before which the sum was 0
        self._sums = np.zeros((3, len(self._monitors)))  # of w e, w d and w^2 (`Watch.increments`) at that cell
        self._now = np.zeros(3)
        self._before = np.full((2, ORDER), np.nan)  # z and s

    def restart(self) -> None:
        """What came before is forgotten: after a silence, in which anything may have happened."""
        for monitor in self._monitors:
            monitor.reset()
        self._zero = [NEVER] * len(self._monitors)
        self._sums[:] = self._now[:, None]
        self._before[:] = np.nan

    def take(self, begin: int, error: Array, causes: Array, unsure: float = 0.0) -> Said:
        """Cells from number `begin` on, error [rad], (n,), NaN where missing, and its causes (n, m). unsure: std
        of what the error is measured from [rad]."""
        s = np.sqrt(self.watch.spread.at(causes) ** 2 + unsure * unsure)
        z = np.clip(error / s, -FARTHEST, FARTHEST)
        self._before = np.concatenate([self._before, np.stack([z, s])], axis=1)
        rows, moments = self.watch.increments(*self._before)
        rows, moments = rows[:, ORDER:], moments[:, ORDER:]
        self._before = self._before[:, -ORDER:]
        known = np.isfinite(rows[0])
        added = np.where(known, moments, 0.0)
        sums = np.cumsum(np.concatenate([self._now[:, None], added], axis=1), axis=1)[:, 1:]
        if len(s) and NEVER in self._zero:
            self._zero = [begin if zero == NEVER else zero for zero in self._zero]
        evidence, alarms = np.zeros(len(s)), list[Told]()
        for i, (monitor, detector) in enumerate(zip(self._monitors, self._detectors, strict=True)):
            readings = monitor.run(rows[i])
            np.maximum(evidence, readings.statistic / detector.level, out=evidence)
            alarms += self._told(i, begin, readings.statistic, readings.alarm & known, sums)
        if len(s):
            self._now = sums[:, -1].copy()
        return Said(s, evidence, sorted(alarms, key=lambda told: (told.cell, told.kind)))

    def _told(self, i: int, begin: int, statistic: Array, alarm: NDArray[np.bool_], sums: Array) -> list[Told]:
        found = []
        zeros = np.flatnonzero((statistic == 0.0) | alarm)  # the sum is 0 after the cell
        for k in np.flatnonzero(alarm).tolist():
            self._from_zero(i, begin, zeros[: np.searchsorted(zeros, k)], sums)
            found.append(Told(begin + k, self._zero[i], i, *self._size(sums[:, k] - self._sums[:, i])))
        self._from_zero(i, begin, zeros, sums)
        return found

    def _from_zero(self, i: int, begin: int, zeros: NDArray[np.int64], sums: Array) -> None:
        if len(zeros):
            self._zero[i], self._sums[:, i] = begin + int(zeros[-1]) + 1, sums[:, zeros[-1]]

    def _size(self, moments: Array) -> tuple[float, float]:
        moved, told, weight = moments.tolist()
        if told <= 0.0:
            return 0.0, np.inf
        return self.watch.target * moved / told, self.watch.target * weight**0.5 / told
