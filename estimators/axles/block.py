"""A block of aligned hub accelerations in the frequency domain.

Rows are what the front hub felt where the rear wheel is now, and what the rear hub feels (`delay`), decimated by
`vertical_pressure.anti_alias`. A window of `WINDOW` samples under Hann's taper, every `HOP` samples:

    Y(f) = sqrt(2 dt / sum w^2) sum_t w_t y_t e^(-i 2 pi f t dt),    E Y Y^H = S(f), one-sided [(m/s^2)^2/Hz]

Both rows are cut after they have been aligned: cut before, the delay is a large share of the window, and what leaves
it on one side looks like a softer tyre. Windows overlap and neighbouring bins share the taper, so the log-likelihoods
of all bins of all windows count `SHARE` each: sum of |ambiguity function|^2 over the lattice, 1 / (hop times bin
width).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.vertical_pressure.anti_alias import STEP

WINDOW, HOP = 64, 16  # decimated samples: 1.024 s, 0.256 s
FIRST, LAST = 2, 25  # bins of 0.98 Hz: 2 to 24.4 Hz, below the anti-alias edge
FREQUENCIES = np.arange(FIRST, LAST + 1) / (WINDOW * STEP)  # Hz
BINS = len(FREQUENCIES)
SHARE = HOP / WINDOW
_TAPER = np.sin(np.pi * (np.arange(WINDOW) + 0.5) / WINDOW) ** 2
_TAPER *= np.sqrt(2.0 * STEP / np.sum(_TAPER**2))
_WAVES = np.exp(-2j * np.pi * np.outer(np.arange(FIRST, LAST + 1), np.arange(WINDOW)) / WINDOW) * _TAPER


def spectrum(window: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Y of a window (WINDOW, 2), shape (BINS, 2)."""
    return _WAVES @ window
