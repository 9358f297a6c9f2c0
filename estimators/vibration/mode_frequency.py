"""Frequency of one mode from a sum of periodograms: `spectral_fit` with the mode's priors."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.vibration.modes import Mode
from estimators.vibration.spectral_fit import DAMPING, FREQUENCY, SIZE, density, fit
from estimators.vibration.spectrum import EFFICIENCY, LINES, Spectrum

LEVEL_STD = 5.0  # of ln PSD: any road
WHITE_STD = 3.0
WHITE_BELOW = 4.0  # ln by which a white floor is expected below the band's average
TIMER_STD = 1e-6 / math.sqrt(12.0)  # s, of an edge time: rounding to 1 us
TIMER_LN_STD = 3.0  # of its variance's ln: other timers, the sensor's own jitter, or next to none of it
NOISE_BAND = (135.0, 165.0)  # Hz: there is no mode
STANDS_OUT = 4.0  # std of the noise's own mean over the mode's width: below, the mode may be a bump of the noise
LEAST_LINES = 15  # with a count, for seven parameters


@dataclass(frozen=True)
class Fitted:
    """frequency: natural frequency [Hz]; ln_std: of its ln, after the prior; information: of the spectrum alone about
    ln frequency; damping: ratio; excitation: PSD of the mode over that of the noise at its frequency; parameters."""

    frequency: float
    ln_std: float
    information: float
    damping: float
    excitation: float
    parameters: NDArray[np.float64]


class ModeFrequency:
    """Fits spectra of one mode; fixed. radius: rolling radius [m]."""

    def __init__(self, mode: Mode, radius: float) -> None:
        self.mode, self._radius = mode, radius
        inside = (mode.band[0] <= LINES) & (mode.band[1] >= LINES)
        self._lines = np.flatnonzero(inside | ((NOISE_BAND[0] <= LINES) & (NOISE_BAND[1] >= LINES)))
        self._within = inside[self._lines].astype(float)
        self._f = np.ascontiguousarray(LINES[self._lines])

    def fitted(self, spectrum: Spectrum, start: NDArray | None) -> Fitted | None:
        """None if too few lines are counted, or nothing stands out of the noise. start: parameters to begin at."""
        count = spectrum.count[self._lines]
        seen, heard = count > 0.0, (count > 0.0) & (self._within > 0.0)
        if heard.sum() < LEAST_LINES or self._f[heard][-1] < self.mode.highest_needed:
            return None
        power = spectrum.power[self._lines] / np.where(seen, count, 1.0)
        mean = self._prior(
            float(power[heard].mean()),
            spectrum.timing / spectrum.segments,
            self._radius * spectrum.omega / spectrum.segments,
        )
        precision = precisions(self.mode)
        p = mean.copy() if start is None else start.copy()
        information = np.empty((SIZE, SIZE))
        fit(
            p,
            self.mode.frequency,
            self._f,
            self._within,
            spectrum.white[self._lines] / np.where(seen, count, 1.0),
            power,
            EFFICIENCY * spectrum.worth * count,
            mean,
            precision,
            information,
        )
        variance = float(np.linalg.inv(information)[FREQUENCY, FREQUENCY])
        if not (np.isfinite(p).all() and math.isfinite(variance) and variance > 0.0):
            return None
        at, one, both = np.array([math.exp(p[FREQUENCY])]), np.empty(1), np.empty(1)
        white = np.interp(at, self._f[seen], spectrum.white[self._lines][seen] / count[seen])
        density(p, self.mode.frequency, at, np.ones(1), white, one, both, np.empty((1, SIZE)))
        noise = max(float(both[0] - one[0]), 1e-300)
        ordinates = EFFICIENCY * spectrum.worth * spectrum.segments * 2.0 * math.exp(p[DAMPING]) * float(at[0])
        if float(one[0]) / noise * math.sqrt(max(ordinates, 0.0)) < STANDS_OUT:
            return None
        gained = max(1.0 / variance - precision[FREQUENCY], 0.0)
        return Fitted(float(at[0]), math.sqrt(variance), gained, math.exp(p[DAMPING]), float(one[0]) / noise, p)

    def _prior(self, level: float, timing: float, speed: float) -> NDArray:
        """Means (7,); of an average PSD `level`, timing noise per s^2 of edge time variance, speed [m/s]."""
        m = self.mode
        timer = math.log(max(timing * TIMER_STD**2, 1e-300))
        return np.array(
            [
                math.log(m.frequency), math.log(m.damping), math.log(max(level, 1e-300) * 4.0 * m.damping**2),
                m.slope[0] + m.patch_slope(speed), m.bend[0], math.log(max(level, 1e-300)) - WHITE_BELOW, timer,
            ]
        )  # fmt: skip


def precisions(m: Mode) -> NDArray[np.float64]:
    """Of the priors, shape (7,)."""
    return np.array([m.frequency_std, m.damping_std, LEVEL_STD, m.slope[1], m.bend[1], WHITE_STD, TIMER_LN_STD]) ** -2.0
