"""A constant added: y = x + b."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import SIGNAL, Number, ValueFault


class Bias(ValueFault):
    name = "bias"
    about = "a constant added"
    numbers = (Number("SIZE", SIGNAL),)

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        return value + self.given[0]
