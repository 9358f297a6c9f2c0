"""From 1 kHz hub samples to decimated ones, block by block, with gaps.

A block is `BLOCK` milliseconds on the clock's own grid, so that it does not matter how the stream was cut. Within it a
missing sample is bridged by the last one for up to `BRIDGE` ms; a wheel that is silent for longer is begun anew: its
filters are not judged for `SETTLE` decimated samples. Above `PLAUSIBLE` a value is missing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.vertical_pressure.anti_alias import EVERY, decimate, sections

BLOCK = 256  # ms: 16 decimated samples
SAMPLES = BLOCK // EVERY
BRIDGE = 20  # ms
SETTLE = 64  # decimated samples, 1 s: the high-pass and the filters have forgotten their start
PLAUSIBLE = 2e3  # m/s^2


@compiled
def bridged(value, last, silent, filled):
    """Fills gaps of value (n,) into filled; last, silent (1,): the last good sample, ms since it. False if a gap was
    too long to bridge."""
    whole = True
    for t in range(len(value)):
        if abs(value[t]) <= PLAUSIBLE:
            last[0] = value[t]
            silent[0] = 0
        else:
            silent[0] += 1
            if silent[0] > BRIDGE:
                whole = False
        filled[t] = last[0]
    return whole


class HubIntake:
    """One wheel's."""

    def __init__(self) -> None:
        self._sections = sections()
        self._last, self._silent = np.zeros(1), np.full(1, BRIDGE + 1)
        self.settling = SETTLE
        """Decimated samples that are still to pass before the filters are judged."""
        self._begin()

    def _begin(self) -> None:
        self._begun, self._level = np.zeros(1), np.zeros(1)
        self._memory = np.zeros((1, len(self._sections), 2))
        self.settling = SETTLE

    def block(self, value: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """value: one a millisecond, NaN where missing, shape (BLOCK,). Decimated (SAMPLES,), None after too long
        a gap."""
        filled, out = np.empty(BLOCK), np.empty((SAMPLES, 1))
        if not bridged(value, self._last, self._silent, filled):
            self._begin()
            return None
        phase = np.zeros(1, np.int64)
        decimate(self._sections, filled[:, None], phase, self._begun, self._level, self._memory, out)
        return out[:, 0].copy()

    def restart(self) -> None:
        """The filters were set back: they settle anew."""
        self.settling = SETTLE

    def skip(self) -> None:
        """Blocks without any sample have passed."""
        self._silent[0] = BRIDGE + 1
        self._begin()
