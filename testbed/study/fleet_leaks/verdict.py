"""Was a finding a leak? Judged by what the detector had not seen when it alarmed.

true    after the alarm the tyre's own pressure, compared with nothing, falls on: the lower end of its rate's 95 %
        interval is above the natural loss; or the tyre alone is filled about the leak's end: its own pressure rises by
        `FILLED` at least while the median of the others moves by less than half of that
false   neither, and after the alarm its loss beyond the others' is below what is tolerated, with its upper end
open    none of these: counted as false where precision is given

Weak where: owners fill tyres also without a leak; a sensor that drifts for months looks like a leak; a sudden loss is
no slow leak but can look like one for some days. Nobody looked at these tyres: there is no other truth.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.slow_leak import recursion
from estimators.slow_leak.monitor import Leak, Watched
from estimators.slow_leak.numbers import MODEL
from estimators.slow_leak.rate import Line, line_of

LOOKED_AT, SOON = 60, 5  # days after the alarm; days about the leak's end
FILLED = 20e3  # Pa
AROUND = 3  # days' values before and after a filling


@dataclass(frozen=True)
class Verdict:
    """verdict: true, false or open; goes_on: rate after the alarm, compared with nothing [Pa/s], as (value, low, high),
    or None for too few days; filled: rise when it was filled [Pa], or None."""

    verdict: str
    goes_on: tuple[float, float, float] | None
    filled: float | None


def judge(watched: Watched, pressure: NDArray[np.float64], leak: Leak) -> Verdict:
    """pressure: days' values [Pa], shape (n, tyres)."""
    day, said = watched.days, watched.said[:, leak.tyre]
    usual = said[:, recursion.EVENT] != recursion.OUTLYING
    after = (day > leak.alarm) & (day <= leak.alarm + LOOKED_AT) & usual
    after &= day <= leak.end if leak.ending == "record" else day < leak.end
    own = line_of(day[after], pressure[after, leak.tyre])
    beside = line_of(day[after], said[after, recursion.RELATIVE])
    filled = filled_by(day, pressure, leak.tyre, leak.end) if leak.ending == "step up" else None
    verdict = "open"
    if (own is not None and own.rate.low > MODEL.tolerated_alone) or (filled is not None and filled >= FILLED):
        verdict = "true"
    elif beside is not None and beside.rate.high < MODEL.tolerated:
        verdict = "false"
    return Verdict(verdict, _ends(own), filled)


def _ends(line: Line | None) -> tuple[float, float, float] | None:
    return None if line is None else (line.rate.value, line.rate.low, line.rate.high)


def filled_by(day: NDArray[np.int64], pressure: NDArray[np.float64], tyre: int, end: int) -> float | None:
    """Largest rise of the tyre's own pressure about a day [Pa], if the others do not share half of it; else None."""
    known = np.flatnonzero(np.isfinite(pressure[:, tyre]) & (np.abs(day - end) <= SOON + AROUND))
    best: float | None = None
    for k in range(1, len(known)):
        before, since = known[max(k - AROUND, 0) : k], known[k : k + AROUND]
        rise = np.median(pressure[since], axis=0) - np.median(pressure[before], axis=0)
        others = np.delete(rise, tyre)
        others = others[np.isfinite(others)]
        common = float(np.median(others)) if len(others) else 0.0
        if rise[tyre] > 0.0 and common < 0.5 * rise[tyre] and (best is None or rise[tyre] > best):
            best = float(rise[tyre])
    return best


def line_json(line: Line | None) -> dict[str, Any] | None:
    """JSON values of a line: rate as (value, low, high) [Pa/s], days, level and half width of the band [Pa]."""
    if line is None:
        return None
    return {
        "rate": [line.rate.value, line.rate.low, line.rate.high], "day": line.day.tolist(),
        "level": line.level.tolist(), "reach": line.reach.tolist(),
    }  # fmt: skip
