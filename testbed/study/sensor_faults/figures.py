"""The seed's Figures 6 to 15 from the study's even drive, and what share of faults is told in which time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from estimators.redundancy.residual import transformed
from testbed.study.sensor_faults import paper
from testbed.study.sensor_faults.cases import BAR, OTHERS, WATCH
from testbed.study.study import Row

METHODS = ("mean", "Kalman filter", "weighted mean")
ONE_SIGMA = 0.1  # m/s^2 of the residuals that are drawn
RESIDUALS = {10: "bias 0.3", 11: "scale 0.5", 12: "aberrant", 13: "zero"}


def figures(rows: Sequence[Row]) -> dict[str, Figure]:
    """By file name."""
    drawn = {"delays": _delays(rows), "missed-over-size": _sizes(rows)}
    first = next((row for row in rows if "example" in row), None)
    if first is None:
        return drawn
    e = {name: np.array(values) for name, values in first["example"].items()}
    drawn |= {"figure-6": _sources(e), "figure-7": _global(e), "figure-8": _global_with_faults(e)}
    drawn["figure-9"] = _residuals(e, None, (0.1, 0.2))
    drawn |= {f"figure-{n}": _residuals(e, fault, (ONE_SIGMA,)) for n, fault in RESIDUALS.items()}
    drawn["figure-14"] = _sensitivity(e)
    if "roc" in first:
        drawn["figure-15"] = _roc(first["roc"])
    return drawn


def _sources(e: dict[str, NDArray[np.float64]]) -> Figure:
    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    for i, name in enumerate(paper.NAMES):
        top.plot(e["time"], e["said"][:, i], lw=0.6, label=name)
        bottom.plot(e["time"], np.degrees(e["yaw"][:, i]), lw=0.6, label=name)
    top.plot(e["time"], e["truth"], "k", lw=1.0, label="true")
    top.set(ylabel="acceleration [m/s²]", title="Figure 6: both quantities from three sources")
    bottom.set(xlabel="time [s]", ylabel="yaw rate [deg/s]")
    top.legend(fontsize="small", ncols=4)
    return figure


def _global(e: dict[str, NDArray[np.float64]]) -> Figure:
    figure = Figure(figsize=(7.0, 3.2), layout="constrained")
    axes = figure.subplots()
    for value, name in zip(paper.global_values(e["said"], e["truth"]), METHODS, strict=True):
        axes.plot(e["time"], value - e["truth"], lw=0.7, label=name)
    axes.set(xlabel="time [s]", ylabel="error [m/s²]", title="Figure 7: global values, no fault")
    axes.legend(fontsize="small")
    return figure


def _global_with_faults(e: dict[str, NDArray[np.float64]]) -> Figure:
    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    for axes, fault in zip(figure.subplots(1, 3, sharey=True), ("bias 0.5", "scale 0.5", "stuck"), strict=True):
        off, where = paper.broken(e["said"], fault, 0)
        axes.axvspan(e["time"][where.start], e["time"][where.stop], color="C1", alpha=0.15, lw=0.0)
        for value, name in zip(paper.global_values(off, e["truth"]), METHODS, strict=True):
            axes.plot(e["time"], value - e["truth"], lw=0.7, label=name)
        axes.set(xlabel="time [s]", title=f"Figure 8: {fault}")
    figure.axes[0].set_ylabel("error [m/s²]")
    figure.axes[0].legend(fontsize="small")
    return figure


def _residuals(e: dict[str, NDArray[np.float64]], fault: str | None, sigmas: Sequence[float]) -> Figure:
    """TNL of the three sources against the weighted mean; a fault sits on each in turn, as in the seed."""
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    for i, axes in enumerate(figure.subplots(3, 1, sharex=True)):
        off, where = paper.broken(e["said"], fault if fault and fault != "aberrant" else "bias 0", i)
        if fault == "aberrant":
            off[where.start : where.stop : 60, i] += 10.0 * max(float(np.abs(e["said"][:, i]).max()), 0.1)
        value = paper.weighted_mean(off)
        for sigma in sigmas:
            axes.plot(e["time"], transformed(off[:, i] - value, sigma), lw=0.6, label=f"σ = {sigma:g} m/s²")
        if fault:
            axes.axvline(e["time"][where.start], color="C1")
            axes.axvline(e["time"][where.stop], color="C2")
        axes.set(ylabel=paper.NAMES[i], ylim=(-1.1, 1.1))
    number = next((n for n, name in RESIDUALS.items() if name == fault), 9)
    figure.axes[0].set_title(f"Figure {number}: residual, {fault or 'no fault'}")
    figure.axes[-1].set_xlabel("time [s]")
    figure.axes[0].legend(fontsize="small", loc="upper right")
    return figure


def _sensitivity(e: dict[str, NDArray[np.float64]]) -> Figure:
    figure = Figure(figsize=(6.0, 3.6), layout="constrained")
    axes, biases = figure.subplots(), np.linspace(0.0, 1.0, 21)
    noise = e["said"][:, 0] - paper.weighted_mean(e["said"])
    for sigma in (0.05, 0.1, 0.2, 0.4, 0.8):
        means = [float((transformed(noise + bias, sigma) - transformed(noise, sigma)).mean()) for bias in biases]
        axes.plot(biases, means, label=f"σ = {sigma:g} m/s²")
    axes.set(xlabel="fault [m/s²]", ylabel="mean residual with less without", title="Figure 14: output sensitivity")
    axes.legend(fontsize="small")
    return figure


def _roc(curves: dict[str, Any]) -> Figure:
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    for axes, sigma in zip(figure.subplots(1, 3, sharey=True), paper.ROC_SIGMAS, strict=True):
        for bias in paper.ROC_BIASES:
            points = np.array(sorted(curves[f"{sigma:g}/{bias:g}"]))
            axes.plot(points[:, 0], points[:, 1], ".-", lw=0.8, label=f"{bias:g} m/s²")
        axes.set(xlabel="false alarms a sample [-]", title=f"Figure 15: σ = {sigma:g} m/s²")
    figure.axes[0].set_ylabel("detected [-]")
    figure.axes[0].legend(fontsize="small")
    return figure


def _found(rows: Sequence[Row], name: str) -> list[dict[str, Any]]:
    return [trial for row in rows for trial in row["trials"] if trial["case"] == name]


def _delays(rows: Sequence[Row]) -> Figure:
    figure = Figure(figsize=(6.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for case in BAR:
        found = _found(rows, case.name)
        told = np.sort([t["delay"] for t in found if t["right"]])
        axes.step(told, np.arange(1, len(told) + 1) / max(len(found), 1), where="post", label=case.name)
    axes.axvline(1.0, color="k", lw=0.8, ls="--")
    axes.axhline(0.95, color="k", lw=0.8, ls="--")
    axes.set(xlabel="time from the fault [s]", ylabel="told and named [-]", xlim=(0.0, WATCH), ylim=(0.0, 1.0))
    axes.legend(fontsize="small")
    return figure


def _sizes(rows: Sequence[Row]) -> Figure:
    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    units = {"accelerometer": "m/s²", "gyro": "deg/s", "wheel": "rad/s"}
    for axes, (sensor, unit) in zip(figure.subplots(1, 3, sharey=True), units.items(), strict=True):
        cases = sorted((c.size, c.name) for c in (*BAR, *OTHERS) if c.size and c.name.startswith(sensor))
        points = [(size, np.mean([t["delay"] is None for t in _found(rows, name)])) for size, name in cases
                  if _found(rows, name)]  # fmt: skip
        if points:
            axes.plot(*np.array(points).T, "o-")
        axes.set(xlabel=f"bias of the {sensor} [{unit}]", ylim=(-0.02, 1.02))
    figure.axes[0].set_ylabel("missed within 3 s [-]")
    return figure
