"""Aberrant samples: y = x + a at a random share of the samples, y = x otherwise. All axes are hit together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import SIGNAL, Number, ValueFault


class Spike(ValueFault):
    name = "spike"
    about = "a share of the samples is off by a size"
    numbers = (Number("SIZE", SIGNAL), Number("SHARE", "", 0.0, 1.0, 0.01))

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        size, share = self.given
        return value + np.where(self.chance.uniform(time) < share, size, 0.0)[:, None]
