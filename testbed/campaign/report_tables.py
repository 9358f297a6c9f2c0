"""The report's tables as HTML. A figure stands over its 95 % interval; a dash where the drives do not tell."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from testbed.campaign.report_figures import colour

Figures = Mapping[str, Any]
DASH, MINUS = "–", "−"
TINY = 1e-12  # what rounding leaves of a bias that is 0 by construction


def number(value: float | None) -> str:
    """Three significant digits, without an exponent where that is readable."""
    if value is None:
        return DASH
    if abs(value) < TINY:
        return "0"
    digits = f"{value:.3g}" if abs(value) >= 1e-3 else f"{value:.1e}"
    if "e+" in digits:
        digits = f"{float(digits):.0f}"
    return digits.replace("-", MINUS, 1) if value < 0.0 else digits


def with_interval(entry: Figures | None, scale: float = 1.0) -> str:
    """A figure and its interval (`here`, `ci95`) as a cell's content."""
    if entry is None:
        return DASH
    value, low, high = (None if v is None else scale * v for v in (entry["here"], *entry["ci95"]))
    if value is None and low is None:
        return "not reached"
    limits = f"{DASH if low is None else number(low)} to {'∞' if high is None else number(high)}"
    return f'{"not reached" if value is None else number(value)}<span class="ci">{limits}</span>'


def table(heads: Sequence[str], rows: Iterable[tuple[str, Sequence[str]]], texts: int, caption: str = "") -> str:
    """heads; rows as class and cells (HTML); texts: how many of the first columns are text and not numbers."""
    kind = [' class="name"' if i < texts else ' class="n"' for i in range(len(heads))]
    head = "".join(f"<th{k}>{h}</th>" for k, h in zip(kind, heads, strict=True))
    body = "".join(
        f'<tr class="{row}">' + "".join(f"<td{k}>{cell}</td>" for k, cell in zip(kind, cells, strict=True)) + "</tr>\n"
        for row, cells in rows
    )
    told = f"<caption>{caption}</caption>" if caption else ""
    return f'<div class="scroll"><table>{told}<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>'


def driven_table(lines: Iterable[tuple[str, str, str]]) -> str:
    """Lines as of `progress.described`."""
    return table(("field", "", "value"), (("", tuple(map(escape, (n, k, v)))) for k, n, v in lines), 3)


def estimate_table(entries: Sequence[Figures]) -> str:
    """Each method and quantity, then each of its wheels."""
    heads = ("method", "quantity", "RMSE", "bias", "std", "5 to 95 %<br>at the end", "settled<br>after (s)",
             "settled<br>(%)",
             "NEES", "within<br>1 std (%)", "drives")  # fmt: skip
    rows: list[tuple[str, Sequence[str]]] = []
    for entry in entries:
        name = f"{escape(entry['label'])} ({entry['unit']})"
        rows.append(("group", (escape(entry["method"]), name, *_estimate_cells(entry))))
        for wheel, figures in entry["wheels"].items():
            spot = f'<i class="wheel" style="background:{colour(wheel)}"></i>{wheel}'
            rows.append(("part", ("", spot, *_estimate_cells(figures))))
    return table(heads, rows, 2)


def _estimate_cells(figures: Figures) -> tuple[str, ...]:
    over_time = figures["over_time"]
    band = DASH
    if over_time:
        known = [(a, b) for a, b in zip(over_time["q05"], over_time["q95"], strict=True) if None not in (a, b)]
        band = f"{number(known[-1][0])} to {number(known[-1][1])}" if known else DASH
    return (
        *(with_interval(figures[key]) for key in ("rmse", "bias", "std")),
        band,
        with_interval(figures["settling_s"]),
        with_interval(figures["settled"], 100.0),
        with_interval(figures["nees"]),
        with_interval(figures["within_1_std"], 100.0),
        str(figures["drives"]),
    )


def alarm_table(entries: Sequence[Figures]) -> str:
    """A line for each method."""
    heads = ("method", "drives with<br>a low tyre", "of them with<br>an alarm (%)", "median<br>after (s)",
             "95 %<br>after (s)",
             "right<br>wheel (%)", "false<br>alarms", "sound<br>hours", "false<br>per hour")  # fmt: skip
    return table(heads, (("group", (escape(e["method"]), *_alarm_cells(e))) for e in entries), 1)


def _alarm_cells(entry: Figures) -> tuple[str, ...]:
    false = entry["false_alarms"]
    return (
        str(entry["faulty_drives"]),
        with_interval(entry["detected"], 100.0),
        with_interval(entry["detection_s"]),
        with_interval(entry["detection_95_s"]),
        with_interval(entry["isolated"], 100.0),
        *((str(false["count"]), number(false["hours"]), with_interval(false["per_hour"])) if false else (DASH,) * 3),
    )


def statistic_table(entries: Sequence[Figures]) -> str:
    """What the estimates could tell at any threshold; empty without a method that gives wheel by wheel."""
    rows: list[tuple[str, Sequence[str]]] = []
    for entry in entries:
        roc, tail = entry["roc"], entry["tail"]
        if roc or tail:
            found = (with_interval(roc["area"]), with_interval(roc["detected"], 100.0), with_interval(roc["threshold"]),
                     f"{roc['sound']} / {roc['faulty']}") if roc else (DASH,) * 4  # fmt: skip
            reach = with_interval(tail["threshold"]) if tail else DASH
            rows.append(("group", (escape(entry["method"]), escape(entry["statistic"]), *found, reach)))
    if not rows:
        return ""
    heads = ("method", "statistic", "area under ROC", "detected (%)<br>at 5 % false", "its threshold",
             "drives, sound / low", "threshold for<br>1 false in 100 h")  # fmt: skip
    return table(heads, rows, 2)
