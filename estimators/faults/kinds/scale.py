"""A gain: y = a x."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import Number, ValueFault


class Scale(ValueFault):
    name = "scale"
    about = "multiplied by a factor"
    numbers = (Number("FACTOR", ""),)

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        return value * self.given[0]
