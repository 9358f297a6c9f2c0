"""What a hub's decimated acceleration looks like to the bank: its autocovariance, for any road of `roughness`.

The quarter car, belt and footprint of `chain` in the frequency domain (the footprint's delay in the same Pade form):

    k_s = k + i w c        b = c_b + c_r - w^2 m_b        z_b = (c_r F z_r + c_b z_us) / b
    z_us (k_s + c_b - w^2 m_us - c_b^2 / b - k_s^2 / (k_s - w^2 m_s)) = c_b c_r F z_r / b
    |F|^2 = (1 - x^2/12)^2 / ((1 - x^2/12)^2 + x^2/4),    x = w l / v

times the road's spectrum at Omega = w / v, G(Omega) 2 pi / v [m^2/Hz], the intake's high-pass and low-pass. Sampled at
the decimated rate: the spectrum is folded, and its inverse Fourier transform is the autocovariance. lambda = 1; the
sensor's noise and the model's error are white and join at lag 0 (`bank`).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from estimators.vertical_pressure.anti_alias import HIGH_PASS, STEP, analogue
from estimators.vertical_pressure.chain import REFERENCE_STIFFNESS, SIDEWALL, Quarter
from estimators.vertical_pressure.roughness import shape

POINTS = 1024  # of the circle of lags: 16 s, after which nothing is left
_IMAGES = 2  # of the sampling rate, either side: beyond 94 Hz the low-pass leaves nothing


@cache
def _heard() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequencies [Hz] that fold onto each of the grid's, (2 _IMAGES, POINTS / 2 + 1), and the gain of both filters."""
    base, rate = np.fft.rfftfreq(POINTS, STEP), 1.0 / STEP
    frequency = np.concatenate([[m * rate + base, (m + 1) * rate - base] for m in range(_IMAGES)])
    frequency = np.maximum(frequency, 1e-3 * base[1])
    A, B, C = analogue()
    values, vectors = np.linalg.eig(A)
    residues = (C @ vectors) * np.linalg.solve(vectors, B.astype(complex))
    low = np.abs((residues / (2j * np.pi * frequency[..., None] - values)).sum(axis=-1)) ** 2
    return frequency, low * frequency**2 / (frequency**2 + HIGH_PASS**2)


def hub_gain(
    quarter: Quarter, stiffness: NDArray[np.float64], speed: float, frequency: NDArray[np.float64]
) -> NDArray[np.float64]:
    """|hub acceleration / road height|^2 [1/s^4] for k_t (m,) [N/m], v [m/s], at frequencies of any shape [Hz],
    (m, ...)."""
    k = stiffness.reshape(-1, *[1] * frequency.ndim)
    w = 2.0 * np.pi * frequency
    w2 = w * w
    sidewall, contact = SIDEWALL * k, SIDEWALL / (SIDEWALL - 1.0) * k
    strut = quarter.spring_rate + 1j * w * quarter.damping
    belt = sidewall + contact - w2 * quarter.belt_mass
    body = strut * strut / (strut - w2 * quarter.sprung_mass)
    wheel = strut + sidewall - w2 * quarter.unsprung_mass - sidewall**2 / belt - body
    x2 = (w * quarter.footprint * (k / REFERENCE_STIFFNESS) ** -quarter.softer / speed) ** 2
    straight = (1.0 - x2 / 12.0) ** 2
    foot = straight / (straight + 0.25 * x2)
    return np.asarray(foot * np.abs(w2 * sidewall * contact / belt / wheel) ** 2)


def autocovariance(
    quarter: Quarter,
    stiffness: NDArray[np.float64],
    speed: float,
    long: NDArray[np.float64],
    short: NDArray[np.float64],
    lags: int,
) -> NDArray[np.float64]:
    """Of the noiseless decimated signal for lambda = 1 at lags 0 ... lags, (stiffnesses, longs, shorts, lags + 1)
    [(m/s^2)^2 per m^3/rad]."""
    frequency, gain = _heard()
    heard = hub_gain(quarter, stiffness, speed, frequency) * gain
    omega = 2.0 * np.pi * frequency / speed
    road = shape(omega, long[:, None, None, None], short[:, None, None]) * (2.0 * np.pi / speed)
    folded = np.einsum("kif,lsif->klsf", heard, road)
    return np.fft.irfft(folded, POINTS, axis=-1)[..., : lags + 1] * (0.5 / STEP)
