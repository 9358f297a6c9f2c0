"""Roughness of a profile: its one-sided displacement spectrum Gd(n) [m^3] over n [cycle/m], and its ISO 8608 class."""

from __future__ import annotations

import numpy as np

from testbed.roads.iso8608 import CLASSES, class_gd
from testbed.roads.random_field import LONGEST_WAVE, REFERENCE_WAVE_NUMBER
from testbed.roads.road import Array

FIT_BAND = (1.0 / LONGEST_WAVE, 10.0)  # [cycle/m]


def periodogram(z: Array, spacing: float) -> tuple[Array, Array]:
    """n [cycle/m] and Gd [m^3] of a profile z [m], shape (n,): straight line removed, Hann window, n = 0 left out."""
    z = np.asarray(z, dtype=np.float64)
    t = np.linspace(-1.0, 1.0, len(z))
    window = np.hanning(len(z))
    level = z - z.mean()
    level = level - t * (t @ level) / (t @ t)
    power = np.abs(np.fft.rfft(level * window)) ** 2 * 2.0 * spacing / (window @ window)
    return np.asarray(np.fft.rfftfreq(len(z), spacing)[1:], dtype=np.float64), power[1:]


def octave_means(n: Array, ratio: Array, low: float, high: float) -> tuple[Array, Array]:
    """Lower edges [cycle/m] of the octaves from low to high, and the mean of `ratio` in each that has samples."""
    edges = low * 2.0 ** np.arange(np.ceil(np.log2(high / low) - 1e-9) + 1)
    edges[-1] = high
    octave = np.searchsorted(edges, n, side="right") - 1
    inside = (octave >= 0) & (octave < len(edges) - 1) & (n < high)
    counts = np.bincount(octave[inside], minlength=len(edges) - 1)
    sums = np.bincount(octave[inside], weights=ratio[inside], minlength=len(edges) - 1)
    return edges[:-1][counts > 0], sums[counts > 0] / counts[counts > 0]


def fitted_gd(z: Array, spacing: float) -> float:
    """Gd(0.1 cycle/m) [m^3] of the slope-2 law nearest to a profile: median over octaves of Gd(n) (n/n0)^2.

    The median passes over octaves that a measurement does not hold: waves longer than it or shorter than its steps.
    """
    n, power = periodogram(z, spacing)
    _, level = octave_means(n, power * (n / REFERENCE_WAVE_NUMBER) ** 2, *FIT_BAND)
    return float(np.median(level))


def iso_class(gd: float) -> str:
    """ISO 8608 class of a Gd(n0) [m^3], a factor 2 either way; far below A is `flat`, beyond H is `above H`."""
    if gd < 0.5 * class_gd("A"):
        return "flat" if gd < 1e-3 * class_gd("A") else "A"
    step = int(np.floor(np.log(gd / (0.5 * class_gd("A"))) / np.log(4.0)))
    return CLASSES[step] if step < len(CLASSES) else "above H"
