"""The Cramer-Rao (Whittle) bound of a mode's frequency for a spectrum of the model of `spectral_fit`.

A record of T seconds holds T independent periodogram ordinates a Hz, so the information about the parameters is
T integral (d ln S / d p)(d ln S / d p)' df over the band, plus that of the priors, and the bound of ln f0 the first
element of its inverse: level, slope, bend, damping and both floors are as unknown as they are to the estimator.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.vibration.mode_frequency import NOISE_BAND, precisions
from estimators.vibration.modes import Mode
from estimators.vibration.spectral_fit import FREQUENCY, SIZE, density
from estimators.wheel_speed.resampling import USABLE, droop

STEP = 0.25  # Hz


def frequency_bound(mode: Mode, parameters: NDArray[np.float64], seconds: float, tooth_rate: float) -> float:
    """Least std of the frequency [Hz] from `seconds` of record at a tooth rate [Hz], of a spectrum (7,)."""
    highest = USABLE * tooth_rate
    inside = np.arange(mode.band[0], min(mode.band[1], highest), STEP)
    above = np.arange(NOISE_BAND[0], min(NOISE_BAND[1], highest), STEP)
    f = np.concatenate([inside, above])
    within = np.concatenate([np.ones(len(inside)), np.zeros(len(above))])
    slopes = np.empty((len(f), SIZE))
    white = droop(f, tooth_rate) ** -2.0
    density(parameters, mode.frequency, f, within, white, np.empty(len(f)), np.empty(len(f)), slopes)
    information = seconds * STEP * slopes.T @ slopes + np.diag(precisions(mode))
    return float(np.exp(parameters[FREQUENCY]) * np.sqrt(np.linalg.inv(information)[FREQUENCY, FREQUENCY]))
