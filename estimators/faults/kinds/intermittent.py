"""An intermittent contact: in each period T it is open once, for a time w at a random place, and the line then reads
zero."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import Number, ValueFault


class Intermittent(ValueFault):
    name = "intermittent"
    about = "reads zero for OPEN seconds, once in every PERIOD"
    numbers = (Number("OPEN", "s", 1e-3, 3600.0, 0.2), Number("PERIOD", "s", 1e-3, 3600.0, 1.0))

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(self.open(time)[:, None], 0.0, value)

    def open(self, time: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether the contact is open at these times [s]."""
        width, period = self.given
        time = np.floor(time / self.chance.quantum + 1e-6) * self.chance.quantum
        count = np.floor((time - self.start) / period)
        place = (time - self.start) - count * period
        begins = self.chance.uniform((count + 0.5) * self.chance.quantum) * max(period - width, 0.0)
        return (place >= begins) & (place < begins + width)
