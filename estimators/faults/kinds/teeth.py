"""A ring of another tooth count than the car reckons with: omega' = omega n / n0, n0 of the car."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import Number, ValueFault


class Teeth(ValueFault):
    name = "teeth"
    about = "a ring of that many teeth"
    numbers = (Number("COUNT", "", 2.0, 1000.0),)
    wheels_only = True

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        return value * (self.given[0] / self.teeth)
