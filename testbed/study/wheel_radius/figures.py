"""The paper's Figures 6 and 7 with bands over repetitions, and the times to an alarm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from testbed.study.study import Row
from testbed.study.wheel_radius.drives import TEST_RUNS
from testbed.study.wheel_radius.slopes import slope_figure
from testbed.study.wheel_radius.wheel_radius import levels

Rows = Sequence[Row]
FIGURES = {
    "figure-6-front-rear": (("delta13", "r3/r1 - 1, left side"), ("delta24", "r4/r2 - 1, right side")),
    "figure-7-left-right": (("delta12", "r1/r2 - 1, front axle"), ("delta34", "r3/r4 - 1, rear axle")),
}
STYLES = {  # as in the paper: solid nominal, dash-dotted front left, dotted rear left; here by colour as well
    "nominal": ("k", "-"),
    "front left low": ("C0", "-."),
    "front left low after 220 s": ("C9", "-."),
    "rear left low": ("C3", ":"),
    "rear left low after 220 s": ("C1", ":"),
}


def figures(rows: Rows) -> dict[str, Figure]:
    """By file name."""
    return {name: _deltas(rows, panels) for name, panels in FIGURES.items()} | {
        "alarms": _alarms(rows),
        "figure-5-slip-slopes": slope_figure(rows),
    }


def _deltas(rows: Rows, panels: Sequence[tuple[str, str]]) -> Figure:
    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    time = np.array(rows[0]["nominal/time_s"], float)
    for axes, (name, meaning) in zip(figure.subplots(1, 2), panels, strict=True):
        for test_run, (colour, line) in STYLES.items():
            value = 1e3 * np.array([row[f"{test_run}/{name}/value"] for row in rows], float)
            right = 1e3 * levels(rows, test_run, name).mean(axis=0)
            seen = np.isfinite(value).any(axis=0)
            if seen.any():
                low, mid, high = np.nanquantile(value[:, seen], (0.05, 0.5, 0.95), axis=0)
                axes.fill_between(time[seen], low, high, color=colour, alpha=0.12, lw=0.0)
                axes.plot(time[seen], mid, color=colour, ls=line, lw=1.6, label=test_run)
            axes.plot(time, right, color=colour, lw=0.8)
        axes.axvline(rows[0]["onset_s"], color="0.5", lw=0.6)
        axes.set(xlabel="time [s]", ylabel=f"{name} [1e-3]", title=f"{name} = {meaning}")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize="small")
    figure.suptitle(f"Median and 5-95 % band over {len(rows)} repetitions; thin lines: the true level")
    return figure


def _alarms(rows: Rows) -> Figure:
    """Share of repetitions with an alarm by each time since the loss."""
    figure = Figure(figsize=(6.5, 4.0), layout="constrained")
    axes = figure.subplots()
    for test_run, (wheel, from_start) in TEST_RUNS.items():
        if wheel is None:
            continue
        onset = 0.0 if from_start else rows[0]["onset_s"]
        first = [min((t - onset for t in row[f"{test_run}/alarms"] if t >= onset), default=np.inf) for row in rows]
        end = rows[0]["duration_s"] - onset
        times = np.sort([t for t in first if np.isfinite(t)])
        share = np.arange(len(times) + 1) / len(rows)
        colour, line = STYLES[test_run]
        axes.step([0.0, *times, end], [*share, share[-1]], where="post", color=colour, ls=line, label=test_run)
    axes.axvline(60.0, color="0.5", lw=0.6)
    axes.set(
        xlabel="time since the loss, or since the start [s]", ylabel="share of repetitions with an alarm [-]",
        ylim=(-0.02, 1.02), title="First alarm; the paper's claim: within 60 s",
    )  # fmt: skip
    axes.legend(fontsize="small")
    return figure
