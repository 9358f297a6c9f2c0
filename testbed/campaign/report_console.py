"""The table that a campaign ends with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table

from testbed.campaign.report_tables import number

Figures = Mapping[str, Any]


def _text(entry: Figures | None, scale: float = 1.0) -> str:
    if entry is None or entry["here"] is None:
        return "-"
    low, high = (("∞" if v is None else number(scale * v)) for v in entry["ci95"])
    return f"{number(scale * entry['here'])} ({low} to {high})"


def print_scores(console: Console, scores: Figures) -> None:
    """Estimates by method and quantity, alarms by method, failures."""
    title = f"{scores['drives']} drives, {number(scores['hours'])} h, {len(scores['failed'])} failed"
    table = Table(title=title, box=box.SIMPLE_HEAD, caption="in brackets: 95 % interval")
    for heading in ("method", "quantity", "RMSE", "bias", "settled %", "NEES"):
        table.add_column(heading, overflow="fold")
    for entry in scores["estimates"]:
        figures = (_text(entry["rmse"]), _text(entry["bias"]), _text(entry["settled"], 100.0), _text(entry["nees"]))
        table.add_row(entry["method"], f"{entry['label']} ({entry['unit']})", *figures)
    console.print(table)
    for entry in scores["alarms"]:
        for line in _alarm_lines(entry):
            console.print(f"{entry['method']}: {line}", highlight=False)
    for entry in scores["failed"][:5]:
        console.print(f"drive {entry['number']} failed: {entry['error']}", highlight=False, markup=False)


def _alarm_lines(entry: Figures) -> Iterator[str]:
    false = entry["false_alarms"]
    if entry["detected"]:
        share = f"alarm on {_text(entry['detected'], 100.0)} % of {entry['faulty_drives']} drives with a low tyre"
        yield (
            share if entry["detection_s"]["here"] is None else f"{share}, median after {_text(entry['detection_s'])} s"
        )
    if false:
        rate = _text(false["per_hour"])
        yield f"false alarms {false['count']} in {number(false['hours'])} sound hours, {rate} an hour"
