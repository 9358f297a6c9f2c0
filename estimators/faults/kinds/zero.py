"""Total loss, the line reads zero: y = 0. A wheel's ring gives no edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import ValueFault


class Zero(ValueFault):
    name = "zero"
    about = "reads zero"

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.zeros_like(value)
