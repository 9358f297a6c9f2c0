"""Noise added: y = x + s n, n white and standard normal, held for `HOLD` seconds (0: another for every sample); each
axis has its own. Held, it is white up to 1 / (2 HOLD) only, with the spectral density s^2 HOLD at low frequency: the
band-limited white noise of a power P, as simulation tools call it, is s = sqrt(P / HOLD)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.faults.kind import SIGNAL, Number, ValueFault


class Hiss(ValueFault):
    name = "hiss"
    about = "white noise of that standard deviation added"
    numbers = (Number("STD", SIGNAL, 0.0), Number("HOLD", "s", 0.0, 3600.0, 0.0))

    def faulty(self, time: NDArray[np.float64], value: NDArray[np.float64]) -> NDArray[np.float64]:
        size, hold = self.given
        at = np.floor((time - self.start) / hold + 1e-6) if hold > 0.0 else time
        draws = [self.chance.normal(at, stream) for stream in range(value.shape[1])]
        return value + size * np.stack(draws, axis=1)
