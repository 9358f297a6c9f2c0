"""Study `itpms-fusion`: does a car know that a tyre is low, which one and how soon, without a pressure sensor?

Rows, for the fused monitor, and prefixed `vibration.`, `radius.`, `voting.` for each method alone and the published
voting scheme (radius cannot see four equal losses):

    detect_15pct_N_tyres_p95_s     95 % quantile of the time from the moment at which 15 % are lost (sudden and leaks
                                   together; an alarm during a leak counts as 0), drives without an alarm censored.
                                   Limit: the same quantile of the vibration bound (`bound`); _sudden, _leak: of these
                                   alone; _heard: of drives that are ever faster than HEARD_FROM
    detect_10pct_1_tyre_wander_bound_p95_s      of the bound of a car that wanders as declared (`bound`)
    isolation_rate                 share of the alarms that name exactly the low tyres
    false_alarms, hours            in sound driving: alarms with one in 60 s counted, and the hours
    designed_false_alarms_per_100h      the designed 1 (limit), and what the tail of the statistic says at the threshold

A drive that alarms before its loss is a false alarm and counts no detection. Regulations and off-calibration cases: the
share that alarmed in time (limit for four at once: what their level can tell at all, `bound`). What was drawn is in
`cars`, what was driven in `drives`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from estimators.detectors import poisson_interval
from estimators.itpms.thresholds import FALSE_ALARMS_PER_HOUR, SPAN, TUNED
from estimators.scores.detection import isolation_rate
from estimators.scores.false_alarms import false_alarms
from estimators.scores.interval import Interval, proportion_interval
from estimators.scores.survival import EventTimes, event_curve
from estimators.scores.tail import fit_tail
from testbed.study.itpms_fusion.bound import found_by_level
from testbed.study.itpms_fusion.drives import (
    LOSSES,
    OFF_CALIBRATION,
    OFF_LOSS,
    QUICK,
    REGULATIONS,
    SLOW,
    name_of,
)
from testbed.study.itpms_fusion.repetition import HARDEST, METHODS, repeat, task
from testbed.study.study import Row, Study, StudyRow, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER_TIME = 60.0  # s
HEARD_FROM = 47.0  # km/h, from which on the antiphase mode is well heard
GAP = 60.0  # s between alarms that count as two
HUNDRED = 100.0


class ItpmsFusionStudy(Study):
    name = "itpms-fusion"
    about = "Does a car know that a tyre is low, which one and how soon, without a pressure sensor?"
    paper = "Persson, Gustafsson, Drevo, SAE 2002-01-1250, Figures 8 and 9."
    runs = 28  # 20 h of sound driving

    @property
    def work(self) -> Callable[[Task], Row]:
        return repeat

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        return [task(seed, number, small) for number in range(runs)]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        found: list[StudyRow] = []
        repetitions = [json.loads(row["drives"]) for row in rows]
        for method in METHODS:
            found += [*_detection(repetitions, method), *_sound(repetitions, method)]
        return [*found, *_named(repetitions)]

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.itpms_fusion.figures import figures  # matplotlib, only where something is drawn

        return figures([json.loads(row["drives"]) for row in rows])


def prefix(method: str) -> str:
    """Of the names of a method's rows."""
    return "" if method == "fused" else f"{method}."


def driven(rows: Sequence[Row], names: Sequence[str]) -> list[dict[str, Any]]:
    """The drives of these names that were driven to their loss."""
    found = [row[name] for row in rows for name in names if row.get(name)]
    return [drive for drive in found if drive["end_s"] > drive["reached_s"]]


def first_alarm(drive: Mapping[str, Any], method: str) -> tuple[float, list[str]] | None:
    """Time and wheels of a method's first alarm from the onset on; None without one, or with a false one before."""
    every = sorted(drive["alarms"][method])
    if any(time < drive["onset_s"] for time, _ in every):
        return None
    return (every[0][0], every[0][1]) if every else None


def times(drives: Sequence[Mapping[str, Any]], method: str) -> EventTimes | None:
    """From the moment at which the share is lost to the alarm, censored where the drive ends first."""
    usable = [d for d in drives if not any(t < d["onset_s"] for t, _ in d["alarms"][method])]
    if not usable:
        return None
    alarms = [first_alarm(d, method) for d in usable]
    passed = [
        max((a[0] if a else d["end_s"]) - d["reached_s"], 0.0) for a, d in zip(alarms, usable, strict=True)
    ]  # fmt: skip
    return EventTimes(passed, [a is not None for a in alarms])


def _quantile(events: EventTimes | None) -> Interval | None:
    return None if events is None else event_curve(events).quantile(0.95)


def _bounds(drives: Sequence[Mapping[str, Any]], name: str) -> Interval:
    """95 % quantile of a bound of the drives."""
    known = [d[name] for d in drives]
    events = EventTimes(
        [max(d["end_s"] - d["reached_s"], 0.0) if b is None else b for d, b in zip(drives, known, strict=True)],
        [b is not None for b in known],
    )
    return event_curve(events).quantile(0.95)


def _limit(drives: Sequence[Mapping[str, Any]], method: str) -> float | None:
    """Of the vibration bound; None where it is not reached, and for the radius, which has none."""
    if method == "radius":
        return None
    value = _bounds(drives, "bound_s").value
    return value if np.isfinite(value) else None


def _detection(rows: Sequence[Row], method: str) -> Iterator[StudyRow]:
    start = prefix(method)
    for tyres in (1, 2, 3, 4):
        if method == "radius" and tyres == 4:
            continue
        both = [name_of(0.15, tyres, kind) for kind in ("sudden", "leak")]
        for names, ending in ((both, ""), (both[:1], "_sudden"), (both[1:], "_leak"), (both, "_heard")):
            drives = driven(rows, names)
            if ending == "_heard":
                drives = [d for d in drives if d["fastest_kmh"] > HEARD_FROM]
            if drives and (not ending or method == "fused"):
                yield StudyRow.of(
                    f"{start}detect_15pct_{tyres}_tyres{ending}_p95_s", "s", _quantile(times(drives, method)),
                    PAPER_TIME if method in ("fused", "voting") else None, _limit(drives, method),
                )  # fmt: skip
    for share, tyres, kind in LOSSES:
        drives = driven(rows, [name_of(share, tyres, kind)])
        if share != 0.15 and drives:
            what = f"{start}detect_{100 * share:.0f}pct_{tyres}_tyre{'s' if tyres > 1 else ''}_p95_s"
            paper = PAPER_TIME if share == 0.25 and method in ("vibration", "radius") else None
            yield StudyRow.of(what, "s", _quantile(times(drives, method)), paper, _limit(drives, method))
            if method == "fused" and share <= HARDEST:
                yield StudyRow.of(what.replace("_p95_s", "_wander_bound_p95_s"), "s", _bounds(drives, "wander_s"))
    for one in (0.15, None):
        drives = driven(rows, [name_of(s, n, k) for s, n, k in LOSSES if one in (s, None)])
        drives = [d for d in drives if not (method == "radius" and len(d["wheels"]) == 4)]
        found = [(first_alarm(d, method), d["wheels"]) for d in drives]
        if any(alarm for alarm, _ in found):
            rate = isolation_rate([alarm[1] if alarm else None for alarm, _ in found], [w for _, w in found])
            yield StudyRow.of(f"{start}isolation_rate{'_15pct' if one else ''}", "-", rate, limit=1.0)
        seen = sum(alarm is not None for alarm, _ in found)
        if found and one is None:
            yield StudyRow.of(f"{start}share_detected", "-", proportion_interval(seen, len(found)))


def _sound(rows: Sequence[Row], method: str) -> Iterator[StudyRow]:
    start = prefix(method)
    drives = [d for row in rows for d in row.values() if d["sound_s"] > 0.0]
    if not drives:
        return
    before = [[t for t, _ in d["alarms"][method] if t < d["sound_s"]] for d in drives]
    counted = false_alarms(before, np.array([d["sound_s"] for d in drives]), GAP)
    limit = FALSE_ALARMS_PER_HOUR * counted.hours
    interval = poisson_interval(counted.count)
    yield StudyRow(f"{start}false_alarms", "-", None, float(counted.count), interval, limit)
    yield StudyRow(f"{start}hours", "h", None, counted.hours)
    if method == "voting":
        return
    try:
        tail = fit_tail([d["largest"][method] for d in drives], SPAN / 3600.0)
        rate = tail.rate_at(TUNED.alone[method])
    except ValueError:  # too few blocks, or a threshold that is no tail
        return
    yield StudyRow.of(f"{start}designed_false_alarms_per_100h", "1/100 h", rate, limit=1.0, scale=HUNDRED)


def _named(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """Regulations and off-calibration cases."""
    for name in (*REGULATIONS, *OFF_CALIBRATION):
        drives = driven(rows, [name])
        if not drives:
            continue
        allowed = REGULATIONS[name][2] if name in REGULATIONS else PAPER_TIME * 10.0
        for method in METHODS:
            if method == "radius" and len(drives[0]["wheels"]) == 4:
                continue
            alarms = [first_alarm(d, method) for d in drives]
            passed = sum(
                a is not None and a[0] <= allowed and a[1] == d["wheels"] for a, d in zip(alarms, drives, strict=True)
            )
            in_time = sum(a is not None and a[0] <= allowed for a in alarms)
            most = found_by_level(OFF_LOSS, SLOW, QUICK) if name == "four_at_once" else 1.0
            share = proportion_interval(in_time, len(drives))
            yield StudyRow.of(f"{prefix(method)}{name}_pass", "-", share, limit=most)
            if method == "fused":
                yield StudyRow.of(f"{name}_right_tyres", "-", proportion_interval(passed, len(drives)), limit=1.0)
                yield StudyRow.of(f"{name}_p95_s", "s", _quantile(times(drives, method)), limit=_limit(drives, method))
