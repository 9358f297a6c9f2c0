"""Frequency of one mode from a sum of periodograms: `spectral_fit` with the mode's priors and the timing noise known so
far."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.vibration.modes import Mode
from estimators.vibration.spectral_fit import DAMPING, FREQUENCY, SIZE, TIMER, density, fit
from estimators.vibration.spectrum import EFFICIENCY, LINES, Spectrum

LEVEL_STD = 5.0  # of ln PSD: any road
WHITE_STD = 3.0
WHITE_BELOW = 3.0  # ln by which a white floor is expected below the timing noise at the mode
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
    """Fits spectra of one mode; fixed."""

    def __init__(self, mode: Mode) -> None:
        self.mode = mode
        self._lines = np.flatnonzero((mode.band[0] <= LINES) & (mode.band[1] >= LINES))
        self._f = np.ascontiguousarray(LINES[self._lines])

    def fitted(self, spectrum: Spectrum, edge_std: float, edge_ln_std: float, start: NDArray | None) -> Fitted | None:
        """None if too few lines are counted. edge_std: of the edge times [s], known to edge_ln_std (of the variance's
        ln); start: parameters to begin at."""
        count = spectrum.count[self._lines]
        seen = count > 0.0
        if seen.sum() < LEAST_LINES or self._f[seen][-1] < self.mode.highest_needed:
            return None
        power = spectrum.power[self._lines] / np.where(seen, count, 1.0)
        mean, precision = self._prior(float(power[seen].mean()), spectrum.timing / spectrum.segments, edge_std)
        precision[TIMER] = edge_ln_std**-2
        p = mean.copy() if start is None else start.copy()
        information = np.empty((SIZE, SIZE))
        fit(p, self.mode.frequency, self._f, power, EFFICIENCY * count, mean, precision, information)
        variance = float(np.linalg.inv(information)[FREQUENCY, FREQUENCY])
        if not (np.isfinite(p).all() and math.isfinite(variance) and variance > 0.0):
            return None
        at, one, both = np.array([math.exp(p[FREQUENCY])]), np.empty(1), np.empty(1)
        density(p, self.mode.frequency, at, one, both, np.empty((1, SIZE)))
        noise = max(float(both[0] - one[0]), 1e-300)
        gained = max(1.0 / variance - precision[FREQUENCY], 0.0)
        return Fitted(float(at[0]), math.sqrt(variance), gained, math.exp(p[DAMPING]), float(one[0]) / noise, p)

    def _prior(self, level: float, timing: float, edge_std: float) -> tuple[NDArray, NDArray]:
        """Means and precisions; of an average PSD `level`, timing noise per s^2 of edge time variance."""
        m = self.mode
        timer = math.log(max(timing * edge_std**2, 1e-300))
        mean = np.array(
            [
                math.log(m.frequency), math.log(m.damping), math.log(max(level, 1e-300) * 4.0 * m.damping**2),
                m.slope[0], m.bend[0], timer + 2.0 * math.log(m.frequency) - WHITE_BELOW, timer,
            ]
        )  # fmt: skip
        std = np.array([m.frequency_std, m.damping_std, LEVEL_STD, m.slope[1], m.bend[1], WHITE_STD, 1.0])
        return mean, std**-2.0
