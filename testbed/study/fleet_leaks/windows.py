"""Weeks of real tyres with and without a leak, as the published figures count them: windows of 7 days.

A week is one with a leak if, looking back with all that came before and after, the tyre's loss beyond the others' over
`SPAN` about it, within one stretch between steps up, is above `LEAST` with its lower 95 % end; it has none if the upper
end is below; weeks of which neither can be said are left out. It is alarmed if the alarm was on at its end. Unlike the
detector this looks ahead, but both compare with the same other tyres, and nobody looked at the tyres themselves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.slow_leak import recursion
from estimators.slow_leak.monitor import Watched
from estimators.slow_leak.numbers import MONTH
from estimators.slow_leak.rate import line_of

WEEK, SPAN = 7, 21  # days
LEAST = 10e3 / MONTH  # Pa/s
LEAST_DAYS = 7  # days' values in the span


def alarm_on(watched: Watched, tyre: int) -> NDArray[np.bool_]:
    """Whether the alarm was on at the end of each day, shape (n,)."""
    on = np.zeros(len(watched.days), dtype=np.bool_)
    for leak in watched.leaks:
        if leak.tyre == tyre:
            on |= (watched.days >= leak.alarm) & ((watched.days < leak.end) | (leak.ending == "record"))
    return on


def stretches(watched: Watched, tyre: int) -> list[NDArray[np.int64]]:
    """Rows of each stretch between a tyre's steps up, or steps down without an alarm on."""
    event, on = watched.said[:, tyre, recursion.EVENT], alarm_on(watched, tyre)
    cut = (event == recursion.STEP_UP) | ((event == recursion.STEP_DOWN) & ~on)
    return [rows for rows in np.split(np.arange(len(event)), np.flatnonzero(cut)) if len(rows)]


def weeks(watched: Watched, tyre: int) -> list[tuple[int, bool, bool]]:
    """Stretch, whether the week had a leak, whether it was alarmed; of each week that can be judged."""
    relative = watched.said[:, tyre, recursion.RELATIVE].copy()
    relative[watched.said[:, tyre, recursion.EVENT] == recursion.OUTLYING] = np.nan
    on, found = alarm_on(watched, tyre), []
    for number, rows in enumerate(stretches(watched, tyre)):
        day = watched.days[rows]
        for first in range(int(day[0]), int(day[-1]) - WEEK + 2, WEEK):
            inside = (day >= first) & (day < first + WEEK) & np.isfinite(relative[rows])
            middle = first + 0.5 * WEEK
            about = rows[(np.abs(day + 0.5 - middle) <= 0.5 * SPAN) & np.isfinite(relative[rows])]
            if not inside.any() or len(about) < LEAST_DAYS:
                continue
            line = line_of(watched.days[about], relative[about])
            if line is None or line.rate.low <= LEAST <= line.rate.high:
                continue
            found.append((number, line.rate.low > LEAST, bool(on[rows[inside][-1]])))
    return found
