"""The fleet at a glance, and each finding: pressure, line with band, start, alarm, fillings, the other tyres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter
from matplotlib.figure import Figure

from estimators.slow_leak.numbers import MODEL, MONTH
from testbed.study.fleet_leaks.fleet_leaks import day_name, findings

BEFORE, AFTER = 30, 20  # days shown about a finding
MARKS = {"step up": ("^", "C2", "step up"), "step down": ("v", "C1", "step down")}


def figures(trailers: Sequence[Mapping[str, Any]]) -> dict[str, Figure]:
    """By file name."""
    drawn = {"overview": _overview(trailers)} if trailers else {}
    for number, (trailer, one) in enumerate(findings(trailers), 1):
        drawn[f"finding-{number:02d}-{trailer['name']}-{trailer['tyres'][one['tyre']]}"] = _finding(trailer, one)
    return drawn


def _kpa(values: Sequence[float | None]) -> np.ndarray:
    return 1e-3 * np.array([np.nan if v is None else v for v in values], dtype=np.float64)


def _dates(days: Sequence[float]) -> np.ndarray:
    return (np.asarray(days, dtype=np.float64) * 86400.0).astype("datetime64[s]")


def _calendar(axes: Axes) -> None:
    locator = AutoDateLocator()
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator))


def _overview(trailers: Sequence[Mapping[str, Any]]) -> Figure:
    """Every tyre's days' values; findings shaded in the tyre's colour, alarms as lines."""
    figure = Figure(figsize=(11.0, 2.3 * len(trailers)), layout="constrained")
    panels = np.atleast_1d(figure.subplots(len(trailers), 1, sharex=True))
    for axes, trailer in zip(panels, trailers, strict=True):
        when = _dates(trailer["day"])
        for tyre, name in enumerate(trailer["tyres"]):
            axes.plot(when, _kpa(trailer["pressure"][tyre]), ".", ms=1.5, color=f"C{tyre}", label=name)
        for one in trailer["findings"]:
            colour = f"C{one['tyre']}"
            axes.axvspan(*_dates([one["start"], one["end"]]), color=colour, alpha=0.12, lw=0.0)
            axes.axvline(_dates([one["alarm"]])[0], color=colour, lw=0.9)
        tuning = ", tuned on" if trailer["tuning"] else ""
        axes.set_title(f"trailer {trailer['name']}{tuning}: {len(trailer['findings'])} findings", fontsize="medium")
        axes.set_ylabel("pressure [kPa]")
        axes.legend(
            title="tyre", fontsize="x-small", title_fontsize="x-small", ncols=2, markerscale=4, loc="lower left"
        )
    _calendar(panels[-1])
    return figure


def _finding(trailer: Mapping[str, Any], one: Mapping[str, Any]) -> Figure:
    figure = Figure(figsize=(8.0, 7.5), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 1.3))
    day, tyre = np.array(trailer["day"]), one["tyre"]
    shown = (day >= one["start"] - BEFORE) & (day <= one["end"] + AFTER)
    when = _dates(day[shown])
    for other, name in enumerate(trailer["tyres"]):
        mine = other == tyre
        top.plot(
            when, _kpa(trailer["pressure"][other])[shown], "o-" if mine else "-", ms=2.5, lw=1.0 if mine else 0.7,
            color="k" if mine else f"C{other}", alpha=1.0 if mine else 0.6, label=f"tyre {name}",
        )  # fmt: skip
    relative = _kpa(trailer["relative"][tyre])
    middle.plot(when, relative[shown], "ko", ms=2.5, label=f"tyre {trailer['tyres'][tyre]} less the others")
    rate = ""
    for line, colour, name in ((one["at_alarm"], "C0", "line at the alarm"), (one["whole"], "C3", "whole finding")):
        if line is None:
            continue
        level, reach, x = np.array(line["level"]) / 1e3, np.array(line["reach"]) / 1e3, _dates(line["day"])
        value, low, high = (1e-3 * MONTH * v for v in line["rate"])
        label = f"{name}: {value:.0f} kPa/month [{low:.0f}, {high:.0f}]"
        middle.plot(x, level, color=colour, lw=1.2, label=label)
        middle.fill_between(x, level - reach, level + reach, color=colour, alpha=0.2, lw=0.0)
        rate = f", {value:.0f} kPa/month [{low:.0f}, {high:.0f}]"
    for step in trailer["steps"][tyre]:
        at, kind = step["day"], step["kind"]
        if one["start"] - BEFORE <= at <= one["end"] + AFTER:
            shape, colour, name = MARKS[kind]
            value = relative[np.flatnonzero(day == at)[0]]
            said = middle.get_legend_handles_labels()[1]
            middle.plot(_dates([at]), [value], shape, color=colour, ms=8, label="_" if name in said else name)
    bottom.plot(when, _values(trailer["statistic"][tyre])[shown], "k.-", lw=0.8, ms=2)
    bottom.axhline(MODEL.threshold, color="C3", ls="--", lw=0.8, label="threshold")
    for axes in (top, middle, bottom):
        axes.axvline(_dates([one["start"]])[0], color="C0", ls=":", lw=1.2, label="start")
        axes.axvline(_dates([one["alarm"]])[0], color="C3", lw=1.2, label="alarm")
        axes.axvline(_dates([one["end"]])[0], color="0.5", ls="--", lw=0.9, label=f"end ({one['ending']})")
    top.set(ylabel="pressure [kPa]")
    middle.set(ylabel="less the others [kPa]")
    bottom.set(ylabel="CUSUM [std]")
    top.legend(fontsize="x-small", ncols=3)
    middle.legend(fontsize="x-small")
    bottom.legend(fontsize="x-small", loc="upper left")
    top.set_title(
        f"trailer {trailer['name']}, tyre {trailer['tyres'][tyre]}, from {day_name(one['start'])}, alarm "
        f"{day_name(one['alarm'])}{rate}: judged {one['verdict']}", fontsize="small",
    )  # fmt: skip
    _calendar(bottom)
    return figure


def _values(values: Sequence[float | None]) -> np.ndarray:
    return np.array([np.nan if v is None else v for v in values], dtype=np.float64)
