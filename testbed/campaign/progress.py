"""What a user sees of a campaign before and while it runs."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from testbed.campaign.plan import Campaign


@contextmanager
def drive_progress(console: Console) -> Iterator[Callable[[int, int], None]]:
    """A bar with time left; what it yields is told the drives done and the drives in all."""
    columns = (
        TextColumn("drives"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(elapsed_when_finished=False),
    )
    with Progress(*columns, console=console, disable=console.quiet, speed_estimate_period=600.0) as bar:
        task = bar.add_task("drives", total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def print_plan(console: Console, campaign: Campaign) -> None:
    """What would run."""
    table = Table(title=campaign.question, box=box.SIMPLE_HEAD, title_justify="left")
    for heading in ("field", "", "value"):
        table.add_column(heading, overflow="fold")
    for kind, name, value in described(campaign):
        table.add_row(name, kind, value)
    table.add_row("estimators", "", ", ".join(campaign.estimators) or "none")
    console.print(table, highlight=False)
    long = duration_text(campaign.driven_seconds)
    console.print(f"{len(campaign.tasks)} drives, {long} of driving with their calibrations", highlight=False)


def described(campaign: Campaign) -> Iterator[tuple[str, str, str]]:
    """fixed, swept or drawn; the field; what it is: a line for each field of the file."""
    for name, value in campaign.fixed.items():
        yield "fixed", name, shown(value)
    for name, values in campaign.swept.items():
        yield "swept", name, ", ".join(map(shown, values))
    for name, distribution in campaign.drawn.items():
        ((kind, numbers),) = distribution.items()
        yield "drawn", name, f"{kind.replace('_', '-')} of {', '.join(map(shown, numbers))}"


def shown(value: Any) -> str:
    """A value of the file as text."""
    return value if isinstance(value, str) else json.dumps(value)


def duration_text(seconds: float) -> str:
    """`about 5 min`."""
    if seconds < 90.0:
        return f"about {seconds:.0f} s"
    return f"about {seconds / 60.0:.0f} min" if seconds < 5400.0 else f"about {seconds / 3600.0:.1f} h"
