"""Total loss, the last number stays: y = the last finite x before the fault (or the first in it, where none was
before). A wheel's ring goes on giving edges at its last rate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import ValueFault


class Stuck(ValueFault):
    name = "stuck"
    about = "stays at the last value"
    _held: NDArray[np.float64] | None = None

    def observe(self, value: NDArray[np.float64]) -> None:
        if self._held is None:
            self._held = np.full(value.shape[1], np.nan)
        for column in range(value.shape[1]):
            finite = np.flatnonzero(np.isfinite(value[:, column]))
            if len(finite):
                self._held[column] = value[finite[-1], column]

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._held is None or not np.isfinite(self._held).all():
            for i in range(len(value)):
                self.observe(value[i : i + 1])
                if np.isfinite(self._held).all():  # type: ignore[arg-type]
                    break
            else:
                return np.array(value)
            return np.concatenate([value[:i], np.broadcast_to(self._held, value[i:].shape)])  # type: ignore[arg-type]
        return np.broadcast_to(self._held, value.shape).copy()
