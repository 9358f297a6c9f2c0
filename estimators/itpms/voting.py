"""The published voting scheme (Persson, Gustafsson, Drevo, SAE 2002-01-1250, Figure 8): two analyses, one warning.

Vibration (1) and wheel radius (2) each deliver a flag t_i, the tyres that it takes for under-inflated, and a confidence
c_i. Here t_i is the likeliest pattern of the analysis once its statistic passes FLAGGED, and c_i that statistic [nats].

    t_1 = t_2, not none    a warning for these tyres if (c_1 + c_2) / 2 > h_0
    t_1 != t_2             a warning for t_1 if c_1 > h_1, for t_2 if c_2 > h_2
    none                   no warning

with h_0 < h_1, h_2, each with a third of the scheme's false alarms (`thresholds`).
"""

from __future__ import annotations

from dataclasses import dataclass

from estimators.itpms.alarm import names
from estimators.itpms.patterns import Judgement

FLAGGED = 0.0  # nats: some loss is likelier than none


@dataclass(frozen=True)
class Vote:
    """flag: wheels, none if empty; confidence [nats], 0 without a flag."""

    flag: tuple[str, ...] = ()
    confidence: float = 0.0

    @classmethod
    def of(cls, judgement: Judgement | None) -> Vote:
        """What an analysis says."""
        if judgement is None or judgement.statistic <= FLAGGED:
            return cls()
        return cls(names(judgement.best), judgement.statistic)


@dataclass(frozen=True)
class Thresholds:
    """h_0, h_1, h_2. ValueError unless h_0 is the least."""

    agreed: float
    vibration: float
    radius: float

    def __post_init__(self) -> None:
        if not self.agreed < min(self.vibration, self.radius):
            raise ValueError(f"h0 is {self.agreed:g}, valid: below h1 {self.vibration:g} and h2 {self.radius:g}")


def agreed(vibration: Vote, radius: Vote) -> float:
    """(c_1 + c_2) / 2 where both flags mean the same tyres, else 0 [nats]."""
    return 0.5 * (vibration.confidence + radius.confidence) if vibration.flag == radius.flag else 0.0


def warning(vibration: Vote, radius: Vote, h: Thresholds) -> tuple[str, ...]:
    """The wheels of the warning, none if empty."""
    if vibration.flag == radius.flag:
        return vibration.flag if agreed(vibration, radius) > h.agreed else ()
    first = vibration.flag if vibration.confidence > h.vibration else ()
    second = radius.flag if radius.confidence > h.radius else ()
    return tuple(sorted({*first, *second}, key=("fl", "fr", "rl", "rr").index))
