"""The record as it is: findings with their verdict, days watched, natural loss, the record backwards. JSON values."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.slow_leak import recursion
from estimators.slow_leak.monitor import Watched, find_leaks
from estimators.slow_leak.rate import line_of
from testbed.study.fleet_leaks.fleet import Trailer
from testbed.study.fleet_leaks.verdict import judge, line_json
from testbed.study.fleet_leaks.windows import weeks

LEAST_STRETCH = 90  # days between steps of which a natural loss is told


def of_trailer(trailer: Trailer) -> dict[str, Any]:
    """One trailer's part of the row."""
    day, pressure = trailer.days()
    watched = find_leaks(day, pressure)
    backwards = find_leaks(-day[::-1], pressure[::-1])
    leaking = {leak.tyre for leak in watched.leaks}
    return {
        "name": trailer.name, "tuning": trailer.tuning, "tyres": list(trailer.tyres), "day": day.tolist(),
        "pressure": _rows(pressure), "relative": _rows(watched.said[:, :, recursion.RELATIVE]),
        "statistic": _rows(watched.said[:, :, recursion.STATISTIC]),
        "watched": watched.watched.tolist(),
        "steps": [
            [{"day": day, "kind": kind} for day, kind in watched.steps(tyre)] for tyre in range(len(trailer.tyres))
        ],
        "findings": [_finding(watched, pressure, number) for number in range(len(watched.leaks))],
        "backwards": {"alarms": len(backwards.leaks), "watched": int(backwards.watched.sum())},
        "natural": [rate for tyre in range(len(trailer.tyres)) if tyre not in leaking
                    for rate in _natural(watched, pressure, tyre)],
        "weeks": [[[number, int(leak), int(alarmed)] for number, leak, alarmed in weeks(watched, tyre)]
                  for tyre in range(len(trailer.tyres))],
    }  # fmt: skip


def _rows(table: NDArray[np.float64]) -> list[list[float | None]]:
    """By tyre; None for NaN."""
    return [[float(v) if np.isfinite(v) else None for v in column] for column in table.T]


def _finding(watched: Watched, pressure: NDArray[np.float64], number: int) -> dict[str, Any]:
    leak = watched.leaks[number]
    verdict = judge(watched, pressure, leak)
    return {
        "tyre": leak.tyre, "start": leak.start, "alarm": leak.alarm, "end": leak.end, "ending": leak.ending,
        "at_alarm": line_json(leak.at_alarm), "whole": line_json(leak.whole), "verdict": verdict.verdict,
        "goes_on": list(verdict.goes_on) if verdict.goes_on else None, "filled": verdict.filled,
    }  # fmt: skip


def _natural(watched: Watched, pressure: NDArray[np.float64], tyre: int) -> list[list[float]]:
    """Loss of a sound tyre [Pa/s], own and beyond the others', over its longest stretch without a step."""
    event = watched.said[:, tyre, recursion.EVENT]
    cuts = np.flatnonzero((event == recursion.STEP_UP) | (event == recursion.STEP_DOWN))
    longest = max(np.split(np.arange(len(event)), cuts), key=len)
    usual = longest[event[longest] != recursion.OUTLYING]
    if len(usual) == 0 or watched.days[usual[-1]] - watched.days[usual[0]] < LEAST_STRETCH:
        return []
    relative = watched.said[usual, tyre, recursion.RELATIVE]
    own = line_of(watched.days[usual], pressure[usual, tyre])
    beyond = line_of(watched.days[usual], relative)
    return [] if own is None or beyond is None else [[own.rate.value, beyond.rate.value]]
