"""Residuals with the stated properties of the thesis' position residuals, whose data are not to be had.

What it says of them: with |r| > 50, 100, 200 removed their standard deviation is 15.7, 20.7, 33.1, with |r| > 100 and
zeros removed 21.9; most are very small; they reach from -1080 to 1266 in an active scenario, from -36 to 31 in a normal
one; the large ones belong to scenarios, so they come together. Here r is drawn from one of four states

    at zero    r = 0
    calm       N(0, CALM^2)         lively  N(0, 60^2)         active  N(0, 400^2)

by SHARES, cut to the range. CALM and SHARES solve the four standard deviations; 60 and 400 are declared, as the four
say no more. A state either holds for one sample (independent residuals) or on average for HOLD samples (in bursts,
geometric): both have the same distribution. Correlation within a state is left out: nothing is said of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.detectors.simulate import Noise

CALM, LIVELY, ACTIVE = 15.7427, 60.0, 400.0
SHARES = (0.0952247, 0.7196726, 0.0593519, 0.1257508)  # at zero, calm, lively, active
RANGE = (-1080.0, 1266.0)
HOLD = 200  # samples, 2 s
_SPREADS = np.array([0.0, CALM, LIVELY, ACTIVE])

Array = NDArray[np.float64]


def residuals(hold: int = 1, low: float = RANGE[0], high: float = RANGE[1], states: int = 4) -> Noise:
    """Noise whose state holds for `hold` samples on average; only the first `states`, what is beyond low or high drawn
    again from its own state."""
    shares = np.array(SHARES[:states]) / sum(SHARES[:states])

    def draw(generator: np.random.Generator, n: int) -> Array:
        fresh = generator.random(n) < 1.0 / hold
        fresh[:1] = True
        state = generator.choice(states, int(fresh.sum()), p=shares)[np.cumsum(fresh) - 1]
        spread = _SPREADS[state]
        r = spread * generator.standard_normal(n)
        while len(beyond := np.flatnonzero((r < low) | (r > high))):
            r[beyond] = spread[beyond] * generator.standard_normal(len(beyond))
        return r

    return draw


def conform(r: Array, cut: float, zeros: bool) -> Array:
    """The residuals left when those beyond the cut, and zeros unless they may stay, are removed as in the thesis."""
    return r[(np.abs(r) <= cut) & (zeros | (r != 0.0))]


def seen_locally(noise: Noise, limit: float) -> Noise:
    """0 where |x| > limit: what a local detector is shown."""

    def draw(generator: np.random.Generator, n: int) -> Array:
        x = noise(generator, n)
        x[np.abs(x) > limit] = 0.0
        return x

    return draw
