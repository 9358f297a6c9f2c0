"""Pictures of the study `road-classes`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, ScalarFormatter

from estimators.scores.interval import Interval
from testbed.study.road_classes.cells import FULL, PRESSURES, SPEEDS, Cell
from testbed.study.road_classes.expectations import Deviation
from testbed.study.road_classes.linearised import frequencies
from testbed.study.road_classes.quantities import AXLES, ERRORS, QUANTITIES, SHOWN, Rows, by_cell, values
from testbed.study.study import Row

COLOURS = dict(zip(SPEEDS, ("C0", "C1", "C2", "C3", "C4", "C5", "C6", "C7"), strict=True))
SHADES = dict(zip(PRESSURES, ("C0", "C1", "C2"), strict=True))


def figures(rows: Rows, deviations: Sequence[Deviation]) -> dict[str, Figure]:
    """By file name."""
    drawn = {"ride-and-load": _ride_and_load(rows), "frequencies": _frequencies(rows), "estimate-errors": _errors(rows)}
    if deviations:
        drawn["deviations"] = _deviations(deviations)
    return drawn


def _mean(drives: Rows, quantity: str) -> Interval:
    """Mean over drives and the range in which they lie; nan without any."""
    x = values(drives, quantity)
    x = x[np.isfinite(x)]
    return Interval(x.mean(), x.min(), x.max()) if len(x) else Interval(*[np.nan] * 3)


def _points(
    axes: Any, drives: Mapping[float, Rows], quantity: str, scale: float, shift: float = 1.0, **style: Any
) -> None:
    """Mean and range over drives against speed [km/h]."""
    speeds = np.array(sorted(drives))
    points = [_mean(drives[v], quantity) for v in speeds]
    mean = scale * np.array([p.value for p in points])
    reach = np.abs(scale * np.array([[p.low, p.high] for p in points]).T - mean)
    axes.errorbar(shift * speeds, mean, reach, capsize=2, markersize=4, **style)


def _chosen(rows: Rows, **wanted: Any) -> dict[float, list[Row]]:
    """Drives by speed of the cells with these fields."""
    cells = by_cell(rows)
    found: dict[float, list[Row]] = {}
    for cell in FULL:
        if cell.name in cells and all(getattr(cell, key) == value for key, value in wanted.items()):
            found.setdefault(cell.speed, []).extend(cells[cell.name])
    return found


def _ride_and_load(rows: Rows) -> Figure:
    figure = Figure(figsize=(10.0, 4.5), layout="constrained")
    ride, load = figure.subplots(1, 2)
    for road, colour in COLOURS.items():
        drives = _chosen(rows, road=road, pressure=PRESSURES[0])
        if road == "H" or not drives:
            continue
        _points(ride, drives, "ride", 1.0, fmt="o-", color=colour, label=road)
        _points(load, drives, "load_variation/front", 100.0, fmt="o-", color=colour, label=f"{road} front")
        _points(load, drives, "load_variation/rear", 100.0, 1.04, fmt="s--", color=colour, mfc="none")
    for axes in (ride, load):
        axes.set(
            xlabel="speed [km/h]",
            xscale="log",
            yscale="log",
            xticks=(5, 10, 20, 50, 100),
            xticklabels=("5", "10", "20", "50", "100"),
        )
        axes.legend(title="ISO 8608 class", ncols=2, fontsize="small")
    for axes, ticks in ((ride, (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)), (load, (2.0, 5.0, 10.0, 20.0, 50.0, 100.0))):
        low, high = axes.get_ylim()
        axes.set_yticks([t for t in ticks if low <= t <= high], [f"{t:g}" for t in ticks if low <= t <= high])
        axes.yaxis.set_minor_formatter(NullFormatter())
    ride.set(
        ylabel="vertical acceleration at the CG, weighted Wk, r.m.s. [m/s$^2$]", title=f"Ride, {PRESSURES[0]:g} kPa"
    )
    load.set(
        ylabel="standard deviation of tyre load over its mean [%]", title="Load variation, front filled, rear open"
    )
    return figure


def _frequencies(rows: Rows) -> Figure:
    """Each axle a row of panels, each mode a column."""
    figure = Figure(figsize=(11.0, 7.0), layout="constrained")
    panels = figure.subplots(2, 3, sharex=True)
    speeds = np.geomspace(5.0, 120.0, 8)
    for row, axle in zip(panels, AXLES, strict=True):
        for axes, kind in zip(row, ("hop", "in_phase", "antiphase"), strict=True):
            for i, (pressure, colour) in enumerate(SHADES.items()):
                drives = _chosen(rows, pressure=pressure)
                _points(
                    axes,
                    drives,
                    f"{kind}/{axle}",
                    1.0,
                    1.0 + 0.04 * (i - 1),
                    fmt="o",
                    color=colour,
                    label=f"{pressure:g} kPa, drives",
                )
                known = [frequencies(float(v), pressure).get(f"{kind}/{axle}", np.nan) for v in speeds]
                axes.plot(speeds, known, color=colour, lw=1.0, label=f"{pressure:g} kPa, linearised")
            axes.set(title=f"{SHOWN[kind][0]}, {axle}", ylabel="natural frequency [Hz]", xscale="log")
            axes.set_xticks((5, 10, 20, 50, 100), ("5", "10", "20", "50", "100"))
    for axes in panels[-1]:
        axes.set_xlabel("speed [km/h]")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=6, fontsize="small")
    return figure


def _errors(rows: Rows) -> Figure:
    """Error of each residual by class, beside the std that was reported."""
    figure = Figure(figsize=(11.0, 4.5), layout="constrained")
    cells, roads = by_cell(rows), [road for road in SPEEDS if road != "H"]
    of_road = {road: [r for c in FULL if c.road == road for r in cells.get(c.name, [])] for road in roads}
    for axes, quantity in zip(figure.subplots(1, len(ERRORS), sharey=True), ERRORS, strict=True):
        name = quantity.removeprefix("error/")
        for i, road in enumerate(roads):
            x = 1e3 * values(of_road[road], quantity)
            x = x[np.isfinite(x)]
            std = 1e3 * np.sqrt(np.nanmean(values(of_road[road], f"std/{name}") ** 2)) if len(x) else np.nan
            axes.plot(np.full(len(x), i) + np.linspace(-0.25, 0.25, len(x)), x, ".", ms=3, color=COLOURS[road])
            axes.plot([i - 0.35, i + 0.35], [std, std], "k-", [i - 0.35, i + 0.35], [-std, -std], "k-", lw=1.0)
        axes.set(title=name, xlabel="ISO 8608 class")
        axes.set_xticks(range(len(roads)), roads)
        axes.set_yscale("symlog", linthresh=1.0)
        axes.set_yticks([-5.0, -2.0, -1.0, 0.0, 1.0, 2.0, 5.0])
        axes.yaxis.set_major_formatter(ScalarFormatter())
    figure.axes[0].set_ylabel("error after 30 s at constant speed [1e-3]; lines: reported std")
    return figure


def _deviations(deviations: Sequence[Deviation]) -> Figure:
    """t over its limit of each cell and quantity: beyond 1 is an objection."""
    single = {d.what: d.t / d.limit for d in deviations if "," in d.what}
    cells: list[Cell] = [c for c in FULL if any(f"{c.name}, {q}" in single for q in QUANTITIES)]
    table = [[single.get(f"{c.name}, {q}", np.nan) for q in QUANTITIES] for c in cells]
    figure = Figure(figsize=(8.0, 2.0 + 0.17 * len(cells)), layout="constrained")
    axes = figure.subplots()
    picture = axes.imshow(table, cmap="RdBu_r", vmin=-1.0, vmax=1.0, aspect="auto")
    axes.set_xticks(range(len(QUANTITIES)), QUANTITIES, rotation=60, ha="right", fontsize="x-small")
    axes.set_yticks(range(len(cells)), [c.name for c in cells], fontsize="x-small")
    axes.grid(visible=False)
    axes.set_title("Deviation from what was learnt, t over its limit (white gaps: nothing expected)")
    figure.colorbar(picture, label="t / limit [-]")
    return figure
