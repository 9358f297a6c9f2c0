"""What likelihood leaves open of an identified corner: its scale, and how wrong k_t stays however long one drives.

The hub's motion over an unknown road is the same if masses, spring, damper and tyre are all multiplied by one factor:
only the known stiffness fixes it, and a fit whose model is not quite the car's leaves a little of it (0.5 %). It is set
so that ln k_t is right in the mean of the drives. What then scatters beyond the posterior's own variance is systematic:

    stiffness_std^2 = mean(e^2 - s^2),    e = E[ln k_t] - ln k_t,    s^2 = var ln k_t    under a flat prior
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.vertical_pressure.anti_alias import STEP
from estimators.vertical_pressure.bank import AxleBank, heard_by
from estimators.vertical_pressure.chain import Quarter
from estimators.vertical_pressure.corner import Corner
from estimators.vertical_pressure.hub_spectrum import Beside
from estimators.vertical_pressure.identify import SETTLE, KnownDrive
from estimators.vertical_pressure.posterior import LOG_STIFFNESS, Posterior, moments
from estimators.vertical_pressure.prediction import MEMORY

SCALED = ("sprung_mass", "unsprung_mass", "belt_mass", "spring_rate", "damping")
BLOCK = 64  # samples: what is known of the level within one is still wider than a cell
LEAST_STD = 0.003  # Declared: no tuning drives show less


def log_stiffness(quarter: Quarter, beside: Beside, drive: KnownDrive) -> tuple[float, float]:
    """Mean and std of ln k_t after a whole drive, the road as unknown as in the estimator."""
    filters, log_variance = AxleBank(quarter, beside).at(drive.speed)
    posterior = Posterior(np.ones(len(LOG_STIFFNESS)))
    for first in range(SETTLE, len(drive.samples) - BLOCK + 1, BLOCK):
        posterior.pass_time(BLOCK * STEP)
        heard = drive.samples[first - MEMORY : first + BLOCK].copy()
        posterior.take(heard_by(filters, heard), log_variance, BLOCK)
    return moments(posterior.stiffness(), LOG_STIFFNESS)


def errors(
    quarter: Quarter, beside: Beside, drives: Sequence[KnownDrive]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """e and s of each drive, (n,)."""
    said = np.array([log_stiffness(quarter, beside, drive) for drive in drives])
    return said[:, 0] - np.log([drive.tyre_stiffness for drive in drives]), said[:, 1]


def rescaled(quarter: Quarter, factor: float) -> Quarter:
    """Every mass, spring and damper times `factor`."""
    return quarter._replace(**{name: factor * getattr(quarter, name) for name in SCALED})


def calibrated(quarter: Quarter, beside: Beside, drives: Sequence[KnownDrive]) -> Corner:
    """The corner with its scale and its systematic standard deviation."""
    right = rescaled(quarter, math.exp(-float(np.mean(errors(quarter, beside, drives)[0]))))
    e, s = errors(right, beside, drives)
    return Corner(right, max(math.sqrt(max(float(np.mean(e**2 - s**2)), 0.0)), LEAST_STD))
