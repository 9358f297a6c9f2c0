"""A sine added: y = x + a sin(2 pi f (t - start)); all axes alike."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import SIGNAL, Number, ValueFault


class Sine(ValueFault):
    name = "sine"
    about = "a sine added"
    numbers = (Number("AMPLITUDE", SIGNAL), Number("FREQUENCY", "Hz", 0.0, 1e4))

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        size, frequency = self.given
        return value + size * np.sin(2.0 * np.pi * frequency * (time - self.start))[:, None]
