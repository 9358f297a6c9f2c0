"""The report's figures, drawn by matplotlib as SVG: vectors that print well and need neither a script nor the network.

Wheels have the colours of the recording; methods those of METHODS. Units stand in the axes' names.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import special

from testbed.recording.series import WHEEL_COLOURS

WIDTH = 10.4  # inches of a page's width
LINE = "#30353d"
METHODS = ("#3b5b92", "#b5502b", "#4d8a57", "#8a5aa3", "#a88420", "#3a8c98", "#a0405f", "#666666")
STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#6b7280",
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e3e6eb",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "svg.hashsalt": "campaign",
}
SHARES = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 90.0)  # % on the axes of a DET
Figures = Mapping[str, Any]


def svg(figure: Figure) -> str:
    """The figure as SVG text, the same for the same data."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    return out.getvalue()


def colour(wheel: str | None) -> str:
    """Of a wheel, or of the car as a whole."""
    return "#{:02x}{:02x}{:02x}".format(*WHEEL_COLOURS[wheel]) if wheel else LINE


def numbers(values: Sequence[float | None]) -> NDArray[np.float64]:
    """JSON values as an array, NaN for null."""
    return np.array([np.nan if v is None else v for v in values], dtype=np.float64)


def error_over_time(panels: Sequence[tuple[str, str | None, Figures]], unit: str) -> str:
    """Panels side by side: title, wheel, `over_time`. Line: bias with its interval; shaded: 5 to 95 % of the drives."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.5), layout="constrained")
        every = np.atleast_1d(figure.subplots(1, max(len(panels), 4), sharex=True, sharey=True))
        for axes, (title, wheel, over_time) in zip(every, panels, strict=False):
            _error_panel(axes, over_time, colour(wheel))
            axes.set_title(title, loc="left", color=colour(wheel), fontweight="bold")
            axes.set_xlabel("time (s)")
        for axes in every[len(panels) :]:
            axes.set_axis_off()
        every[0].set_ylabel(f"error ({unit})")
        return svg(figure)


def _error_panel(axes: Axes, over_time: Figures, tone: str) -> None:
    time = numbers(over_time["time_s"])
    bias, low, high = (numbers(v) for v in (over_time["bias"], *over_time["bias_ci95"]))
    axes.axhline(0.0, color=LINE, linewidth=0.7)
    axes.fill_between(time, numbers(over_time["q05"]), numbers(over_time["q95"]), color=tone, alpha=0.2, linewidth=0)
    axes.fill_between(time, low, high, color=tone, alpha=0.45, linewidth=0)
    mark = "o" if len(time) < 3 else None
    axes.plot(time, bias, color=tone, linewidth=1.4, marker=mark, markersize=3)


def detection_curves(alarms: Sequence[Figures]) -> str | None:
    """Share of drives with an alarm by the time since a tyre was low, with its band; None where none was low."""
    drawn = [(i, entry) for i, entry in enumerate(alarms) if entry["detection_curve"]]
    if not drawn:
        return None
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(0.72 * WIDTH, 3.2), layout="constrained")
        axes = figure.subplots()
        for i, entry in drawn:
            curve, tone = entry["detection_curve"], METHODS[i % len(METHODS)]
            time = np.concatenate([[0.0], numbers(curve["time_s"]), [curve["watched_s"]]])
            share, low, high = (_steps(v) for v in (curve["share"], *curve["share_ci95"]))
            axes.fill_between(time, low, high, step="post", color=tone, alpha=0.18, linewidth=0)
            axes.step(time, share, where="post", color=tone, linewidth=1.6, label=entry["method"])
        if not any(entry["detection_curve"]["time_s"] for _, entry in drawn):
            axes.text(0.5, 0.5, "no alarm", transform=axes.transAxes, ha="center", color=LINE)
        axes.set(xlabel="time since a tyre is low (s)", ylabel="drives with an alarm (%)", ylim=(-2.0, 102.0))
        axes.set_xlim(left=0.0)
        figure.legend(loc="outside right upper")
        return svg(figure)


def _steps(share: Sequence[float | None]) -> NDArray[np.float64]:
    """From 0 at the start to the last value, which holds to the end, in per cent."""
    values = np.concatenate([[0.0], numbers(share)])
    return 100.0 * np.append(values, values[-1])


def roc_and_det(alarms: Sequence[Figures]) -> str | None:
    """ROC and DET of every method that has one; None without any."""
    drawn = [(i, entry) for i, entry in enumerate(alarms) if entry["roc"]]
    if not drawn:
        return None
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.9), layout="constrained")
        left, right = figure.subplots(1, 2)
        for i, entry in drawn:
            curve, tone = entry["roc"], METHODS[i % len(METHODS)]
            false, found, low, high = (
                numbers(v) for v in (curve["false_alarm"], curve["detection"], *curve["detection_ci95"])
            )
            left.fill_between(100 * false, 100 * low, 100 * high, step="post", color=tone, alpha=0.18, linewidth=0)
            left.step(100 * false, 100 * found, where="post", color=tone, linewidth=1.6, label=entry["method"])
            right.step(special.ndtri(false), special.ndtri(1.0 - found), where="post", color=tone, linewidth=1.6)
        left.plot([0, 100], [0, 100], color="#9aa1ab", linewidth=0.8, linestyle=":")
        left.set(xlabel="sound drives above the threshold (%)", ylabel="low-tyre drives above it (%)")
        left.set(xlim=(-2, 102), ylim=(-2, 102), title="ROC")
        ticks = special.ndtri(0.01 * np.array(SHARES))
        labels = [f"{share:g}" for share in SHARES]
        right.set_xticks(ticks, labels)
        right.set_yticks(ticks, labels)
        right.set(xlabel="sound drives above the threshold (%)", ylabel="low-tyre drives missed (%)", title="DET")
        right.set(xlim=(ticks[0], ticks[-1]), ylim=(ticks[0], ticks[-1]))
        if all(entry["roc"]["area"]["here"] == 1.0 for _, entry in drawn):
            right.text(0.5, 0.5, "no drive on the wrong side", transform=right.transAxes, ha="center", color=LINE)
        figure.legend(loc="outside right upper")
        return svg(figure)


def heat_maps(maps: Figures) -> str:
    """A map of RMSE for each method and quantity over the two fields, its value in each cell."""
    columns = 3
    rows = -(-len(maps["maps"]) // columns)
    with matplotlib.rc_context(STYLE | {"axes.grid": False}):
        height = 1.1 + max(0.32 * len(maps["y_labels"]), 1.1)
        figure = Figure(figsize=(WIDTH, rows * height), layout="constrained")
        every = figure.subplots(rows, columns, squeeze=False)
        for axes, entry in zip(every.ravel(), maps["maps"], strict=False):
            _heat_map(figure, axes, entry, maps)
        for axes in every.ravel()[len(maps["maps"]) :]:
            axes.set_axis_off()
        return svg(figure)


def _heat_map(figure: Figure, axes: Axes, entry: Figures, maps: Figures) -> None:
    table = np.array([[cell["rmse"]["here"] if cell else np.nan for cell in column] for column in entry["cells"]]).T
    image = axes.imshow(table, origin="lower", aspect="auto", cmap="YlOrBr", vmin=0.0, vmax=1.4 * np.nanmax(table))
    axes.set_xticks(range(len(maps["x_labels"])), maps["x_labels"])
    axes.set_yticks(range(len(maps["y_labels"])), maps["y_labels"])
    axes.set(xlabel=axis_name(maps["x"]), ylabel=axis_name(maps["y"]))
    axes.set_title(f"{entry['method']}: {entry['label']}", loc="left")
    middle = 0.9 * np.nanmax(table)
    for (j, i), value in np.ndenumerate(table):
        if np.isfinite(value):
            tone = "white" if value > middle else LINE
            axes.text(i, j, f"{value:.3g}", ha="center", va="center", color=tone, fontsize=8.5)
    figure.colorbar(image, ax=axes, label=f"RMSE ({entry['unit']})")


def axis_name(field: str) -> str:
    """`speed (km/h)` of `speed_kmh`: the unit that a field's name ends in, in brackets."""
    units = {"_kmh": "km/h", "_kpa": "kPa", "_kpa_s": "kPa/s", "_kg": "kg", "_percent": "%", "_c": "°C", "_s": "s",
             "_m": "m", "_gd": "m³"}  # fmt: skip
    name, *wheel = field.split(".", 1)
    for ending in sorted(units, key=len, reverse=True):
        if name.endswith(ending):
            name = f"{name.removesuffix(ending)} {' '.join(wheel)}".strip()
            return f"{name.replace('_', ' ')} ({units[ending]})"
    return field.replace("_", " ")
