"""An offset that grows: y = x + r (t - start)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import SIGNAL_RATE, Number, ValueFault


class Drift(ValueFault):
    name = "drift"
    about = "an offset that grows with time"
    numbers = (Number("RATE", SIGNAL_RATE),)

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        return value + self.given[0] * (time - self.start)[:, None]
