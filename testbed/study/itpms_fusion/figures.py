"""Figures of `itpms-fusion`: detection times, tails, the published Figures 8 and 9."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from estimators.itpms.thresholds import FALSE_ALARMS_PER_HOUR, SPAN, TUNED
from estimators.scores.survival import event_curve
from testbed.study.itpms_fusion.drives import name_of
from testbed.study.itpms_fusion.itpms_fusion import driven, first_alarm, times
from testbed.study.itpms_fusion.repetition import METHODS

COLOURS = {"fused": "black", "vibration": "tab:blue", "radius": "tab:orange", "voting": "tab:green"}


def figures(rows: Sequence[dict[str, Any]]) -> dict[str, Figure]:
    """By file name."""
    return {
        "detection-times": _detection_times(rows),
        "false-alarm-tail": _tails(rows),
        "figure-8-voting": _figure_8(rows),
        "figure-9-warnings": _figure_9(rows),
    }


def _detection_times(rows: Sequence[dict[str, Any]]) -> Figure:
    figure = Figure(figsize=(10, 6), layout="constrained")
    for tyres, axes in enumerate(figure.subplots(2, 2, sharex=True, sharey=True).flat, 1):
        drives = driven(rows, [name_of(0.15, tyres, kind) for kind in ("sudden", "leak")])
        for method in METHODS:
            events = times(drives, method) if drives else None
            if events is None or (method == "radius" and tyres == 4):
                continue
            curve = event_curve(events)
            share = [0.0, *curve.share.value]
            axes.step([0.0, *curve.time, curve.end], [*share, share[-1]], "-", where="post", color=COLOURS[method])
            axes.lines[-1].set_label(method)
        axes.axvline(60.0, color="grey", linestyle=":", label="paper")
        axes.set(title=f"15 % lost in {tyres} tyre{'s' if tyres > 1 else ''}", xlim=(0.0, 180.0), ylim=(0.0, 1.02))
        axes.set(xlabel="time since the loss [s]", ylabel="share of drives with an alarm")
        axes.legend(loc="lower right")
    return figure


def _tails(rows: Sequence[dict[str, Any]]) -> Figure:
    """Rate at which the largest statistic of a span passes a threshold, on sound driving."""
    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    for method in METHODS[:3]:
        largest = [d["largest"][method] for row in rows for d in row.values()]
        every = np.sort(np.concatenate([np.empty(0), *(np.asarray(x, float) for x in largest)]))
        if not len(every):
            continue
        rate = (len(every) - np.arange(len(every))) / (len(every) * SPAN / 3600.0)
        axes.semilogy(every, rate, color=COLOURS[method], label=method)
        axes.plot([TUNED.alone[method]], [FALSE_ALARMS_PER_HOUR], "o", color=COLOURS[method])
    axes.set(xlabel="threshold of the statistic [nats]", ylabel=f"spans of {SPAN:g} s above it, per sound hour")
    axes.legend(title="dot: design")
    return figure


def _example(rows: Sequence[dict[str, Any]]) -> Mapping[str, Any] | None:
    """A drive with a loss of a quarter, of 30 % in the paper."""
    drives = [d for name in ("25x1_sudden", "15x1_sudden") for d in driven(rows, [name]) if d["statistics"]]
    return drives[0] if drives else None


def _figure_8(rows: Sequence[dict[str, Any]]) -> Figure:
    """The voting scheme at work: both confidences and their thresholds."""
    figure = Figure(figsize=(8, 4), layout="constrained")
    axes, drive = figure.subplots(), _example(rows)
    if drive is None:
        return figure
    series, h = drive["statistics"], TUNED.voting
    for name, threshold, colour in (("vibration", h.vibration, "tab:blue"), ("radius", h.radius, "tab:orange")):
        axes.plot(series["time_s"], series[f"{name}_confidence"], color=colour, label=f"confidence of {name}")
        axes.axhline(threshold, color=colour, linestyle="--", label=f"its threshold alone, {threshold:.1f}")
    axes.axhline(h.agreed, color="grey", linestyle=":", label=f"$h_0$ of their mean where flags agree, {h.agreed:.1f}")
    axes.axvline(drive["onset_s"], color="black", linewidth=0.8)
    axes.set(xlabel="time [s]", ylabel="confidence [nats]", title=f"loss in {' '.join(drive['wheels'])}")
    axes.legend()
    return figure


def _figure_9(rows: Sequence[dict[str, Any]]) -> Figure:
    """Warning signals, 0 or 1."""
    figure = Figure(figsize=(8, 5), layout="constrained")
    drive = _example(rows)
    for method, axes in zip(METHODS, figure.subplots(len(METHODS), 1, sharex=True), strict=True):
        if drive is not None:
            alarm = first_alarm(drive, method)
            at = alarm[0] if alarm else drive["end_s"]
            axes.step([0.0, at, drive["end_s"]], [0.0, float(alarm is not None), float(alarm is not None)],
                      where="post", color=COLOURS[method])  # fmt: skip
            axes.axvline(drive["onset_s"], color="grey", linestyle=":")
        axes.set(ylim=(-0.1, 1.1), ylabel=method)
    figure.supxlabel("time [s]")
    return figure
