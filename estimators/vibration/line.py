"""One signal of a wheel on its way in: what can be used, second by second, and complaints about the rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.arrival import Intake
from estimators.drive_log import Signal
from estimators.grid import SILENCE

Complaint = tuple[float, str]


class Line:
    """Scalar signal `name`."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._intake = Intake()
        self._time, self._value = np.empty(0), np.empty(0)
        self._seen: float | None = None
        self._silent = False

    def add(self, signal: Signal) -> list[Complaint]:
        """Take samples as they arrived."""
        good, refused = self._intake.accept(signal.time)
        complaints = [(time, f"{self.name}: {why}, sample refused") for time, why in refused]
        values = signal.value
        if values.dtype.kind != "f" or values.ndim != 1:
            shape = "text" if values.dtype.kind != "f" else f"of shape {values.shape}"
            text = f"{self.name}: value is {shape}, want (n,), not used"
            return complaints + [(float(t), text) for t in signal.time[good][:1]]
        finite = np.isfinite(values)
        complaints += [(float(t), f"{self.name}: not a finite number") for t in signal.time[good & ~finite]]
        self._time = np.concatenate([self._time, signal.time[good & finite]])
        self._value = np.concatenate([self._value, values[good & finite]])
        return complaints

    @property
    def earliest(self) -> float:
        """Time of the first sample that waits [s], inf if none does."""
        return float(self._time[0]) if len(self._time) else np.inf

    @property
    def latest(self) -> float:
        """Time of the last sample that waits [s], -inf if none does."""
        return float(self._time[-1]) if len(self._time) else -np.inf

    def take(self, begin: float, end: float) -> tuple[NDArray, NDArray, list[Complaint]]:
        """Samples before `end` [s], taken out; and whether the signal has fallen silent. begin: the second's [s]."""
        split = int(np.searchsorted(self._time, end))
        time, value = self._time[:split], self._value[:split]
        self._time, self._value = self._time[split:], self._value[split:]
        if self._seen is None:
            self._seen = begin
        marks = np.concatenate([[self._seen], time])
        starts = marks[:-1][np.diff(marks) > SILENCE].tolist()
        if self._silent and starts and starts[0] == self._seen:
            starts = starts[1:]
        if len(time):
            self._silent = False
        if end - marks[-1] > SILENCE and not self._silent:
            self._silent = True
            starts.append(float(marks[-1]))
        self._seen = float(marks[-1])
        return time, value, [(t + SILENCE, f"{self.name}: no usable sample for {SILENCE:g} s") for t in starts]
