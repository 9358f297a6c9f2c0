"""The thesis' monitors of the actuator (4.2.1), each a detector on each of the three residuals.

    CUSUM            of |eps|                                   tuned after set A    environment 1
    double_CUSUM     of eps, both ways                          A                    1
    ACS, ACF         |sum of eps|, zeroed every 2 s, 0.5 s      A                    1
    AC               |eps|                                      A                    1
    GMA              average of |eps|                           A                    1
    LCUSUM           of |eps| where |eps| <= limit, per limit   A                    1
    double_LCUSUM    of eps where |eps| <= limit, both ways     A                    1
    double_LGCUSUM   the same and a global one                  B                    2
    ADYN             average of |eps| that forgets fast         A                    2

Environment 1: residuals are zero for the first second; 2: they are not. The thesis gives no parameter but Table 5.1's;
`tuning` finds them by its rule. Periods and ADYN's forgetting are declared. One-sided ones see |eps| (2.25).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import CusumMean, Detector, Ewma, Integrator, LocalCusum, Monitor
from estimators.steering_actuator.residuals import RESIDUALS, STEP

ZEROED = round(1.0 / STEP)  # cells, in environment 1
BEGINNING, SHORT = round(1.0 / STEP), round(0.1 / STEP)  # cells: an alarm so early and so short is the thesis' star
SLOW_PERIOD, FAST_PERIOD = 200, 50  # cells
FAST_FORGETTING = 0.9


@dataclass(frozen=True)
class Method:
    """family: what its detectors are; double: they see the sign; tuned_on: A or B; environment: 1 or 2."""

    name: str
    family: str
    double: bool
    tuned_on: str
    environment: int

    def seen(self, eps: NDArray[np.float64]) -> NDArray[np.float64]:
        """What its detectors are given of residuals, same shape (n, ...)."""
        shown = eps.copy() if self.double else np.abs(eps)
        if self.environment == 1:
            shown[:ZEROED] = 0.0
        return shown


METHODS = (
    Method("CUSUM", "cusum", False, "A", 1),
    Method("ACS", "slow", True, "A", 1),
    Method("ACF", "fast", True, "A", 1),
    Method("AC", "compare", True, "A", 1),
    Method("GMA", "average", False, "A", 1),
    Method("LCUSUM", "local", False, "A", 1),
    Method("double_LCUSUM", "local", True, "A", 1),
    Method("double_CUSUM", "cusum", True, "A", 1),
    Method("double_LGCUSUM", "local_global", True, "B", 2),
    Method("ADYN", "forgetful", False, "A", 2),
)


def detector(method: Method, numbers: Mapping[str, Any]) -> Detector:
    """numbers: `threshold` and, by family, `drift`, `forgetting`, or lists `limits` (null: none), `drifts`,
    `thresholds`. ValueError or KeyError if they make no sense."""
    sides = "both" if method.double else "upper"
    if method.family in ("local", "local_global"):
        limits = tuple(inf if limit is None else float(limit) for limit in numbers["limits"])
        return LocalCusum(limits, tuple(numbers["drifts"]), tuple(numbers["thresholds"]), sides)
    threshold = float(numbers["threshold"])
    if method.family == "cusum":
        return CusumMean(float(numbers["drift"]), threshold, sides)
    if method.family in ("average", "forgetful"):
        return Ewma(float(numbers["forgetting"]), threshold, sides)
    period = {"slow": SLOW_PERIOD, "fast": FAST_PERIOD, "compare": 1}[method.family]
    return Integrator(period, threshold, sides)


def statistics(method: Method, tuned: Mapping[str, Mapping[str, Any]], eps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of a drive, eps (n, 3): each detector's statistic in units of its level, (n, 3); an alarm is above 1.

    tuned: numbers of each of RESIDUALS.
    """
    shown, said = method.seen(eps), np.empty(eps.shape)
    for i, name in enumerate(RESIDUALS):
        of = detector(method, tuned[name])
        said[:, i] = Monitor(of).run(shown[:, i]).statistic / of.level
    return said


@dataclass(frozen=True)
class Verdict:
    """time: s from the beginning to the alarm, None without one; by: of RESIDUALS; star: a short alarm at the
    beginning came before."""

    time: float | None
    by: str
    star: bool


def verdict(said: NDArray[np.float64], level: float = 1.0) -> Verdict:
    """The first alarm in statistics (n, 3), above `level`."""
    on = np.asarray((said > level).any(axis=1))
    star = False
    if on.any() and (first := int(np.argmax(on))) < BEGINNING:
        off = np.flatnonzero(~on[first:])
        if len(off) and off[0] <= SHORT:
            star, on = True, on.copy()
            on[first : first + off[0]] = False
    if not on.any():
        return Verdict(None, "", star)
    k = int(np.argmax(on))
    return Verdict((k + 1) * STEP, RESIDUALS[int(np.argmax(said[k]))], star)
