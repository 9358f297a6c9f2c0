"""From 1 kHz samples of one side to windows of aligned, decimated hub accelerations.

Blocks of `vertical_pressure.intake`. A window is complete after `WINDOW / SAMPLES` blocks in a row in which both hubs
were heard and the front's road had reached the rear wheel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.axles.block import HOP, WINDOW
from estimators.axles.delay import FrontDelay
from estimators.vertical_pressure.intake import SAMPLES, HubIntake

BLOCKS = WINDOW // HOP  # of a window: HOP is a block's samples
assert HOP == SAMPLES


class SideIntake:
    """One side's."""

    def __init__(self, wheelbase: float) -> None:
        self._delay = FrontDelay(wheelbase)
        self._front, self._rear = HubIntake(), HubIntake()
        self._window = np.zeros((WINDOW, 2))
        self._whole = 0

    def skip(self) -> None:
        """Blocks without any sample, or too slow ones, have passed."""
        self._delay.skip()
        self._front.skip()
        self._rear.skip()
        self._whole = 0

    def block(
        self, front: NDArray[np.float64], rear: NDArray[np.float64], speed: NDArray[np.float64]
    ) -> NDArray[np.float64] | None:
        """front, rear: a millisecond each, NaN where missing; speed [m/s]: (BLOCK,) each. The window that ends with
        this block (WINDOW, 2), None while there is none."""
        there = self._front.block(self._delay.block(front, speed))
        here = self._rear.block(rear)
        if there is None or here is None:
            self._whole = 0
            return None
        self._whole += 1
        self._window = np.concatenate([self._window[SAMPLES:], np.stack([there, here], axis=1)])
        return self._window if self._whole >= BLOCKS else None
