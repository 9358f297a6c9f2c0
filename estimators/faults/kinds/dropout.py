"""Lost messages: a random share of the samples never arrives; 1 is silence. Of a wheel's sensor (`wheel/rr`) edges and
speeds of the same cells of 10 ms are lost."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import LossFault, Number


class Dropout(LossFault):
    name = "dropout"
    about = "a share of the messages is lost, 1 for all"
    numbers = (Number("SHARE", "", 0.0, 1.0, 1.0),)

    def lost(self, time: NDArray[np.float64]) -> NDArray[np.bool_]:
        return self.chance.uniform(time) < self.given[0]
