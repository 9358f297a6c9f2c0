"""Figures of `wheel-plausibility`: how soon which size is found, equivalents of Figures 6.3 and 6.4, the geometries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from estimators.drive_log import WHEELS
from estimators.scores.survival import event_curve
from estimators.wheel_plausibility.geometry import GEOMETRIES
from estimators.wheel_plausibility.published import METHODS
from testbed.study.wheel_plausibility.paper import RESIDUALS
from testbed.study.wheel_plausibility.trials import SINGLE
from testbed.study.wheel_plausibility.wheel_plausibility import CIRCLE, NAMES, delays


def figures(rows: Sequence[Mapping[str, Any]]) -> dict[str, Figure]:
    """By file name."""
    cases = [case for row in rows for case in row["cases"] if not case["ended"]]
    found = {"delay-by-size": _delays(cases)}
    if circles := [case for case in cases if case["name"] == CIRCLE]:
        found["residuals-in-the-circle"] = _residuals(circles)
    examples = next((row["example"] for row in rows if row["example"]), None)
    return found | ({"figures-6-3-and-6-4": _examples(examples)} if examples else {})


def _delays(cases: Sequence[Mapping[str, Any]]) -> Figure:
    """95 % of the outliers of each size."""
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    for method in ("monitor", *METHODS):
        points = []
        for sizes in SINGLE:
            events = delays(cases, method, sizes)
            value = event_curve(events).quantile(0.95).value if events else np.inf
            points.append(value if np.isfinite(value) else np.nan)
        axes.plot([sizes[0] for sizes in SINGLE], points, "o-", label=method.replace("_", " "))
    axes.axhline(1.0, color="grey", linestyle=":", label="asked at 13 km/h")
    axes.axvline(13.0, color="grey", linestyle=":")
    axes.set(xlabel="outlier [km/h]", ylabel="95 % are named after [s]; not drawn: not within 3 s", xscale="log")
    axes.set_xticks([6, 13, 20, 50], ["6", "13", "20", "50"])
    axes.set_ylim(bottom=0.0)
    axes.legend(fontsize="small")
    return figure


def _residuals(circles: Sequence[Mapping[str, Any]]) -> Figure:
    figure = Figure(figsize=(9, 4), layout="constrained")
    axes = figure.subplots()
    place = np.arange(len(NAMES))
    for k, geometry in enumerate(GEOMETRIES):
        means = np.mean([case["residuals"][geometry] for case in circles], axis=0)
        (bars,) = axes.plot(place + 0.2 * (k - 1), means, "o", label=geometry)
        axes.plot(place + 0.2 * (k - 1), RESIDUALS[f"circle.{geometry}"], "x", color=bars.get_color())
    axes.set_xticks(place, NAMES, rotation=45, ha="right", fontsize="small")
    axes.set(ylabel="mean [km/h]; crosses: the thesis", title="circle of 10 m at 18 km/h")
    axes.legend(fontsize="small")
    return figure


def _examples(examples: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Wheels, the car's true and estimated speed; what is accused is thick."""
    figure = Figure(figsize=(10, 2.6 * len(examples)), layout="constrained")
    for axes, (name, series) in zip(
        figure.subplots(len(examples), 1, squeeze=False).flat, examples.items(), strict=True
    ):
        time, speeds, accused = (np.array(series[key]) for key in ("time", "wheels", "accused"))
        for i, wheel in enumerate(WHEELS):
            (line,) = axes.plot(time, speeds[:, i], linewidth=0.8, label=wheel)
            axes.plot(
                time, np.where(accused[:, i], speeds[:, i], np.nan), linewidth=3.5, alpha=0.5, color=line.get_color()
            )
        axes.plot(time, series["truth"], "k", linewidth=1.2, label="car")
        axes.plot(time, series["speed"], "k--", linewidth=0.9, label="estimated")
        axes.set(title=f"{name} (friction); thick: accused", ylabel="[km/h]")
        top = np.array(series["truth"]).max()
        axes.set_ylim(-3.0, 2.0 * top + 10.0)
    axes.legend(ncols=6, fontsize="small")
    axes.set_xlabel("time [s]")
    return figure
