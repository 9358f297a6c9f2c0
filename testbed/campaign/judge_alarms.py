"""Do alarms come when a tyre is low, how soon, for the right wheel, and how often without a low tyre?

A tyre is low while it has lost the campaign's share of nominal pressure. A drive counts as faulty from the first low
tyre on, and as sound before that. Detection: time from the first low tyre to the first alarm after it. Isolation: that
alarm names exactly the tyres that are low then. False: an alarm while no tyre is low; alarms within EPISODE of one
another are one. What a statistic could do at any threshold is judged on the estimates: a drive's largest loss of the
first quantity that a method gives wheel by wheel, at the drive's end, of the low wheels of drives that end with one and
of any wheel of drives that are sound throughout.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.scores.detection import confusion, detection_times, isolation_rate
from estimators.scores.false_alarms import false_alarms
from estimators.scores.interval import proportion_interval
from estimators.scores.roc import area, operating_point, roc
from estimators.scores.survival import event_curve
from estimators.scores.tail import block_maxima, fit_tail
from testbed.campaign.judge_columns import QUANTITIES, Drives, Name
from testbed.campaign.judge_estimates import finite

Figures = dict[str, Any]
EPISODE = 60.0  # s
BLOCK = 10.0  # s of which the largest loss counts, for its tail
DESIGNED = 0.01  # false alarms an hour: one in 100 h
FALSE_SHARE = 0.05  # of sound drives, at which the detected share is told


def judge_alarms(drives: Drives, methods: tuple[str, ...], low: float) -> list[Figures]:
    """An entry for each method; null where the drives cannot tell."""
    lows = drives.low(low)
    onset = np.array([next((t for t, wheels in course if wheels), np.inf) for course in lows])
    entries = []
    for method in methods:
        alarms = drives.alarms(method)
        entries.append(
            {"method": method, "faulty_drives": int(np.isfinite(onset).sum())}
            | _detection(drives, alarms, lows, onset)
            | _false(drives, alarms, onset)
            | _statistic(drives, method, lows, onset)
        )
    return entries


def _detection(drives: Drives, alarms: list[Any], lows: list[Any], onset: NDArray[np.float64]) -> Figures:
    faulty = np.flatnonzero(np.isfinite(onset))
    if not len(faulty):
        return dict.fromkeys(("detected", "detection_s", "detection_95_s", "isolated", "confusion", "detection_curve"))
    ends = drives.ends
    events = detection_times([[t for t, _ in alarms[i]] for i in faulty], onset[faulty], ends[faulty])
    curve = event_curve(events)
    named: list[tuple[str, ...] | None] = []
    truth: list[tuple[str, ...]] = []
    for i in faulty:
        first = next((alarm for alarm in alarms[i] if onset[i] <= alarm[0] <= ends[i]), None)
        named.append(first[1] if first else None)
        truth.append(_low_at(lows[i], first[0] if first else ends[i]))
    any_alarm = any(wheels is not None for wheels in named)
    return {
        "detected": proportion_interval(int(events.observed.sum()), len(faulty)).json(),
        "detection_s": curve.quantile(0.5).json(),
        "detection_95_s": curve.quantile(0.95).json(),
        "isolated": isolation_rate(named, truth).json() if any_alarm else None,
        "confusion": confusion(named, truth).counts if any_alarm else None,
        "detection_curve": {
            "time_s": curve.time.tolist(),
            "share": finite(curve.share.value),
            "share_ci95": [finite(curve.share.low), finite(curve.share.high)],
            "watched_s": curve.end,
        },
    }


def _low_at(course: list[tuple[float, tuple[str, ...]]], time: float) -> tuple[str, ...]:
    """Low wheels at a time: those of the next sample, which is the mean of the stretch that the time lies in."""
    return next((wheels for t, wheels in course if t >= time - 1e-6), course[-1][1])


def _false(drives: Drives, alarms: list[Any], onset: NDArray[np.float64]) -> Figures:
    sound = np.minimum(onset, drives.ends)
    if not sound.sum() > 0.0:
        return {"false_alarms": None}
    found = false_alarms(
        [[t for t, _ in given if t < s] for given, s in zip(alarms, sound, strict=True)], sound, EPISODE
    )
    return {"false_alarms": {"count": found.count, "hours": found.hours, "per_hour": found.rate.json()}}


def _statistic(drives: Drives, method: str, lows: list[Any], onset: NDArray[np.float64]) -> Figures:
    """ROC and tail of a method's loss."""
    given = [n for n in drives.names() if n.method == method and n.wheel and QUANTITIES[n.quantity].loss]
    if not given:
        return {"statistic": None, "roc": None, "tail": None}
    quantity = QUANTITIES[given[0].quantity]
    names = [n for n in given if n.quantity == given[0].quantity]
    loss = np.stack([-drives.estimate(name)[0] for name in names])  # (wheels, drives, n)
    sound = ~np.isfinite(onset)
    return {
        "statistic": f"largest loss of {quantity.label}, {quantity.unit}",
        "roc": _roc(loss, names, lows, sound, drives),
        "tail": _tail(loss[:, sound], drives.time),
    }


def _roc(
    loss: NDArray[np.float64], names: list[Name], lows: list[Any], sound: NDArray[np.bool_], drives: Drives
) -> Figures | None:
    last = np.searchsorted(drives.time, drives.ends - 1e-6)
    final = loss[:, np.arange(len(drives)), last]  # (wheels, drives)
    low = np.array([[name.wheel in course[-1][1] for course in lows] for name in names])
    largest = np.fmax.reduce(np.where(low | sound, final, np.nan), axis=0)
    healthy, faulty = (largest[chosen & np.isfinite(largest)] for chosen in (sound, low.any(axis=0)))
    if len(healthy) < 2 or len(faulty) < 2:
        return None
    curve, point = roc(healthy, faulty), operating_point(healthy, faulty, FALSE_SHARE)
    return {
        "sound": len(healthy),
        "faulty": len(faulty),
        "area": area(healthy, faulty).json(),
        "at_false_share": FALSE_SHARE,
        "detected": point.detection.json(),
        "threshold": point.threshold.json(),
        "false_alarm": finite(curve.false_alarm.value),
        "false_alarm_ci95": [finite(curve.false_alarm.low), finite(curve.false_alarm.high)],
        "detection": finite(curve.detection.value),
        "detection_ci95": [finite(curve.detection.low), finite(curve.detection.high)],
    }


def _tail(loss: NDArray[np.float64], time: NDArray[np.float64]) -> Figures | None:
    """Loss that sound drives pass DESIGNED times an hour, by the tail of its maxima over wheels and BLOCK. loss: of the
    sound drives, shape (wheels, drives, n). None with too few of them."""
    maxima = [block_maxima(drive, time, BLOCK) for drive in np.fmax.reduce(loss, axis=0)]
    try:
        tail = fit_tail(maxima, BLOCK / 3600.0)
    except ValueError:
        return None
    return {"per_hour": DESIGNED, "threshold": tail.threshold_at(DESIGNED).json(), "hours": tail.hours}
