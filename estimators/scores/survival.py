"""Times to an event (an alarm, a settled estimate) when some drives end before it: they are censored, not left out.

Kaplan & Meier, J. Am. Stat. Assoc. 53 (1958) 457. At the i-th event time, d_i events among r_i drives still watched,

    S(t) = prod (1 - d_i / r_i)        Greenwood: V = S^2 sum d_i / (r_i (r_i - d_i))

and the band at each time is that of log(-log S), which keeps it within 0 to 1: S^exp(+-z sqrt(V) / (S log S)).
Quantiles take the times between which the band holds the wanted share (Brookmeyer & Crowley, Biometrics 38 (1982) 29);
infinite where the curve or the band does not reach it. A share by a given time has the limits of Clopper-Pearson with
the effective number S (1 - S) / V of drives (Cutler & Ederer, J. Chronic Dis. 8 (1958) 699), which is exact when nobody
was censored before and valid where no or every drive had the event; the band takes them where the curve has reached 1
and Greenwood has no width. An event at the time of another drive's censoring comes first. Censoring must not depend on
the event still to come.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from estimators.scores.interval import CONFIDENCE, Band, Interval, proportion_interval


@dataclass(frozen=True, eq=False)
class EventTimes:
    """One time a drive [s], shape (n,): of the event where observed, else of the end of watching. Copied, read-only.

    ValueError for no drive at all, a time that is not finite, or shapes that differ.
    """

    time: NDArray[np.float64]
    observed: NDArray[np.bool_]

    def __init__(self, time: ArrayLike, observed: ArrayLike) -> None:
        times, seen = np.array(time, dtype=np.float64), np.array(observed, dtype=bool)
        if times.ndim != 1 or len(times) == 0 or times.shape != seen.shape:
            raise ValueError(f"time has shape {times.shape} and observed {seen.shape}, valid: both (n,), n at least 1")
        if not np.isfinite(times).all():
            raise ValueError(f"time holds {times[~np.isfinite(times)][0]}, valid: finite; censor what was not observed")
        times.flags.writeable = seen.flags.writeable = False
        object.__setattr__(self, "time", times)
        object.__setattr__(self, "observed", seen)

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True, eq=False)
class EventCurve:
    """Share of drives with the event by each time: steps, constant from one time to the next, 0 before the first.

    time: distinct event times [s], shape (m,), rising; may be empty. share: with its band, shape (m,). watched: drives
    without the event just before each time, shape (m,). end: last time at which a drive was watched [s].
    """

    time: NDArray[np.float64]
    share: Band
    watched: NDArray[np.int64]
    end: float

    def quantile(self, share: float) -> Interval:
        """Time [s] by which a share of drives has the event; infinite where the curve or its band does not reach it."""
        if not 0.0 < share < 1.0:
            raise ValueError(f"share is {share}, valid: above 0 and below 1")
        curves = (self.share.value, self.share.high, self.share.low)
        value, low, high = (_first(self.time, curve >= share - 1e-12) for curve in curves)
        return Interval(value, min(low, value), max(high, value))


def event_curve(events: EventTimes, confidence: float = CONFIDENCE) -> EventCurve:
    """Kaplan-Meier curve with its pointwise log-log band."""
    times, survival, greenwood, watched = _product_limit(events)
    low, high = np.zeros(len(times)), np.ones(len(times))
    normal = float(special.ndtri((1.0 + confidence) / 2.0))
    for step, (remaining, variance) in enumerate(zip(survival, greenwood, strict=True)):
        if remaining > 0.0:
            reach = normal * math.sqrt(variance) / -math.log(remaining)
            low[step], high[step] = 1.0 - remaining ** math.exp(-reach), 1.0 - remaining ** math.exp(reach)
        else:
            low[step] = _low_of_all(events, low[:step], int(watched[step]), confidence)
    return EventCurve(times, Band(1.0 - survival, low, high), watched, float(events.time.max()))


def share_by(events: EventTimes, limit: float, confidence: float = CONFIDENCE) -> Interval:
    """Share of drives with the event by a time limit [s]; if none was watched so long, its upper limit is 1."""
    times, survival, greenwood, _ = _product_limit(events)
    step = int(np.searchsorted(times, limit, side="right")) - 1
    watched = int(np.sum(events.time >= limit))
    if step < 0:
        return proportion_interval(0, watched, confidence) if watched else Interval(0.0, 0.0, 1.0)
    remaining = float(survival[step])
    if remaining == 0.0:
        return event_curve(events, confidence).share.at(step)
    trials = (1.0 - remaining) / (remaining * float(greenwood[step]))
    found = proportion_interval((1.0 - remaining) * trials, trials, confidence)
    return Interval(1.0 - remaining, found.low, found.high if watched else 1.0)


def _product_limit(
    events: EventTimes,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Event times, S after each, Greenwood's sum (infinite where S is 0), drives watched just before each."""
    times, happened = np.unique(events.time[events.observed], return_counts=True)
    watched = len(events) - np.searchsorted(np.sort(events.time), times).astype(np.int64)
    survival = np.cumprod((watched - happened) / watched, dtype=np.float64)
    with np.errstate(divide="ignore"):
        greenwood = np.cumsum(happened / (watched * (watched - happened)), dtype=np.float64)
    return times, survival, greenwood, watched


def _low_of_all(events: EventTimes, earlier: NDArray[np.float64], watched: int, confidence: float) -> float:
    """Lower limit of the share once the curve is 1: exact if no drive was censored, else the limit of the step before,
    which a few last drives cannot raise.
    """
    if events.observed.all():
        watched = len(events)
    elif len(earlier):
        return float(earlier[-1])
    return proportion_interval(watched, watched, confidence).low


def _first(time: NDArray[np.float64], reached: NDArray[np.bool_]) -> float:
    return float(time[np.argmax(reached)]) if reached.any() else float("inf")
