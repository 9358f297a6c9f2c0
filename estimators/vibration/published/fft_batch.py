"""Resonance as the highest line of a smoothed FFT over a batch of 30 s (SAE 2002-01-1250, Figure 2).

The paper names the batch, not the smoothing: here a moving average of the periodogram over SMOOTHING. The highest line
is not the natural frequency: the road's slope pulls it down, and white noise does not shift it but spreads it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BATCH = 30.0  # s
SMOOTHING = 4.0  # Hz, declared


def smoothed_spectrum(speed: NDArray[np.float64], rate: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequencies [Hz] and smoothed one-sided PSD [(rad/s)^2/Hz] of wheel speed [rad/s] sampled at `rate` [Hz]."""
    n = len(speed)
    place = np.arange(n) - 0.5 * (n - 1)
    level = speed - speed.mean()
    level = level - place * (level @ place) / (place @ place)
    window = np.hanning(n)
    power = 2.0 * np.abs(np.fft.rfft(level * window)) ** 2 / (rate * np.sum(window**2))
    lines = max(round(SMOOTHING * n / rate), 1)
    return np.arange(len(power)) * np.float64(rate / n), np.convolve(power, np.full(lines, 1.0 / lines), mode="same")


def peak_frequency(speed: NDArray[np.float64], rate: float, band: tuple[float, float]) -> float:
    """Highest line of a batch within the band [Hz]."""
    f, power = smoothed_spectrum(speed, rate)
    inside = (f >= band[0]) & (f <= band[1])
    return float(f[inside][np.argmax(power[inside])])
