"""An isotropic random surface with Gd(n) = Gd(n0) (n/n0)^-2, from three sheared periodic tiles.

Along any straight line the one-sided spectrum of the surface is Gd(n) if its two-sided plane spectrum is
    Phi(k) = C / |k|^3,   C = Gd(n0) n0^2 / 4      (2 * integral of Phi(sqrt(n^2 + q^2)) dq = 4 C / n^2),
and two parallel tracks then have ISO 8608's isotropic coherency 2 pi n b K1(2 pi n b). Waves of 0.011 to 10 cycle/m
at 0.05 m would need a tile of 128 m x 1.5 km = 77 million nodes; so |k| is shared between three tiles, each as wide
and as coarse as its own waves want, which hand over power-complementarily (cos^2, sin^2 over one octave): slices add
up exactly.

Each tile is periodic on a sheared lattice: f(x, y + width) = f(x - shift, y). For wave number kx the lateral wave
numbers are (j - kx shift)/width, so their grid slides with kx and no wave number is left out or counted twice: the
step 1/width does not bias the longest octave, and a car that crosses the road meets new ground instead of the same
few metres again.

A tile coarser than 0.05 m holds cubic B-spline coefficients; the spline's own response (sinc^4 on each axis) is
divided out where the spectrum is drawn, so the interpolated surface has the right spectrum. The finest tile holds
node heights. Its square band |kx|, |ky| <= 10 cycle/m cuts off the corners of the plane; `_square_band_gain` puts
back what slices lose.

Below 0.011 cycle/m a slice keeps only what crosses it at an angle (half of Gd(0.011) at n -> 0). Beyond its length a
tile comes round again, the three at different lengths.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.special import gamma

from testbed.roads.road import ISO_SPACING, Array

REFERENCE_WAVE_NUMBER = 0.1  # n0 [cycle/m]
LONGEST_WAVE = 1.0 / 0.011  # [m]
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)  # shear in tile lengths: successive rows stay as far apart as they can


@dataclass(frozen=True)
class Band:
    """Waves low..high [cycle/m] (hand-over to the next tile over high/2..high), grid step and tile width [m]."""

    low: float
    high: float
    step: float
    width: float
    stretch: float  # tile length in units of the wanted length, different for each

    @property
    def longest_wave(self) -> float:
        """[m]"""
        return 1.0 / self.low


BANDS = (
    Band(1.0 / LONGEST_WAVE, 0.25, 1.0, 128.0, 1.0),
    Band(0.125, 1.25, 0.2, 16.0, 1.013),
    Band(0.625, np.inf, ISO_SPACING, 4.0, 1.031),
)


@dataclass(frozen=True)
class Tile:
    """One band: coefficients (rows along y) float32 of unit Gd(n0), step in fine cells, shear in cells."""

    coefficients: NDArray[np.float32]
    ratio: int
    shift: int


def _hand_over(k: Array, high: float) -> Array:
    """Share of the power at |k| that stays below the hand-over high/2..high."""
    if not np.isfinite(high):
        return np.ones_like(k)
    octave = np.clip(np.log2(np.maximum(k, 1e-9) * 2.0 / high), 0.0, 1.0)
    return np.cos(0.5 * np.pi * octave) ** 2


def _band_share(k: Array, band: Band) -> Array:
    if band is BANDS[0]:
        return np.where(k >= band.low, _hand_over(k, band.high), 0.0)
    return _hand_over(k, band.high) - _hand_over(k, 2.0 * band.low)


def _square_band_gain(nyquist: float, points: int = 201) -> tuple[Array, Array]:
    """Gain a(n) such that Phi a(|kx|) a(|ky|), cut at +-nyquist on both axes, has slices 2 C / n^2.

    With q = n u / sqrt(1 - u^2) the slice of C/|k|^3 is C/n^2 du on -1..1, cut at nyquist; the fixed point is damped
    by a square root. Returns wave numbers and a, which goes to 1 for long waves.
    """
    n = np.linspace(0.0, nyquist, points)
    nodes, weights = np.polynomial.legendre.leggauss(48)
    limit = nyquist / np.hypot(n, nyquist)
    u = 0.5 * limit[:, None] * (nodes + 1.0)
    across = n[:, None] * u / np.sqrt(1.0 - u**2)
    gain = np.ones(points)
    for _ in range(40):
        slices = 0.5 * limit * (np.interp(across, n, gain) @ weights)
        gain = np.sqrt(gain / slices)
    return n, gain


def _spline_response(k: Array, step: float) -> Array:
    return np.sinc(k * step) ** 4


def synthesise(band: Band, length: float, rng: np.random.Generator, waviness: float = 2.0) -> Tile:
    """Draws one tile of unit Gd(n0) [m^3]: Gaussian, at least `length * band.stretch` metres long. waviness: w where
    the spectrum falls with another slope than -2; then Phi is 2 / B (k / n0)^(2 - w) times the above, B = sqrt(pi)
    Gamma(w / 2) / Gamma((w + 1) / 2), and the corners' gain is still that of slope -2 (5 % of the shortest octave)."""
    flatter = 2.0 * gamma(0.5 * waviness + 0.5) / (np.sqrt(np.pi) * gamma(0.5 * waviness))
    rows = round(band.width / band.step)
    columns = fft.next_fast_len(2 * int(np.ceil(0.5 * length * band.stretch / band.step)), real=True)
    shift = round(columns * _GOLDEN)
    half = columns // 2 + 1
    nyquist = 0.5 / band.step
    spectrum = rng.standard_normal((rows, 2 * half), dtype=np.float32).view(np.complex64)
    m = np.arange(half)
    kx = m / (columns * band.step)
    fine = band is BANDS[-1]
    gain_n, gain = _square_band_gain(nyquist) if fine else (np.zeros(1), np.ones(1))
    along = np.interp(kx, gain_n, gain) if fine else 1.0 / _spline_response(kx, band.step) ** 2
    constant = 0.25 * REFERENCE_WAVE_NUMBER**2 / (columns * rows * band.step**2)  # C dkx dky
    along = 0.5 * constant * along  # a complex normal number has power 2
    along[0] *= 2.0  # at kx = 0 and at Nyquist only the real part is used
    if columns % 2 == 0:
        along[-1] *= 2.0
    slide = (m * shift / columns) % 1.0
    for j in range(rows):
        ky = (j - slide) / band.width
        ky = np.abs((ky + nyquist) % (2.0 * nyquist) - nyquist)
        k = np.maximum(np.hypot(kx, ky), 1e-6)
        across = np.interp(ky, gain_n, gain) if fine else 1.0 / _spline_response(ky, band.step) ** 2
        power = along * across * _band_share(k, band) / (k * k * k)
        if waviness != 2.0:
            power *= flatter * (k / REFERENCE_WAVE_NUMBER) ** (2.0 - waviness)
        spectrum[j] *= np.sqrt(power)
    spectrum = fft.ifft(spectrum, axis=0, norm="forward", overwrite_x=True)
    for j in range(rows):
        turns = (slide * j / rows) % 1.0
        spectrum[j] *= np.exp(-2j * np.pi * turns)
    tile = fft.irfft(spectrum, n=columns, axis=1, norm="forward", overwrite_x=True)
    return Tile(np.ascontiguousarray(tile, dtype=np.float32), round(band.step / ISO_SPACING), shift)
