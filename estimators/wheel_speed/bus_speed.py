"""One wheel's bus speed on the even clock of `resampling`, for what its rate can carry.

A bus speed is the mean over the time since the update before it, so the angle grows by speed times that time and the
updates stand in for teeth. Motion above half the rate is folded below it by the sender and cannot be told apart: what a
mode needs above USABLE of the rate, this signal does not carry (`carries`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_speed.edge_speed import WAIT, Samples
from estimators.wheel_speed.resampling import INTEGRAL, RATE, REACH, USABLE, resample

LONGEST = 3.0  # usual intervals between updates that belong together
KEPT = 2.0  # s of updates from which the usual interval is taken


class BusSpeed:
    """Running tracker of a wheel."""

    def __init__(self) -> None:
        self._waiting_time, self._waiting_speed = np.empty(0), np.empty(0)
        self._time, self._speed = np.empty(0), np.empty(0)
        self._next: int | None = None
        self.rate = math.nan  # Hz, nan before two updates

    def add(self, time: NDArray[np.float64], speed: NDArray[np.float64]) -> None:
        """Updates [s], rising, and speeds [rad/s], finite, shape (n,)."""
        self._waiting_time = np.concatenate([self._waiting_time, time])
        self._waiting_speed = np.concatenate([self._waiting_speed, speed])

    def carries(self, frequency: float) -> bool:
        """Whether a spectrum up to `frequency` [Hz] can be told at this rate."""
        return USABLE * self.rate >= frequency

    def advance(self, end: float) -> tuple[Samples, list[str]]:
        """Samples that updates before `end` [s] decide, and no complaints."""
        split = int(np.searchsorted(self._waiting_time, end))
        self._time = np.concatenate([self._time, self._waiting_time[:split]])
        self._speed = np.concatenate([self._speed, self._waiting_speed[:split]])
        self._waiting_time, self._waiting_speed = self._waiting_time[split:], self._waiting_speed[split:]
        last = math.floor((end - REACH - WAIT) * RATE + 1e-6)
        first = self._next if self._next is not None else math.ceil((end - 1.0) * RATE)
        self._next = max(last, first)
        out = np.full(self._next - first, np.nan)
        steps = np.diff(self._time)
        if len(steps):
            usual = float(np.median(steps))
            self.rate = 1.0 / usual
            angle = np.concatenate([[0.0], np.cumsum(self._speed[1:] * steps)])
            whole = np.concatenate([[0], steps <= LONGEST * usual]).astype(np.int64)
            resample(self._time, angle, whole, first, out, INTEGRAL)
        keep = int(np.searchsorted(self._time, min(end - KEPT, self._next / RATE - 2.0 * REACH)))
        self._time, self._speed = self._time[keep:], self._speed[keep:]
        return Samples(first, out, -self.rate if math.isfinite(self.rate) else -1.0), []
