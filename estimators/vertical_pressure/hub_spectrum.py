"""What a hub's decimated acceleration looks like to the bank: its autocovariance, for any road of two slopes.

The quarter car, belt and footprint of `chain` in the frequency domain (the footprint without its Pade form, which at 10
m/s puts the wave that two cams do not feel 10 % too high), and the body, which is shared with the other axle of its
side; that rolls over the same road a wheelbase earlier or later (equations: `axles.response`; the body rolls, 1 / m_c):

    F = (k + i w c) (z_us - z_s)        -w^2 z_s = F / m_s + F_o / m_c        -w^2 z_so = F_o / m_so + F / m_c
    |foot|^2 = cos(w l / 2 v)^2 + BLIND

The other axle makes a comb of +-8 % over w wheelbase / v of the hub's spectrum. Where the road's slopes are known it
averages out over the band; where they are not it tilts the spectrum, and k_t was 9 % of a factor e of speed off without
it. The other tyre counts as stiff as this one. Times the road's spectrum at Omega = w / v, G(Omega) 2 pi / v [m^2/Hz],
the intake's high-pass and low-pass; sampled at the decimated rate: the spectrum is folded, and its inverse Fourier
transform is the autocovariance. lambda = 1 (`quarter_car.roughness`); the sensor's noise and the model's error are
white and join at lag 0 (`bank`).
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import kv

from estimators.quarter_car.roughness import shape
from estimators.vertical_pressure.anti_alias import HIGH_PASS, STEP, analogue
from estimators.vertical_pressure.chain import REFERENCE_STIFFNESS, SIDEWALL, Quarter

BLIND = 0.02  # of |foot|^2: a contact patch has a width, and no wave at which nothing comes through
POINTS = 1024  # of the circle of lags: 16 s, after which nothing is left
_IMAGES = 2  # of the sampling rate, either side: beyond 94 Hz the low-pass leaves nothing


class Beside(NamedTuple):
    """The other axle of that side. coupling: 1 / m_c [1/kg]; later: how far behind this wheel the other one is [m],
    negative for one in front; track [m]."""

    quarter: Quarter
    coupling: float
    later: float
    track: float


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
    quarter: Quarter, beside: Beside, stiffness: NDArray[np.float64], speed: float, frequency: NDArray[np.float64]
) -> NDArray[np.float64]:
    """|hub acceleration / road height|^2 [1/s^4] for k_t (m,) [N/m], the other axle's as well, v [m/s], at frequencies
    of any shape [Hz], (m, ...)."""
    k = stiffness.reshape(-1, *[1] * frequency.ndim)
    w = 2.0 * np.pi * frequency
    w2 = w * w
    s, d, r = _corner(quarter, k, speed, w)
    so, do, ro = _corner(beside.quarter, k, speed, w)
    ro = ro * np.exp(-1j * w * beside.later / speed)
    coupling = beside.coupling * (1.0 - coherency(w / speed * beside.track))
    # F = p + q z_s of each, see `axles.response`
    p, po = s * r / d, so * ro / do
    q, qo = s * (s / d - 1.0) / w2, so * (so / do - 1.0) / w2
    a, b = 1.0 + q / quarter.sprung_mass, q * coupling
    e, c = 1.0 + qo / beside.quarter.sprung_mass, qo * coupling
    determinant = a * e - b * c
    force, force_o = (e * p - b * po) / determinant, (a * po - c * p) / determinant
    body = -(force / quarter.sprung_mass + coupling * force_o) / w2
    return np.asarray(np.abs(w2 * (r + s * body) / d) ** 2)


def coherency(rho: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of two parallel tracks, rho = Omega times their distance, on an isotropic road of slope -2: rho K_1(rho)
    (`axles.off_tracking`)."""
    return np.asarray(rho * kv(1, np.clip(rho, 1e-9, 50.0)))


def _corner(
    quarter: Quarter, k: NDArray[np.float64], speed: float, w: NDArray[np.float64]
) -> tuple[NDArray[np.complex128], NDArray[np.complex128], NDArray[np.float64]]:
    """Strut, dynamic stiffness of the wheel on its belt, force of the road on it per height."""
    w2 = w * w
    sidewall, contact = SIDEWALL * k, SIDEWALL / (SIDEWALL - 1.0) * k
    strut = quarter.spring_rate + 1j * w * quarter.damping
    belt = sidewall + contact - w2 * quarter.belt_mass
    wheel = strut + sidewall - w2 * quarter.unsprung_mass - sidewall**2 / belt
    x = w * quarter.footprint * (k / REFERENCE_STIFFNESS) ** -quarter.softer / speed
    foot = np.sqrt(np.cos(0.5 * x) ** 2 + BLIND)
    return np.asarray(strut), np.asarray(wheel), np.asarray(foot * sidewall * contact / belt)


def autocovariance(
    quarter: Quarter,
    beside: Beside,
    stiffness: NDArray[np.float64],
    speed: float,
    long: NDArray[np.float64],
    short: NDArray[np.float64],
    lags: int,
) -> NDArray[np.float64]:
    """Of the noiseless decimated signal for lambda = 1 at lags 0 ... lags, (stiffnesses, longs, shorts, lags + 1)
    [(m/s^2)^2 per m^3/rad]."""
    frequency, gain = _heard()
    heard = hub_gain(quarter, beside, stiffness, speed, frequency) * gain
    omega = 2.0 * np.pi * frequency / speed
    road = shape(omega, long[:, None, None, None], short[:, None, None]) * (2.0 * np.pi / speed)
    folded = np.einsum("kif,lsif->klsf", heard, road)
    return np.fft.irfft(folded, POINTS, axis=-1)[..., : lags + 1] * (0.5 / STEP)
