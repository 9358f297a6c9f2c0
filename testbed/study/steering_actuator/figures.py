"""Figures of `steering-actuator`: the tables of 4.2.2, sizes found, residuals against Gaussians, two drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from estimators.steering_actuator.errors import THESIS
from estimators.steering_actuator.residuals import STEP
from testbed.study.detector_design.thesis import CONFORMED
from testbed.study.steering_actuator.gaussian import EDGES
from testbed.study.steering_actuator.paper import Printed, tables
from testbed.study.steering_actuator.scenarios import SET_A
from testbed.study.steering_actuator.steering_actuator import BAR, smallest, times
from testbed.study.steering_actuator.trials import NAMES, SIZES


def figures(rows: Sequence[Mapping[str, Any]]) -> dict[str, Figure]:
    """By file name."""
    cases = [case for row in rows for case in row["cases"] if not case["ended"]]
    found = {}
    if any(case["set_a"] for case in cases):
        for kind in ("constant", "other"):
            errors = [e.name for e in THESIS if (e.kind in ("none", "constant")) == (kind == "constant")]
            found[f"tables-4-2-2-{kind}"] = _tables(cases, errors)
    pooled = [row["gaussian"] for row in rows if row["gaussian"]]
    if pooled:
        found["figures-4-13-to-4-17"] = _residuals(pooled)
    if all(not np.isnan(smallest(row, name, "on_b")) for row in rows for name in NAMES):
        found["smallest-constant"] = _sizes(rows)
    example = next((row["example"] for row in rows if row["example"]), None)
    return found | ({"drives": _drives(example)} if example else {})


def _entry(told: Sequence[float | None], printed: Printed | None) -> str:
    """Median and share found, then the thesis' own."""
    seen = [t for t in told if t is not None]
    here = "x" if 2 * len(seen) <= len(told) else f"{np.median(seen):.1f}"
    if printed is None:
        return here
    return f"{here} | {'x' if printed.time is None else f'{printed.time:g}'}{'*' if printed.star else ''}"


def _tables(cases: Sequence[Mapping[str, Any]], errors: Sequence[str]) -> Figure:
    """Seconds to the alarm: median of the repetitions here | thesis."""
    figure = Figure(figsize=(17, 3.1 * len(errors)), layout="constrained")
    names = [case.name for case in SET_A]
    for axes, error in zip(figure.subplots(len(errors), 1, squeeze=False).flat, errors, strict=True):
        shade = np.full((len(NAMES), len(names)), np.nan)
        for i, method in enumerate(NAMES):
            printed = tables()[error].get(method)
            for j, name in enumerate(names):
                told = times(cases, error, method, name)
                if not told:
                    continue
                seen = [t for t in told if t is not None]
                shade[i, j] = float(np.median(seen)) if 2 * len(seen) > len(told) else np.nan
                text = _entry(told, printed[j] if printed else None)
                axes.text(j, i, text, ha="center", va="center", fontsize=8)
        axes.imshow(shade, cmap="YlGn_r", vmin=-8.0, vmax=12.0, aspect="auto", alpha=0.7)
        axes.set_xticks(range(len(names)), [f"Sc{k + 1}\n{name}" for k, name in enumerate(names)], fontsize=7)
        axes.set_yticks(range(len(NAMES)), NAMES, fontsize=8)
        axes.set_title(f"{error.replace('_', ' ')}: seconds to the alarm, here | thesis; x: none", fontsize=9)
    return figure


def _sizes(rows: Sequence[Mapping[str, Any]]) -> Figure:
    figure = Figure(figsize=(8, 4.5), layout="constrained")
    axes = figure.subplots()
    for kind, marker, label in (
        ("on_b", "o", "no false alarm on set B of the tuning drives"), ("late", "^", "the same, error from 5 s on"),
        ("tuned", "x", "after the thesis' sets"),
    ):  # fmt: skip
        worst = [max(smallest(row, name, kind) for row in rows) for name in NAMES]
        axes.plot([size if np.isfinite(size) else 2.0 * SIZES[-1] for size in worst], range(len(NAMES)), marker,
                  fillstyle="none", label=label)  # fmt: skip
    axes.axvline(BAR, color="grey", linestyle=":", label=f"asked of the model: {BAR:g} deg")
    axes.axvspan(1.5 * SIZES[-1], 3.0 * SIZES[-1], color="0.9")
    axes.text(2.0 * SIZES[-1], len(NAMES) - 0.4, "none", ha="center", fontsize=8)
    axes.set(xscale="log", xlabel="smallest constant error found in all ten scenarios [deg of motor]")
    axes.set_yticks(range(len(NAMES)), NAMES)
    axes.legend(fontsize="small")
    return figure


def _residuals(pooled: Sequence[Mapping[str, Any]]) -> Figure:
    """Distribution of the position residual, cut, with Gaussians of its and of the thesis' sigma."""
    counts = np.sum([one["histogram"] for one in pooled], axis=0)
    centre = 0.5 * (EDGES[:-1] + EDGES[1:])
    figure = Figure(figsize=(14, 7), layout="constrained")
    axes = figure.subplots(2, 3).flat
    density = counts / counts.sum()
    axes[0].semilogy(centre, np.maximum(density, 1e-7))
    axes[0].set(title="Figure 4.13: all", xlabel="position residual [deg]", ylabel="density [1/deg]", ylim=(1e-6, 1.0))
    for place, case in zip(axes[1:], CONFORMED, strict=False):
        kept = (np.abs(centre) <= case.cut) & (case.zeros | (np.abs(centre) > 0.5))
        own = np.where(kept, counts, 0) / max(counts[kept].sum(), 1)
        place.plot(centre, own, linewidth=0.8, label="here")
        sigma = float(np.mean([one[case.figure]["sigma"] for one in pooled]))
        for s, style, label in ((sigma, "-", f"Gaussian, {sigma:.1f}"), (case.sigma, "--", f"thesis, {case.sigma:g}")):
            place.plot(centre, np.exp(-0.5 * (centre / s) ** 2) / (s * np.sqrt(2.0 * np.pi)), style, label=label)
        place.set(xlim=(-1.1 * case.cut, 1.1 * case.cut), xlabel="position residual [deg]")
        place.set_title(f"Figure {case.figure}: up to {case.cut:g}{'' if case.zeros else ', not 0'}")
        place.legend(fontsize="small")
    axes[5].set_axis_off()
    return figure


def _drives(example: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Demand and motor; the thesis' residual; the servo model's error and what it may be (three times)."""
    figure = Figure(figsize=(12, 7), layout="constrained")
    grid = figure.subplots(3, len(example), squeeze=False, sharex="col")
    for column, (name, series) in enumerate(example.items()):
        demand, angle, error, spread = (np.array(series[key]) for key in ("demand", "angle", "error", "spread"))
        time = STEP * (np.arange(len(demand)) + 0.5)
        top, middle, bottom = grid[:, column]
        top.plot(time, demand, label="demanded")
        top.plot(time, angle, label="motor")
        top.set(title=name, ylabel="motor [deg]")
        top.legend(fontsize="small")
        middle.plot(time, angle - demand)
        middle.set(ylabel="position residual [deg]")
        bottom.fill_between(time, -3.0 * spread, 3.0 * spread, color="0.85", label="three times the spread")
        bottom.plot(time, error, label="motor less servo model")
        bottom.set(ylabel="[deg]", xlabel="time [s]")
        bottom.legend(fontsize="small")
    return figure
