"""The table of a study: quantity, paper, here with its interval, limit, unit."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from testbed.study.study import StudyRow

DIGITS, MOST_DIGITS = 4, 6  # significant ones of a figure without an interval, of one with a narrow one


def shown(row: StudyRow) -> str:
    """A figure and its interval, in digits that the interval's width deserves; an end that is not bounded is a dash."""
    if row.here is None or math.isnan(row.here):
        return "-"
    ends = row.ci95 or (math.nan, math.nan)
    width = ends[1] - ends[0]
    form = f".{DIGITS}g"
    if 0.0 < width < math.inf:
        longest = MOST_DIGITS - 1 - math.floor(math.log10(max(abs(row.here), width)))
        form = f".{max(0, min(1 - math.floor(math.log10(width)), longest))}f"
    here = format(row.here, form) if math.isfinite(row.here) else "not reached"
    low, high = (format(end, form) if math.isfinite(end) else "-" for end in ends)
    return here if (low, high) == ("-", "-") else f"{here} [{low}, {high}]"


def _number(value: float | None) -> str:
    return "-" if value is None or math.isnan(value) else f"{value:.{DIGITS}g}"


def print_table(console: Console, title: str, rows: Sequence[StudyRow]) -> None:
    """Every row, in order."""
    table = Table(title=title, box=box.SIMPLE_HEAD)
    table.add_column("quantity", no_wrap=True)
    for heading in ("paper", "here [95 % interval]", "limit"):
        table.add_column(heading, justify="right")
    table.add_column("unit")
    for row in rows:
        table.add_row(row.name, _number(row.paper), shown(row).replace("[", r"\["), _number(row.limit), row.unit)
    console.print(table)
