"""Figures of the study: the thesis' curves with the exact ones beside them, and what was simulated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from testbed.study.detector_design.designs import KINDS, ratios
from testbed.study.detector_design.figures_of_curves import curves
from testbed.study.detector_design.figures_of_residuals import conformed, local
from testbed.study.detector_design.rates import inverse
from testbed.study.detector_design.thresholds import CASES, PART, SAMPLES, alarm_rate, exact_run_length
from testbed.study.study import Row


def figures(rows: Sequence[Row]) -> dict[str, Figure]:
    """By file name; of the small form those of its rows alone, as drawing the others takes longer than its work."""
    drawn = {"run-lengths": _run_lengths(rows), "figures-4.7-4.12-thresholds": _thresholds(rows), **local(rows)}
    small = any(row["part"] == PART and max(row["samples"]) < SAMPLES for row in rows)
    return drawn if small else drawn | curves() | conformed()


def _run_lengths(rows: Sequence[Row]) -> Figure:
    """Stated over simulated, every design."""
    figure = Figure(figsize=(8.0, 4.8), layout="constrained")
    axes = figure.subplots()
    found = ratios(rows)
    for number, kind in enumerate(KINDS):
        own = [(asked, ratio) for (name, asked), ratio in found.items() if name == kind]
        shift = 1.0 + 0.05 * (number - len(KINDS) / 2.0)
        value = np.array([ratio.value for _, ratio in own])
        ends = np.array([[r.value - r.low, r.high - r.value] for _, r in own]).reshape(-1, 2).T
        axes.errorbar(
            [asked * shift for asked, _ in own], value, ends, fmt="os^D"[number % 4], color=f"C{number % 10}", ms=4.0,
            lw=1.0, label=kind,
        )  # fmt: skip
    axes.axhspan(0.95, 1.05, color="0.92")
    axes.axhline(1.0, color="0.5", lw=0.8)
    axes.set(
        xscale="log", xlabel="ARL0 asked for [samples]", ylabel="stated over simulated ARL0 [-]",
        title=f"{len(found)} designs, with 95 % intervals",
    )  # fmt: skip
    figure.legend(fontsize="small", loc="outside right upper")
    return figure


def _thresholds(rows: Sequence[Row]) -> Figure:
    """What was asked of the twelve printed thresholds, and what they have."""
    figure = Figure(figsize=(11.0, 5.0), layout="constrained")
    axes = figure.subplots()
    own = [row for row in rows if row["part"] == PART]
    place = np.arange(len(CASES))
    axes.plot(place, [t.asked for t, _, _ in CASES], "k_", ms=16.0, mew=1.5, label="asked for, 1/FAR")
    axes.plot(place, [exact_run_length(t, std) for t, _, std in CASES], "o", color="C0", mfc="none", label="exact")
    for label, marker, reached in (("simulated", "s", True), ("no alarm: lower end of the interval", "^", False)):
        kept = [i for i in place if (sum(row["alarms"][i] for row in own) > 0) == reached] if own else []
        seen = [inverse(alarm_rate(own, int(i))) for i in kept]
        if reached:
            ends = [[s.value - s.low for s in seen], [s.high - s.value for s in seen]]
            axes.errorbar(kept, [s.value for s in seen], ends, fmt=marker, color="C3", ms=4.0, label=label)
        else:
            axes.plot(kept, [s.low for s in seen], marker, color="C3", ms=5.0, mfc="none", label=label)
    _name_cases(axes, place)
    axes.set(yscale="log", ylabel="ARL0 [samples]", title="The thesis' twelve thresholds, Figures 4.7 to 4.12")
    axes.legend(fontsize="small")
    return figure


def _name_cases(axes: Axes, place: np.ndarray) -> None:
    axes.set_xticks(place, [f"{t.name}{reading}" for t, reading, _ in CASES], rotation=60, ha="right", fontsize=7.0)
