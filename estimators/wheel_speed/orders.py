"""Spectral lines within the wheel orders: what turns with the wheel is no vibration of it.

Order n of a wheel that turns at omega lies at n omega / 2 pi. Pitch errors put something into every order up to half
the teeth until they are learnt, tyre and rim into the first few for good.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

WIDTH = 1.5  # Hz either way: the main lobe of a Hann window of 1 s, at half a line from its centre


def order_lines(
    frequency: NDArray[np.float64], omega: float, change: float, highest: int
) -> NDArray[np.bool_]:  # fmt: skip
    """Which lines lie within an order 1 to `highest`. frequency [Hz]: shape (n,); omega: mean speed [rad/s]; change: of
    it over the record [rad/s], which widens order n by n change / 2 pi."""
    turn = omega / (2.0 * math.pi)
    order = np.clip(np.rint(frequency / turn), 1, highest)
    return np.abs(frequency - order * turn) <= WIDTH + 0.5 * order * change / (2.0 * math.pi)
