"""When a judgement is an alarm, and for which wheels.

The statistic (`patterns.Judgement`) passes the threshold of its source, which has one false alarm in 100 h
(`thresholds`), and the likeliest pattern has lost LEAST_LOSS or more. The wheels are then those of the likeliest
pattern, as soon as it is CERTAIN, at the latest after PATIENCE blocks. The alarm is latched; another one comes when a
pattern with further wheels has been certain for as long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimators.drive_log import WHEELS
from estimators.itpms.patterns import LEAST_LOSS, Judgement

CERTAIN = 0.999
PATIENCE = 8  # blocks


@dataclass(frozen=True)
class Named:
    """An alarm: wheels, and the judgement it rests on."""

    wheels: tuple[str, ...]
    judgement: Judgement


def names(pattern: np.ndarray) -> tuple[str, ...]:
    """Wheels of a pattern (4,) bool."""
    return tuple(wheel for wheel, low in zip(WHEELS, pattern, strict=True) if low)


class AlarmRule:
    """Watches the judgements of one source."""

    def __init__(self, threshold: float) -> None:
        self.threshold = threshold
        self._above = self._further = 0
        self.wheels: tuple[str, ...] = ()
        """Wheels of the alarm that is on."""

    def step(self, judgement: Judgement | None) -> Named | None:
        """An alarm if one is due."""
        if judgement is None or not self._over(judgement):
            self._above = self._further = 0
            return None
        self._above += 1
        if not self.wheels:
            if judgement.certainty < CERTAIN and self._above <= PATIENCE:
                return None
            self.wheels = names(judgement.best)
            return Named(self.wheels, judgement)
        meant = names(judgement.best)
        more = set(meant) > set(self.wheels) and judgement.certainty >= CERTAIN
        self._further = self._further + 1 if more else 0
        if self._further <= PATIENCE:
            return None
        self.wheels, self._further = meant, 0
        return Named(meant, judgement)

    def _over(self, judgement: Judgement) -> bool:
        lost = -np.expm1(judgement.change[judgement.best])
        return judgement.statistic > self.threshold and bool(lost.max() >= LEAST_LOSS)
