"""A road of an ISO 8608 class as filtered white noise in time, for a given speed.

Brancati & Tufano, Machines 2022, 10, 1221, eq. 5 to 7. Class a (A = 0 ... H = 7) has at 1 rad/m the one-sided spectrum
G = 4^a 1e-6 m^2/(rad/m), falling with slope -2. A first-order filter with corner alpha [rad/m] gives that above alpha:

    dz_r/dt = -alpha v z_r + eta,    var z_r = sigma^2,    G_d(W) = (2 alpha sigma^2 / pi) / (alpha^2 + W^2)

For W >> alpha this is G (1 rad/m)^2 / W^2 if sigma^2 = pi G / (2 alpha), which for alpha = 0.127 rad/m is 4 pi G within
2 %. The paper's 4 G makes every road 0.32 of its class. Discretised exactly, eta of intensity q = pi v G:

    z(k+1) = phi z(k) + w,    phi = exp(-alpha v dt),    var w = sigma^2 (1 - phi^2)

Left out: slope other than -2, waves longer than 2 pi / alpha = 50 m.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

CLASSES = "ABCDEFGH"
CORNER = 0.127  # alpha [rad/m], as published
_N0 = 0.1  # cycle/m at which ISO 8608 states G_d


def class_spectrum(road_class: str) -> float:
    """G of a class A to H, or of a number a = 0 ... 7 that stands between classes: 4^a 1e-6 [m^3/rad]. ValueError."""
    if road_class not in CLASSES or len(road_class) != 1:
        raise ValueError(f"no road class {road_class!r}, valid: {', '.join(CLASSES)}")
    return 1e-6 * 4.0 ** CLASSES.index(road_class)


def spectrum_from_gd(gd: float) -> float:
    """G at 1 rad/m [m^3/rad] from G_d(0.1 cycle/m) [m^3]: 2 pi n0^2 G_d."""
    return 2.0 * math.pi * _N0**2 * gd


def intensity(spectrum: float, speed: float) -> float:
    """q of the white noise that drives the road's height, E[eta(t) eta(s)] = q delta(t - s) [m^2/s]: pi v G."""
    return math.pi * speed * spectrum


def variance(spectrum: float, corner: float = CORNER) -> float:
    """sigma^2 of the height [m^2]."""
    return math.pi * spectrum / (2.0 * corner)


def shaping(spectrum: float, speed: float, dt: float, corner: float = CORNER) -> tuple[float, float]:
    """(phi, var w [m^2]) of one step dt [s] at a speed [m/s]; at standstill (1, 0)."""
    decay = 2.0 * corner * speed * dt
    return math.exp(-0.5 * decay), -variance(spectrum, corner) * math.expm1(-decay)


def synthesised(
    spectrum: float, speed: float, dt: float, steps: int, rng: np.random.Generator, corner: float = CORNER
) -> NDArray[np.float64]:
    """A road's height every dt [s] [m], shape (steps,), begun in its stationary distribution."""
    from scipy.signal import lfilter

    phi, spread = shaping(spectrum, speed, dt, corner)
    noise = rng.standard_normal(steps) * math.sqrt(spread)
    noise[0] = rng.standard_normal() * math.sqrt(variance(spectrum, corner))
    return np.asarray(lfilter([1.0], [1.0, -phi], noise))
