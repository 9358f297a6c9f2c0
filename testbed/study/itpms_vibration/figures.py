"""The paper's Figures 2, 3 and 4, and bias by noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from testbed.study.itpms_vibration.drives import RATIOS, SHARES
from testbed.study.itpms_vibration.linearised import mode_at
from testbed.study.itpms_vibration.listening import METHODS
from testbed.study.itpms_vibration.rows_of_bias import biases
from testbed.study.itpms_vibration.rows_of_pressure import indications
from testbed.study.study import Row

COLOURS = dict(zip(RATIOS, ("C0", "C1", "C3"), strict=True))


def figures(rows: Sequence[Row]) -> dict[str, Figure]:
    """By file name."""
    examples = [row for row in rows if row["task"]["kind"] == "pressure" and "f" in row]
    drawn = {"figure-4-runs": _runs(rows), "bias-by-noise": _bias(rows)}
    return (
        drawn | {"figure-2-spectra": _spectra(examples), "figure-3-courses": _courses(examples)} if examples else drawn
    )


def _of(examples: Sequence[Row], mode: str) -> list[Row]:
    return [row for row in examples if row["task"]["mode"] == mode]


def _modes(examples: Sequence[Row]) -> list[str]:
    return [mode for mode in ("antiphase", "in_phase") if _of(examples, mode)]


def _spectra(examples: Sequence[Row]) -> Figure:
    modes = _modes(examples)
    figure = Figure(figsize=(5.5 * len(modes), 4.2), layout="constrained")
    for axes, mode in zip(np.atleast_1d(figure.subplots(1, len(modes))), modes, strict=True):
        for row in _of(examples, mode):
            ratio, speed = row["task"]["ratio"], row["task"]["speed"]
            f, power = np.array(row["f"]), np.array(row["power"])
            seen = f > 8.0
            axes.semilogy(f[seen], power[seen], color=COLOURS[ratio], lw=1.0, label=f"{100 * ratio:g} %")
            for kind in ("in_phase", "antiphase"):
                axes.axvline(mode_at(speed, ratio)["front"][kind][0], color=COLOURS[ratio], lw=0.7, ls=":")
        task = _of(examples, mode)[0]["task"]
        axes.set(
            xlabel="frequency [Hz]", ylabel="wheel speed PSD [(rad/s)^2/Hz]",
            title=f"front left, class {task['road']}, {task['speed']:g} km/h, 30 s",
        )  # fmt: skip
        axes.legend(title="pressure")
    figure.suptitle("Smoothed FFT; dotted: both rotational modes of the linearised car")
    return figure


def _courses(examples: Sequence[Row]) -> Figure:
    modes = _modes(examples)
    figure = Figure(figsize=(5.5 * len(modes), 4.2), layout="constrained")
    for axes, mode in zip(np.atleast_1d(figure.subplots(1, len(modes))), modes, strict=True):
        for row in _of(examples, mode):
            ratio = row["task"]["ratio"]
            time, f, std = np.array(row["course"]["vibration"], float).T
            heard = std < 0.06 * f
            time, f, std = time[heard], f[heard], std[heard]
            axes.plot(time, f, color=COLOURS[ratio], label=f"Whittle, {100 * ratio:g} %")
            axes.fill_between(time, f - std, f + std, color=COLOURS[ratio], alpha=0.2, lw=0.0)
            time, f = np.array(row["course"]["ar2_rls"], float).T
            axes.plot(time, f, color=COLOURS[ratio], ls="--", lw=1.0, label=f"AR(2) RLS, {100 * ratio:g} %")
            axes.axhline(mode_at(row["task"]["speed"], ratio)["front"][mode][0], color=COLOURS[ratio], lw=0.7, ls=":")
        axes.set(xlabel="time [s]", ylabel="frequency [Hz]", title=f"{mode.replace('_', ' ')} mode, front left")
        axes.legend(fontsize="small", ncols=2)
    figure.suptitle("Recursive estimates, band: one std; dotted: linearised car")
    return figure


def _runs(rows: Sequence[Row]) -> Figure:
    figure = Figure(figsize=(8.0, 4.2), layout="constrained")
    axes, start = figure.subplots(), 1
    for ratio, (value, std) in indications(rows).items():
        number = start + np.arange(len(value))
        for w in range(value.shape[1]):
            axes.errorbar(
                number + 0.15 * (w - 1.5), np.exp(value[:, w]), std[:, w], fmt=".", ms=5, color=COLOURS[ratio],
                label=f"{100 * ratio:g} %" if w == 0 else None,
            )  # fmt: skip
        start += len(value)
    axes.set(
        xlabel="run; in each its four wheels", ylabel="antiphase frequency / its mean at 100 %",
        title="Average over a run of 64 s: other road, manoeuvre and speed in each of ten",
    )  # fmt: skip
    axes.legend(title="pressure")
    return figure


def _bias(rows: Sequence[Row]) -> Figure:
    figure = Figure(figsize=(9.5, 4.2), layout="constrained")
    axes = figure.subplots()
    for i, method in enumerate(METHODS):
        found = biases(rows, "antiphase", method)
        for kind, line in (("known", "-"), ("pressure", "--")):
            shares = [s for s in SHARES if f"{kind}_{100.0 * s:g}" in found]
            level = [found[f"{kind}_{100.0 * s:g}"].value for s in shares]
            what = "known process" if kind == "known" else "car, against itself"
            axes.plot(100.0 * np.array(shares), level, f"C{i}", ls=line, marker="o", label=f"{method}, {what}")
    axes.set_yscale("symlog", linthresh=0.1)
    axes.axhspan(-0.1, 0.1, color="0.9")
    axes.set(xlabel="added white noise [% of the signal's r.m.s.]", ylabel="bias [Hz]", title="Antiphase mode")
    figure.legend(loc="outside right upper", fontsize="small")
    return figure
