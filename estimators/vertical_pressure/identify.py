"""A corner's parameters from drives at known pressures: maximum innovation likelihood, bounded, from several starts.

Ljung, System Identification, 2nd ed., ch. 7.4. Where the paper (Brancati & Tufano, Machines 2022, 10, 1221, 5.2) fits
the course of both accelerations over a known road by a genetic algorithm, the road is noise here, as it is in a drive.
All drives of one road class together give one set. Noises are bounded: without that the hub's on class D grows until
the filter believes nothing (a variance of 135 was met), a false optimum with a better likelihood nearby than at the
start; the starts differ in damping, footprint and error. The level is each drive's own, solved for in closed form.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from estimators.vertical_pressure.anti_alias import STEP, analogue
from estimators.vertical_pressure.chain import Quarter
from estimators.vertical_pressure.innovations import distance, filter_of

SETTLE = 100  # samples before a filter that began at rest is judged
# lowest and highest over the expected: m_s, m_us, k, c; footprint [m]; errors, as share of what a hub feels: see _START
BOUNDS = ((0.4, 1.6), (0.7, 1.4), (0.4, 2.5), (0.4, 2.5), (0.02, 0.4), (1e-4, 1.0), (1e-5, 0.03))
ERROR_UNIT = 1e6  # (m/s^2)^2 / (m^3/rad) a (m/s) of speed at 1 m/s


@dataclass(frozen=True, eq=False)
class KnownDrive:
    """samples: decimated [a_s, a_us] of one wheel (n, 2) [m/s^2]; tyre_stiffness by the tyre's law [N/m]; speed [m/s];
    level: G of the road [m^3/rad], as far as it is known."""

    samples: NDArray[np.float64]
    tyre_stiffness: float
    speed: float
    level: float
