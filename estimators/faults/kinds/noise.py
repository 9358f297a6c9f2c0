"""Total loss, only a random process is left: y = s n, n white and standard normal; each axis has its own. A wheel's
speed and edges follow the same process, constant over cells of 10 ms, edges its size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import SIGNAL, Number, ValueFault


class Noise(ValueFault):
    name = "noise"
    about = "nothing but white noise of that standard deviation"
    numbers = (Number("STD", SIGNAL, 0.0),)

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        draws = [self.chance.normal(time, stream) for stream in range(value.shape[1])]
        return self.given[0] * np.stack(draws, axis=1)
