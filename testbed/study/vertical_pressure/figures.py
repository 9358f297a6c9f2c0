"""The paper's Figures 5 to 13, of the first repetition's drives (front left wheel) and of all Monte Carlo drives."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from testbed.roads.profile import read_profile
from testbed.roads.spectrum import periodogram
from testbed.study.vertical_pressure.errors import METHODS, error_and_std, of_kind
from testbed.study.vertical_pressure.published import METHODS as PUBLISHED
from testbed.study.vertical_pressure.tasks import MASSES
from testbed.study.vertical_pressure.told import CLASSES
from testbed.study.vertical_pressure.work import FINE, SCORED

COLOURS = {
    "single_ukf": "tab:gray", "imm_ukf_oracle": "tab:green", "imm_ukf_synthetic": "tab:red",
    "imm_ukf_state": "tab:orange", "bank": "tab:blue", "axles": "tab:purple",
}  # fmt: skip
SMOOTH = 1.0  # s of the modes' moving average
LOWEST_SHOWN, HIGHEST_SHOWN = 0.0, 400.0  # kPa


def figures(drives: Sequence[dict[str, Any]]) -> dict[str, Figure]:
    """By file name."""
    drawn: dict[str, Figure] = {}
    for drive in of_kind(drives, "fit"):
        drawn["figure-5-fit"] = _fit(drive)
    scored = [d for d in drives if d["task"]["kind"] != "fit"]
    if len(of_kind(scored, "classes")) > 1:
        drawn["figure-6-errors"] = _errors(of_kind(scored, "classes"))
    names = {"A": "figure-7-class-a", "D": "figure-8-class-d"}
    for drive in of_kind(scored, "show"):
        drawn[names[drive["task"]["scenario"]["road"]]] = _modes(drive, "modes")
    for kind, name, lower in (
        ("switch", "figure-9-a-to-d", "probability"), ("drop", "figure-10-drop", "error"),
        ("measured", "figure-13-measured-road", "probability"),
    ):  # fmt: skip
        for drive in _with_course(scored, kind)[:1]:
            drawn[name] = _modes(drive, lower)
            if kind == "measured":
                drawn["figure-12-measured-road-psd"] = _road(drive)
    if _with_course(scored, "mass"):
        drawn["figure-11-mass"] = _masses(_with_course(scored, "mass"))
    return drawn


def _with_course(drives: Sequence[dict[str, Any]], kind: str) -> list[dict[str, Any]]:
    return [drive for drive in of_kind(drives, kind) if "course" in drive]


def _fit(drive: dict[str, Any]) -> Figure:
    found = {name: entry for name, entry in drive.items() if name != "task"}
    figure = Figure(figsize=(9.0, 3.2 * len(found)), layout="constrained")
    for axes, (pressure, entry) in zip(np.atleast_1d(figure.subplots(len(found), 1)), found.items(), strict=True):
        for name, colour in (("car", "black"), ("identified", "tab:blue"), ("table_3", "tab:red")):
            axes.plot(entry["time_s"], entry[name], color=colour, lw=1.0, label=name.replace("_", " "))
        axes.set(ylabel="hub acceleration [m/s^2]", title=f"{pressure} kPa, class B, 60 km/h, front left")
        axes.legend(loc="upper right")
    axes.set_xlabel("time [s]")
    return figure


def _errors(drives: Sequence[dict[str, Any]]) -> Figure:
    """Mean error and its spread against the reported std, and one drive's error."""
    names = [m for m in METHODS if len(error_and_std(drives, m, SCORED[0])[0]) or len(error_and_std(drives, m, 2.0)[0])]
    figure = Figure(figsize=(11.0, 3.0 * ((len(names) + 1) // 2)), layout="constrained")
    grid = np.atleast_1d(figure.subplots((len(names) + 1) // 2, 2, sharex=True)).flat
    for axes, method in zip(grid, names, strict=False):
        time, mean, spread, said, one = [], [], [], [], []
        for seconds in SCORED:
            error, std = error_and_std(drives, method, seconds)
            if len(error) > 1:
                time.append(seconds)
                mean.append(error.mean())
                spread.append(error.std(ddof=1))
                said.append(std.mean())
                one.append(error[0, 0])
        if not time:
            continue
        axes.plot(time, mean, color="tab:red", label="mean error")
        for sign in (-1.0, 1.0):
            axes.plot(
                time, sign * np.array(spread), "--", color="tab:blue", label="std of errors" if sign > 0 else None
            )
            axes.plot(time, sign * np.array(said), "--", color="black", label="reported std" if sign > 0 else None)
        axes.plot(time, one, color="tab:green", lw=1.0, label="one drive")
        reach = float(min(max(np.max(spread), np.max(said), np.abs(mean).max()) * 1.2, HIGHEST_SHOWN))
        axes.set(title=method, ylabel="error [kPa]", ylim=(-reach, reach))
        axes.set_xscale("log")
    figure.axes[0].legend(fontsize="small")
    figure.supxlabel("time [s]")
    return figure


def _array(values: Any) -> NDArray[np.float64]:
    return np.array(values, float)


def _smoothed(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Trailing moving average over SMOOTH, columns apart."""
    wide = round(SMOOTH / FINE)
    total = np.cumsum(np.vstack([np.zeros((1, values.shape[1])), values]), axis=0)
    first = np.maximum(np.arange(1, len(values) + 1) - wide, 0)
    last = np.arange(1, len(values) + 1)
    return (total[last] - total[first]) / (last - first)[:, None]


def _pressure(axes: Axes, course: dict[str, Any]) -> None:
    time = _array(course["time_s"])
    axes.plot(time, _array(course["truth"]), color="black", lw=1.5, label="truth")
    for method, entry in course["methods"].items():
        value, std = _array(entry["kpa"]), _array(entry["std"])
        axes.plot(time, value, color=COLOURS[method], lw=1.0, label=method)
        if method in ("bank", "axles"):
            axes.fill_between(time, value - std, value + std, color=COLOURS[method], alpha=0.15, lw=0.0)
    axes.set(ylabel="pressure [kPa]", ylim=(LOWEST_SHOWN, HIGHEST_SHOWN))
    axes.legend(fontsize="x-small", ncols=2)


def _modes(drive: dict[str, Any], lower: str) -> Figure:
    """Pressure above; below for each four-mode filter the modes' pressures or probabilities, or the errors."""
    course = drive["course"]
    time = _array(course["time_s"])
    methods = [m for m in PUBLISHED if m.startswith("imm")]
    figure = Figure(figsize=(9.0, 9.0 if lower != "error" else 6.0), layout="constrained")
    rows = figure.subplots(2 if lower == "error" else 1 + len(methods), 1, sharex=True)
    _pressure(rows[0], course)
    rows[0].set_title(f"{Path(drive['task']['scenario']['road']).name}, 60 km/h, front left")
    if lower == "error":
        for method, entry in course["methods"].items():
            rows[1].plot(time, _array(entry["kpa"]) - _array(course["truth"]), color=COLOURS[method], lw=1.0)
        rows[1].set(ylabel="error [kPa]", ylim=(-150.0, 150.0))
    else:
        for axes, method in zip(rows[1:], methods, strict=True):
            values = _smoothed(_array(course["methods"][method][lower]))
            for j, name in enumerate(CLASSES):
                axes.plot(time, values[:, j], label=f"mode {j + 1} ({name})", lw=1.0)
            if lower == "modes":
                axes.plot(time, _array(course["truth"]), color="black", lw=1.5)
                axes.set_ylim(LOWEST_SHOWN, HIGHEST_SHOWN)
            axes.set_ylabel(f"{method}\n{'kPa' if lower == 'modes' else 'probability'}")
        rows[1].legend(fontsize="x-small", ncols=4)
    rows[-1].set_xlabel(f"time [s]; modes: moving average over {SMOOTH:g} s")
    return figure


def _masses(drives: Sequence[dict[str, Any]]) -> Figure:
    methods = [m for m in METHODS if m in drives[0]["course"]["methods"]]
    figure = Figure(figsize=(9.0, 2.0 * len(methods)), layout="constrained")
    for axes, method in zip(np.atleast_1d(figure.subplots(len(methods), 1, sharex=True)), methods, strict=True):
        for drive, colour in zip(drives, ("black", "tab:blue", "tab:red"), strict=False):
            course = drive["course"]
            error = _array(course["methods"][method]["kpa"]) - _array(course["truth"])
            percent = drive["task"]["percent"]
            axes.plot(course["time_s"], error, color=colour, lw=1.0, label=f"+{percent} % ({MASSES[percent]:g} kg)")
        axes.set_ylabel(f"{method}\nerror [kPa]")
        axes.set_ylim(-100.0, 100.0)
    figure.axes[0].legend(fontsize="x-small", ncols=3)
    figure.supxlabel("time [s]")
    return figure


def _road(drive: dict[str, Any]) -> Figure:
    x, z = read_profile(drive["task"]["scenario"]["road"])
    n, power = periodogram(z, float(np.median(np.diff(x))))
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    omega = 2.0 * np.pi * n
    left.loglog(omega, power / (2.0 * np.pi), lw=0.8, label="measured")
    for a, name in enumerate(CLASSES):
        left.loglog(omega, 1e-6 * 4.0**a / omega**2, "--", lw=0.8, label=f"class {name}")
    left.set(xlabel="angular spatial frequency [rad/m]", ylabel="PSD [m^3/rad]")
    left.legend(fontsize="x-small")
    right.plot(x, 1e3 * z, lw=0.8)
    right.set(xlabel="x [m]", ylabel="height [mm]")
    return figure
