"""Does a fault raise the alarm, how soon, and for the right wheels?

A drive has one fault, from its onset on. Its detection time runs from the onset to the first alarm at or after it; a
drive that ends without one is censored at its end. `event_curve` and `share_by` of `survival` turn the times into the
distribution with its band; here are the figures of a table.

Isolation is judged given a detection: of the drives with an alarm, the share that names exactly the wheels with the
fault. Intervals are Clopper-Pearson, the drive being the unit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from estimators.drive_log import WHEELS
from estimators.scores.interval import CONFIDENCE, Interval, proportion_interval
from estimators.scores.survival import EventCurve, EventTimes, event_curve, share_by

NONE = "none"  # the label of no wheel

Wheels = Iterable[str]


@dataclass(frozen=True, eq=False)
class Detection:
    """curve: share of faults detected by each time since onset [s]. median, q95: time [s] by which 50 and 95 % are
    detected, infinite where that is not reached. by_limit: share detected within the limit. detected: with an alarm
    before the drive's end, of `drives`.
    """

    curve: EventCurve
    median: Interval
    q95: Interval
    by_limit: Interval
    detected: int
    drives: int


@dataclass(frozen=True)
class Confusion:
    """Drives by the wheels that had the fault and the wheels that the alarm named, given an alarm.

    counts: counts[truth][named], labels as of `wheels_label`; every label named anywhere has a column in every row.
    """

    counts: Mapping[str, Mapping[str, int]]

    def share(self, truth: str, named: str, confidence: float = CONFIDENCE) -> Interval:
        """Share of the detected drives with fault `truth` whose alarm named `named`."""
        if truth not in self.counts:
            raise ValueError(f"no detected drive has the fault {truth!r}, valid: {', '.join(self.counts)}")
        row = self.counts[truth]
        return proportion_interval(row.get(named, 0), sum(row.values()), confidence)


def detection_times(alarms: Sequence[ArrayLike], onset: ArrayLike, end: ArrayLike) -> EventTimes:
    """Time from onset to the first alarm at or after it.

    alarms: alarm times [s] of each drive, any order, possibly none. onset, end: of the fault and of the drive [s],
    shape (drives,). An alarm before the onset is a false one and is passed over. ValueError for an end before its
    onset.
    """
    starts, ends = np.asarray(onset, dtype=np.float64), np.asarray(end, dtype=np.float64)
    if starts.ndim != 1 or starts.shape != ends.shape or len(alarms) != len(starts):
        raise ValueError(f"onset has shape {starts.shape}, end {ends.shape}, valid: ({len(alarms)},), one a drive")
    if not (ends >= starts).all():
        raise ValueError(f"end is {ends[~(ends >= starts)][0]}, valid: at or after the onset of the same drive")
    times, observed = ends - starts, np.zeros(len(starts), dtype=bool)
    for drive, given in enumerate(alarms):
        every = np.asarray(given, dtype=np.float64).reshape(-1)
        counted = every[(every >= starts[drive]) & (every <= ends[drive])]
        if len(counted):
            times[drive], observed[drive] = counted.min() - starts[drive], True
    return EventTimes(times, observed)


def detection(events: EventTimes, limit: float, confidence: float = CONFIDENCE) -> Detection:
    """The figures of detection times. limit: [s] since onset within which an alarm is wanted, above 0."""
    if not (np.isfinite(limit) and limit > 0.0):
        raise ValueError(f"limit is {limit}, valid: a number of seconds above 0")
    curve = event_curve(events, confidence)
    return Detection(
        curve,
        curve.quantile(0.5),
        curve.quantile(0.95),
        share_by(events, limit, confidence),
        int(events.observed.sum()),
        len(events),
    )


def isolation_rate(named: Sequence[Wheels | None], truth: Sequence[Wheels], confidence: float = CONFIDENCE) -> Interval:
    """Share of the detected drives whose alarm named exactly the wheels with the fault.

    named: wheels of each drive's alarm, None without an alarm; an alarm that names no wheel is an empty set and wrong.
    truth: wheels with the fault. ValueError if no drive has an alarm.
    """
    pairs = _detected(named, truth)
    return proportion_interval(sum(said == true for said, true in pairs), len(pairs), confidence)


def confusion(named: Sequence[Wheels | None], truth: Sequence[Wheels]) -> Confusion:
    """Counts of the detected drives by fault and alarm; arguments as of `isolation_rate`."""
    pairs = _detected(named, truth)
    columns = sorted({said for said, _ in pairs} | {true for _, true in pairs})
    counts = {true: dict.fromkeys(columns, 0) for true in sorted({true for _, true in pairs})}
    for said, true in pairs:
        counts[true][said] += 1
    return Confusion(counts)


def wheels_label(wheels: Wheels) -> str:
    """`fl rr` of a set of wheels in any order, `none` of none. ValueError for an unknown wheel."""
    given = set(wheels)
    for wheel in sorted(given):
        if wheel not in WHEELS:
            raise ValueError(f"no wheel {wheel!r}, valid: {', '.join(WHEELS)}")
    return " ".join(wheel for wheel in WHEELS if wheel in given) or NONE


def _detected(named: Sequence[Wheels | None], truth: Sequence[Wheels]) -> list[tuple[str, str]]:
    if len(named) != len(truth):
        raise ValueError(f"named holds {len(named)} drives, valid: {len(truth)} as truth has")
    pairs = [
        (wheels_label(said), wheels_label(true)) for said, true in zip(named, truth, strict=True) if said is not None
    ]
    if not pairs:
        raise ValueError(f"named holds no alarm in {len(named)} drives, valid: at least one drive with an alarm")
    return pairs
