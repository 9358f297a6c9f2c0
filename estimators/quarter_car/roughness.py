"""The shape of a road's spectrum: two slopes, neither known.

ISO 8608 lets the displacement spectrum fall as G(Omega) ~ Omega^-w with w = 2; measured roads have w = 1.5 to 3.3, and
not one w over all waves: Dodds & Robson, J. Sound Vib. 31, 1973, fit two slopes that meet at 1 rad/m (6.3 m), w_l of
the long waves 2.05 +- 0.49 on principal roads (1.95 on motorways, 2.28 on minor roads), w_s of the short ones 1.44 +-
0.27; ISO 8608 has 2 for both; the measured road of the study about 2 and 3.3. So

    G(Omega) = lambda Omega_r^-2 (Omega / Omega_r)^-w_s            Omega >= BREAK
             = the same at BREAK, times (Omega / BREAK)^-w_l       below

One w for all waves does not do: it must fit the long waves too, and on the measured road at 60 km/h a believer in one
ends more than 100 kPa low, with two within 25 kPa (Whittle, 60 s); on roads of one slope two cost nothing. lambda is
stated at `REFERENCE` = Omega_r, in the middle of what the hub hears at usual speeds, where level and slope are nearly
independent of each other; it is G(1 rad/m) of the road of slope -2 that is as rough there. G(1 rad/m) itself is lambda
Omega_r^(w_s - 2): w_s - 2 ISO classes more, since a class is a factor 4 = Omega_r / (1 rad/m). Prior of each slope:
normal about ISO's 2, std `WAVINESS_STD`: wide enough for all of these. Declared, not tuned.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

BREAK, REFERENCE = 1.0, 4.0  # rad/m
WAVINESS, WAVINESS_STD = 2.0, 0.5  # prior of w_l and of w_s


def shape(
    omega: NDArray[np.float64], long: NDArray[np.float64] | float, short: NDArray[np.float64] | float
) -> NDArray[np.float64]:
    """G(Omega) / lambda [rad^2/m^2] at wave numbers omega [rad/m], above 0; long, short: w_l, w_s, broadcast."""
    over = np.log(np.maximum(omega, BREAK) / REFERENCE)
    below = np.log(np.minimum(omega / BREAK, 1.0))
    return np.asarray(REFERENCE**-2.0 * np.exp(-short * over - long * below))


def prior(waviness: NDArray[np.float64]) -> NDArray[np.float64]:
    """Probability of each of evenly spaced values of w_l or w_s, sums to 1."""
    found = np.exp(-0.5 * ((waviness - WAVINESS) / WAVINESS_STD) ** 2)
    return np.asarray(found / found.sum())
