"""Frequency of one torsional mode from a short block of wheel speed: the posterior over a grid of spectra (Whittle).

Spectrum of wheel speed y(t), RATE Hz, in the mode's band, frequency f [Hz]:

    S(f) = g [ exp(s u + b u^2) / ((1 - (f/f0)^2)^2 + (2 zeta f/f0)^2) / peak + n ],   u = ln(f / fc)

f0 the natural frequency, zeta the damping, s and b slope and bend of what excites the mode (road, contact patch, other
modes), n the timer's noise over the mode's peak; fc the band's middle. Every combination of a grid is a template; the
gain g is maximised in closed form (g = mean of P/S), the rest is summed over with equal weights, so that what is not
known of the road widens the result and does not bias it. With P the mean of the block's spectra in TAPERS sine tapers
(Riedel, Sidorenko, IEEE Trans. Signal Process. 43 (1995) 188), which together weigh nearly all of the block evenly,

    ln L = -w sum(ln S + P / (g S)),   w = INDEPENDENT of the bins

Result: mean and std of ln f0 as a likelihood, that is with the grid's own spread taken out (1/v = 1/v_post - 1/v_grid).
A block that hardly narrows the grid says nothing: NaN. Sources: Whittle 1953; the two-mode model of a wheel on its
tyre, Zegelaar 1998. The antiphase mode (rim against belt, some 85 Hz) follows the sidewall's torsion and little else;
the in-phase mode (some 40 Hz), damped by slip more the faster the car, is what is left at low speed. Below 47 km/h the
contact patch, as long as the wave, cuts the antiphase peak's upper side; templates that fall as steeply still tell its
frequency down to 40 km/h, less well and lower than it is, as a calibration at these speeds learns. While the car gains
speed the in-phase mode of driven wheels comes out a tenth lower and more, of others now and then by half; so it is not
read then.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_speed.resampling import RATE

BLOCK = 2.0  # s
SIZE = round(RATE * BLOCK)
TAPERS = 4  # half a band of (TAPERS + 1) / (2 BLOCK) = 1.25 Hz, a fifth of a mode's half-width
INDEPENDENT = 1.0 / (1.0 + 0.5 / TAPERS)  # share of the bins: 1 / (n sum q^2), q the mean of the squared tapers
INFORMED = 0.6  # of the grid's variance: a posterior wider than that says nothing
LEAST_BINS = 0.5  # of the band


@dataclass(frozen=True)
class Band:
    """low, high: of the band; f0: least and largest natural frequency and the step of its grid [Hz]; damping, slope,
    bend, noise: the grid's other axes; slowest, fastest: speeds between which it is read [m/s] (compare
    `estimators.vibration.modes`); steadiest: change of speed up to which it is [m/s^2]."""

    name: str
    low: float
    high: float
    f0: tuple[float, float, float]
    damping: tuple[float, ...]
    slope: tuple[float, ...]
    bend: tuple[float, ...]
    noise: tuple[float, ...]
    slowest: float
    fastest: float
    steadiest: float


# the axes are as fine as a block can tell them apart: with steps of 4 in slope the frequency went from one to the other
ANTIPHASE = Band(
    "antiphase",
    60.0,
    114.0,
    (62.0, 104.0, 1.0),
    (0.066, 0.078),
    (-10, -7.5, -5, -2.5, 0, 2.5),
    (-4, 1, 6),
    (0, 0.015, 0.07, 0.3, 1.0),
    11.0,
    np.inf,
    np.inf,
)
IN_PHASE = Band(
    "in_phase",
    24.0,
    64.0,
    (30.0, 54.0, 0.75),
    (0.1, 0.15, 0.22),
    (-6, -2, 2),
    (-1, 4, 9),
    (0, 0.1, 0.5),
    9.0,
    16.0,
    0.5,
)


class ModeGrid:
    """The templates of a band."""

    def __init__(self, band: Band) -> None:
        self.band = band
        frequency = np.fft.rfftfreq(SIZE, 1.0 / RATE)
        self._inside = (frequency >= band.low) & (frequency <= band.high)
        f = frequency[self._inside]
        middle = np.sqrt(band.low * band.high)
        natural = np.arange(band.f0[0], band.f0[1] + 0.5 * band.f0[2], band.f0[2])
        axes = np.meshgrid(natural, band.damping, band.slope, band.bend, band.noise, indexing="ij")
        f0, zeta, slope, bend, noise = (axis.reshape(-1, 1) for axis in axes)
        response = 1.0 / ((1.0 - (f / f0) ** 2) ** 2 + (2.0 * zeta * f / f0) ** 2)
        u = np.log(f / middle)
        spectra = response / response.max(axis=1, keepdims=True) * np.exp(slope * u + bend * u**2) + noise
        self._log = np.log(spectra).astype(np.float32)
        self._inverse = (1.0 / spectra).astype(np.float32)
        self._log_f0 = np.log(f0[:, 0])
        self.frequency = f
        self._mean, self._variance = float(self._log_f0.mean()), float(self._log_f0.var())
        turn = np.pi * np.arange(1, SIZE + 1) / (SIZE + 1)
        self._tapers = np.sin(np.outer(np.arange(1, TAPERS + 1), turn))

    def fit(self, speed: NDArray[np.float64], used: NDArray[np.bool_]) -> NDArray[np.float64]:
        """speed: [rad/s], shape (wheels, SIZE); used: bins of the band that count, of `frequency`, shape (wheels,
        bins) -> mean and std of ln f0, shape (wheels, 2); NaN where nothing is said."""
        level = speed - speed.mean(axis=1, keepdims=True)
        ramp = np.arange(SIZE) - 0.5 * (SIZE - 1)
        level = level - np.outer(level @ ramp / (ramp @ ramp), ramp)
        seen = np.fft.rfft(level[:, None, :] * self._tapers, axis=2)[:, :, self._inside]
        power = np.mean(np.abs(seen) ** 2, axis=1)
        bins = used.sum(axis=1)
        usable = np.isfinite(power).all(axis=1) & (power.sum(axis=1) > 0.0) & (bins >= LEAST_BINS * used.shape[1])
        scale = np.where(usable, np.nan_to_num(power).mean(axis=1), 1.0)[:, None]
        scaled = np.where(usable[:, None] & used, np.nan_to_num(power) / scale, 0.0)
        bins = np.maximum(bins, 1)
        gain = np.maximum((self._inverse @ scaled.T.astype(np.float32)).astype(np.float64), 1e-30) / bins
        log_sum = (self._log @ used.T.astype(np.float32)).astype(np.float64)
        log_likelihood = -INDEPENDENT * (log_sum + bins * np.log(gain))
        weight = np.exp(log_likelihood - log_likelihood.max(axis=0))
        weight /= weight.sum(axis=0)
        mean = self._log_f0 @ weight
        variance = np.maximum((self._log_f0**2) @ weight - mean**2, 1e-7)
        told = usable & (variance < INFORMED * self._variance)
        sharper = np.where(told, 1.0 / variance - 1.0 / self._variance, np.nan)
        value = (mean / variance - self._mean / self._variance) / sharper
        return np.stack([np.where(told, value, np.nan), np.where(told, sharper**-0.5, np.nan)], axis=1)
