"""What the front hub felt where the rear wheel is now.

Distance s along one side is the integral of its speed, a straight line in each block of `intake.BLOCK` ms. The front
sample that belongs to a rear sample at time t is the one at t_f, s(t_f) = s(t) - wheelbase, between samples by a cubic
through the four nearest (Lagrange): at 1 kHz exact to 1e-5 below 28 Hz. So the delay follows speed as it changes. Kept:
the last `KEPT` ms. Left out: that the front rolled over the same road with a slightly other speed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.vertical_pressure.intake import BLOCK

KEPT = 1024  # ms: a wheelbase at 2.8 m/s
_KEPT, _BLOCK = KEPT, BLOCK


@compiled
def delayed(past, place, wheelbase, out):
    """Front values (KEPT,) and their places s (KEPT,), the last BLOCK of them new; out (BLOCK,): the front's value
    where the rear is now, NaN where it is not known."""
    first = _KEPT - _BLOCK
    at = 0
    while at < first and not np.isfinite(place[at]):
        at += 1
    begun = at
    for t in range(_BLOCK):
        wanted = place[first + t] - wheelbase
        out[t] = np.nan
        if not (place[begun] <= wanted):  # also for NaN
            continue
        while at < _KEPT - 1 and not place[at + 1] > wanted:
            at += 1
        if at <= begun or at > _KEPT - 3:
            continue
        u = (wanted - place[at]) / (place[at + 1] - place[at])
        out[t] = (
            -u * (u - 1.0) * (u - 2.0) / 6.0 * past[at - 1]
            + (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0 * past[at]
            - (u + 1.0) * u * (u - 2.0) / 2.0 * past[at + 1]
            + (u + 1.0) * u * (u - 1.0) / 6.0 * past[at + 2]
        )


class FrontDelay:
    """One side's."""

    def __init__(self, wheelbase: float) -> None:
        self._wheelbase = wheelbase
        self.skip()

    def skip(self) -> None:
        """What was before does not count: time has passed unheard."""
        self._past, self._place = np.full(KEPT, np.nan), np.full(KEPT, np.nan)
        self._s = 0.0

    def block(self, front: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.float64]:
        """front: a millisecond each, NaN where missing, (BLOCK,); speed [m/s] (BLOCK,), above 0. The front's values at
        the rear wheel's place, (BLOCK,)."""
        place = self._s + np.cumsum(speed) * 1e-3
        self._past = np.concatenate([self._past[BLOCK:], front])
        self._place = np.concatenate([self._place[BLOCK:], place]) - place[-1]
        self._s = 0.0
        out = np.empty(BLOCK)
        delayed(self._past, self._place, self._wheelbase, out)
        return out
