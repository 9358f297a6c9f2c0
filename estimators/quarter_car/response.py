"""The linear quarter car in the frequency domain: what a road of a given roughness makes body and hub feel.

Without k3 and c2 (`quarter_car`), with D the dynamic stiffness matrix for e^(i w t), travel force k + i w c:

    [ -w^2 m_s + k + i w c        -(k + i w c)              ] [Z_s ]   [  0  ]
    [ -(k + i w c)          -w^2 m_us + k + i w c + k_t     ] [Z_us] = [k_t  ] Z_r

Accelerations are -w^2 Z. Spectra are one-sided over f [Hz]: a road of class spectrum G (`road_shape`) at speed v has
S_r = G v / (2 pi f^2) [m^2/Hz]; a sensor that samples at rate f_s with white noise of std sigma has 2 sigma^2 / f_s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.quarter_car.quarter_car import QuarterCar


def road_spectrum(
    frequency: NDArray[np.float64], spectrum: float | NDArray[np.float64], speed: float
) -> NDArray[np.float64]:
    """S_r of the height [m^2/Hz] at frequencies [Hz] above 0; spectrum: G at 1 rad/m [m^3/rad], or G Omega^2 of each
    frequency where the slope is not -2; speed [m/s]."""
    return spectrum * speed / (2.0 * np.pi * frequency**2)


def response(quarter: QuarterCar, tyre_stiffness: float, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Accelerations [a_s, a_us] per road height [1/s^2], shape (n, 2), of the linear part of `quarter`."""
    w = 2.0 * np.pi * frequency
    strut = quarter.spring_rate + 1j * w * quarter.damping
    body = strut - w**2 * quarter.sprung_mass
    wheel = strut + tyre_stiffness - w**2 * quarter.unsprung_mass
    determinant = body * wheel - strut**2
    heights = np.stack([strut * tyre_stiffness, body * tyre_stiffness], axis=1) / determinant[:, None]
    return -(w**2)[:, None] * heights


def measured_spectrum(
    quarter: QuarterCar,
    tyre_stiffness: float,
    spectrum: float | NDArray[np.float64],
    speed: float,
    noise_density: float,
    frequency: NDArray[np.float64],
) -> NDArray[np.complex128]:
    """Spectral matrix of [a_s, a_us] as measured [(m/s^2)^2/Hz], shape (n, 2, 2); noise_density: of each sensor."""
    h = response(quarter, tyre_stiffness, frequency)
    road = road_spectrum(frequency, spectrum, speed)
    return road[:, None, None] * h[:, :, None] * h[:, None, :].conj() + noise_density * np.eye(2)
