"""Figures 4.1 to 4.6 and 4.22 to 4.26: the thesis' formulas, and what is exact."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from estimators.detectors import siegmund_threshold, thesis_theta, variance_drift
from estimators.detectors.cusum import variance_run_length
from estimators.detectors.threshold import threshold_for
from testbed.study.detector_design.thesis import MEAN_CURVES, THETAS, VARIANCE_CHANGES
from testbed.study.detector_design.thresholds import FIGURE_DRIFT, exact_delay, exact_threshold, siegmund_delay

Points = Iterable[float]
THESIS: dict[str, Any] = {"color": "C3", "ls": "--"}
EXACT: dict[str, Any] = {"color": "C0", "ls": "-"}
VARIANCE_ARL = 2e4  # samples, of Figure 4.26
VARIANCE_THRESHOLD = 10.0  # of Figure 4.24
ROUGH = 1e-3  # of run lengths of a variance: enough for a picture


def curves() -> dict[str, Figure]:
    """By file name."""
    return {
        "figures-4.1-4.3-delay": _delays(), "figures-4.4-4.6-threshold": _mean_thresholds(),
        "figures-4.22-4.26-variance": _variance(),
    }  # fmt: skip


def _both(axes: Axes, x: Points, thesis: Callable[[float], float], exact: Callable[[float], float], name: str) -> None:
    places = list(x)
    axes.plot(places, [thesis(p) for p in places], **THESIS, label="thesis' formula")
    axes.plot(places, [exact(p) for p in places], **EXACT, label="exact")
    axes.set_xlabel(name)


def _delays() -> Figure:
    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    for line, (number, std, asked) in zip(figure.subplots(3, 3), MEAN_CURVES, strict=True):
        for axes, theta in zip(line, THETAS, strict=True):
            _both(
                axes, np.linspace(0.2, 0.8, 25) * theta, lambda nu: siegmund_delay(nu, theta, std, asked),  # noqa: B023
                lambda nu: exact_delay(nu, theta, std, asked), "drift nu",  # noqa: B023
            )  # fmt: skip
            axes.axvline(0.5 * theta, color="0.5", lw=0.8)
            axes.set(title=f"{number}: sigma {std:g}, theta {theta:g}, 1/FAR {asked:g}", ylabel="MTD [samples]")
            axes.set_ylim(bottom=0.0)
    figure.axes[0].legend(fontsize="small")
    return figure


def _mean_thresholds() -> Figure:
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    (first, second, sixth), fifth = figure.subplots(2, 3)
    for axes, asked in ((first, 200.0), (second, 2e6)):
        _both(
            axes, np.linspace(0.4, 6.0, 29), lambda std: siegmund_threshold(FIGURE_DRIFT, asked, std),  # noqa: B023
            lambda std: exact_threshold(FIGURE_DRIFT, asked, std), "sigma",  # noqa: B023
        )  # fmt: skip
        axes.set_title(f"4.4: nu 5, 1/FAR {asked:g}")
    _both(
        sixth, np.linspace(1.0, 10.0, 28), lambda nu: siegmund_threshold(nu, 200.0, 5.0),
        lambda nu: exact_threshold(nu, 200.0, 5.0), "nu",
    )  # fmt: skip
    sixth.set_title("4.6: 1/FAR 200 (sigma taken as 5)")
    for axes, std in zip(fifth, (5.0, 3.0, 1.0), strict=True):
        _both(
            axes, np.geomspace(3.0, 1e7, 30), lambda asked: siegmund_threshold(FIGURE_DRIFT, asked, std),  # noqa: B023
            lambda asked: exact_threshold(FIGURE_DRIFT, asked, std), "1/FAR [samples]",  # noqa: B023
        )  # fmt: skip
        axes.set(title=f"4.5: nu 5, sigma {std:g}", xscale="log")
    for axes in figure.axes:
        axes.axhline(0.0, color="0.5", lw=0.8)
        axes.set_ylabel("threshold h")
    figure.axes[0].legend(fontsize="small")
    return figure


def _variance() -> Figure:
    figure = Figure(figsize=(13.0, 6.0), layout="constrained")
    (change, start, needed, every), (arl, drift, delay, rest) = figure.subplots(2, 4)
    rest.set_axis_off()
    after, before = np.linspace(1.2, 10.0, 30), np.linspace(0.5, 4.5, 30)
    _both(change, after, lambda s1: thesis_theta(1.0, s1), lambda s1: variance_drift(1.0, s1), "variance after")
    change.set(title="4.22: variance before 1", ylabel="theta")
    # the thesis divides sigma*^4 by the mean square, whichever that is: with S0, S1 held at 1, 3
    _both(
        start, before, lambda square: thesis_theta(1.0, 3.0) / square, lambda square: variance_drift(1.0, 3.0) / square,
        "mean square E(y^2)",
    )  # fmt: skip
    start.set(title="4.23: change from 1 to 3", ylabel="theta")
    place = np.arange(len(VARIANCE_CHANGES))
    every.plot(place, [c.theta for c in VARIANCE_CHANGES], "C3s", label="printed")
    every.plot(place, [variance_drift(c.before, c.after) for c in VARIANCE_CHANGES], "C0o", label="right")
    every.plot(place, [c.after / c.before for c in VARIANCE_CHANGES], "k_", ms=14.0, label="mean of n^2 after")
    every.set_xticks(place, [f"{c.before:g} to {c.after:g}" for c in VARIANCE_CHANGES], fontsize=7.0)
    every.set(title="theta of 4.27 to 4.32", yscale="log")
    every.legend(fontsize="small")
    thetas = np.geomspace(1.2, 16.0, 24)  # the curves bend at the small ones
    lengths = [variance_run_length(VARIANCE_THRESHOLD, float(t), "increase", agree=ROUGH) for t in thetas]
    needed.plot(lengths, thetas, **EXACT)
    needed.set(title=f"4.24: h {VARIANCE_THRESHOLD:g}", xscale="log", xlabel="ARL0 [samples]", ylabel="theta")
    lengths = np.geomspace(10.0, 1e5, 9).tolist()
    for theta, name in ((thesis_theta(1.0, 3.0), "thesis"), (variance_drift(1.0, 3.0), "exact")):
        style = THESIS if name == "thesis" else EXACT
        arl.plot(lengths, [_threshold(theta, float(a)) for a in lengths], **style)
    arl.set(title="4.25: 1 to 3, theta as each has it", xscale="log", xlabel="ARL0 [samples]", ylabel="threshold h")
    drift.plot(thetas, [_threshold(float(t), VARIANCE_ARL) for t in thetas], **EXACT)
    drift.set(title=f"4.26: ARL0 {VARIANCE_ARL:g}", xlabel="theta", ylabel="threshold h")
    drift.axvline(variance_drift(1.0, 3.0), color="0.5", lw=0.8, label="right theta, 1 to 3")
    drift.legend(fontsize="small")
    near = np.linspace(1.25, 2.75, 11)
    delay.plot(near, [_delay(float(t)) for t in near], **EXACT)
    for theta, colour in ((variance_drift(1.0, 3.0), "C0"), (thesis_theta(1.0, 3.0), "C3")):
        delay.axvline(theta, color=colour, lw=0.8)
    delay.set(title=f"1 to 3, ARL0 {VARIANCE_ARL:g}", xlabel="theta (lines: right, thesis)", ylabel="delay [samples]")
    figure.axes[0].legend(fontsize="small")
    return figure


@cache
def _threshold(theta: float, arl0: float) -> float:
    return threshold_for(arl0, lambda h: variance_run_length(h, theta, "increase", agree=ROUGH))


def _delay(theta: float) -> float:
    h = _threshold(theta, VARIANCE_ARL)
    return variance_run_length(h, theta, "increase", 0.0, 3.0**0.5, ROUGH)
