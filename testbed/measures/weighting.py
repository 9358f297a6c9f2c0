"""Frequency weighting Wk of ISO 2631-1 (vertical, seat): how much of an acceleration a sitting person feels.

ISO 2631-1:1997, annex A, with s = 2 pi i f, w = 2 pi f_k:

    high pass    s^2 / (s^2 + s w1/Q1 + w1^2)                                    f1 0.4 Hz,  Q1 1/sqrt(2)
    low pass     1 / (1 + s/(Q2 w2) + (s/w2)^2)                                  f2 100 Hz,  Q2 1/sqrt(2)
    transition   (1 + s/w3) / (1 + s/(Q4 w4) + (s/w4)^2)                         f3 = f4 12.5 Hz,  Q4 0.63
    step         (1 + s/(Q5 w5) + (s/w5)^2) / (1 + s/(Q6 w6) + (s/w6)^2) (w5/w6)^2   f5 2.37, f6 3.35 Hz, Q5 = Q6 0.91
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

F1, F2, F3, F4, F5, F6 = 0.4, 100.0, 12.5, 12.5, 2.37, 3.35  # Hz
Q1 = Q2 = math.sqrt(0.5)
Q4, Q5, Q6 = 0.63, 0.91, 0.91
TRANSIENT = 2.0  # s at the start of a record in which the filter, at rest before it, settles


def wk(frequency: ArrayLike) -> NDArray[np.complex128]:
    """Complex response of the weighting [-] at frequencies [Hz]."""
    s = 2j * np.pi * np.asarray(frequency, float)
    w1, w2, w3, w4, w5, w6 = (2.0 * np.pi * f for f in (F1, F2, F3, F4, F5, F6))
    high = s**2 / (s**2 + s * w1 / Q1 + w1**2)
    low = 1.0 / (1.0 + s / (Q2 * w2) + (s / w2) ** 2)
    transition = (1.0 + s / w3) / (1.0 + s / (Q4 * w4) + (s / w4) ** 2)
    step = (1.0 + s / (Q5 * w5) + (s / w5) ** 2) / (1.0 + s / (Q6 * w6) + (s / w6) ** 2) * (w5 / w6) ** 2
    return np.asarray(high * low * transition * step)


def weighted_rms(accel: NDArray[np.float64], rate: float) -> float:
    """Root mean square of the weighted acceleration, in the unit of `accel`, shape (n,), sampled at `rate` [Hz].

    The filter acts in the frequency domain on the record followed by as much silence, so that its end does not reach
    round to its start; the first TRANSIENT seconds are left out of the mean.
    """
    n = len(accel)
    spectrum = np.fft.rfft(accel - accel.mean(), 2 * n) * wk(np.fft.rfftfreq(2 * n, 1.0 / rate))
    felt = np.fft.irfft(spectrum, 2 * n)[round(TRANSIENT * rate) : n]
    return float(np.sqrt(np.mean(felt**2)))
