"""Pressure change of each wheel, how well it is known, and the probability that it is low, from a judgement.

With q = 1 / (1 + exp(threshold - statistic)), the probability of some loss if it is even at the threshold,

    low probability   q P(wheel low | some loss)
    change            q E[d | some loss]           ln pressure
    std               of that mixture, and of what a loss since before the drive could still be,
                      V = (C_0 + I/PRIOR^2)^-1, C_0 the information of the first onset;
                      and UNREAD per sqrt(s) while nothing is read; at most PRIOR
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.itpms.patterns import WIDE, Judgement

PRIOR = WIDE  # ln pressure
UNREAD = 2e-3  # per sqrt(s): a tyre that leaks 15 % in an hour and a half, unseen
Array = NDArray[np.float64]


def summary(judgement: Judgement | None, threshold: float, unread: float) -> tuple[Array, Array, Array]:
    """change and std [ln pressure], low probability of each wheel, shape (4,) each. unread: time [s] since something
    was last read."""
    if judgement is None:
        return np.zeros(4), np.full(4, PRIOR), np.zeros(4)
    some = 1.0 / (1.0 + np.exp(min(threshold - judgement.statistic, 500.0)))
    change = some * judgement.change
    mixture = some * (judgement.std**2 + judgement.change**2) - change**2
    std = np.sqrt(np.maximum(mixture, 0.0) + judgement.unknown + UNREAD**2 * unread)
    return change, np.minimum(std, PRIOR), np.clip(some * judgement.low, 0.0, 1.0)
