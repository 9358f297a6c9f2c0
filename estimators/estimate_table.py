"""What estimators said last, as tables to read: a column a wheel, a row a quantity, and the quantities of the car.

Pressures in kPa, changes of a ratio in percent, each number as fine as its standard deviation tells (two digits of
it); an exact one (a flag) without a deviation.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Mapping
from typing import Any

from rich import box
from rich.table import Table

from estimators.drive_log import WHEELS

Entry = Mapping[str, Any]  # value, std (either may be None) and unit, SI
SHOWN = {"Pa": ("kPa", 1e-3), "N/m": ("kN/m", 1e-3), "m": ("mm", 1e3)}
_LABEL = 26  # characters: with four wheels it fits 80 columns
_FINEST = 6  # digits after the point
_IN_PERCENT = ("change", "residual", "published", "delta12", "delta34", "delta13", "delta24")  # ends of their names


def unit_shown(quantity: str, unit: str) -> tuple[str, float]:
    """Unit of the tables and the factor from SI to it; `-` for a plain number."""
    if not unit and quantity.endswith(_IN_PERCENT):
        return "%", 100.0
    return SHOWN.get(unit, (unit or "-", 1.0))


def number(value: float | None, std: float | None = None) -> str:
    """`248.9±2.3`; `-` for None."""
    if value is None:
        return "-"
    if not std or not math.isfinite(std):
        return f"{value:.4g}"
    digits = max(1 - math.floor(math.log10(std)), 0)
    if digits > _FINEST:
        return f"{value:.{_FINEST}f}"
    return f"{value:.{digits}f}±{std:.{digits}f}"


def wheel_of(quantity: str) -> str | None:
    """The wheel of `WHEEL/quantity`."""
    first = quantity.split("/", 1)[0]
    return first if first in WHEELS and "/" in quantity else None


def wheel_table(title: str) -> Table:
    """A column a wheel, no rows yet."""
    table = Table(title=title, box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("", max_width=_LABEL)
    for wheel in WHEELS:
        table.add_column(wheel, justify="right", no_wrap=True)
    return table


def estimate_tables(methods: Mapping[str, Mapping[str, Entry]], ending: str) -> Iterable[Table]:
    """Of the wheels, then of the car as a whole; a table without rows is left out. methods: name -> quantity (`fl/x`
    or `x`) -> entry. ending: of the titles, when it was said."""
    wheels = wheel_table(f"wheel by wheel, {ending}")
    whole = Table(title=f"whole car, {ending}", box=box.SIMPLE_HEAD, show_header=False)
    whole.add_column("", no_wrap=True)
    whole.add_column("", justify="right")
    for method, entries in methods.items():
        _add_wheels(wheels, method, entries)
        _add_whole(whole, method, entries)
    return [table for table in (wheels, whole) if table.row_count]


def _add_wheels(table: Table, method: str, entries: Mapping[str, Entry]) -> None:
    rows: dict[str, dict[str, Entry]] = {}
    for quantity, entry in entries.items():
        if wheel := wheel_of(quantity):
            rows.setdefault(quantity.split("/", 1)[1], {})[wheel] = entry
    if rows:
        table.add_row(f"[bold]{method}[/]")
    for quantity, row in rows.items():
        unit, scale = unit_shown(quantity, next(iter(row.values()))["unit"])
        table.add_row(
            _label(quantity, unit), *(_scaled(row[wheel], scale) if wheel in row else "-" for wheel in WHEELS)
        )


def _add_whole(table: Table, method: str, entries: Mapping[str, Entry]) -> None:
    rest = {quantity: entry for quantity, entry in entries.items() if not wheel_of(quantity)}
    if rest:
        table.add_row(f"[bold]{method}[/]")
    for quantity, entry in rest.items():
        unit, scale = unit_shown(quantity, entry["unit"])
        table.add_row(_label(quantity, unit), _scaled(entry, scale))


def _label(quantity: str, unit: str) -> str:
    """Name of a row, below its method's."""
    words = quantity.replace("_", " ").replace("/", " ")
    whole = words if unit == "-" else f"{words} ({unit})"
    return textwrap.fill(whole, _LABEL, initial_indent="  ", subsequent_indent="    ", break_long_words=False)


def _scaled(entry: Entry, scale: float) -> str:
    value, std = (None if entry[key] is None else entry[key] * scale for key in ("value", "std"))
    return number(value, std)
