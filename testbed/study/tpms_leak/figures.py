"""The paper's Figures 2 to 7 from its own simulation, and the monitor's delays and statistics."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from estimators.direct_pressure.published import PUBLISHED, stationary_std
from testbed.study.study import Row
from testbed.study.tpms_leak.paper import ONSET, clock
from testbed.study.tpms_leak.tpms_leak import trials
from testbed.study.tpms_leak.work import LEAKS, SENSORS

LEAK_NAMES = {"0p1_psi_s": "0.1 psi/s", "0p2_psi_s": "0.2 psi/s", "1_psi_s": "1 psi/s", "10_kpa_h": "10 kPa/h"}
SENSOR_NAMES = {"": "20 Hz, 0.5 psi", "_1_s": "1 Hz", "_30_s": "30 s, 2.5 kPa", "_60_s": "60 s, 2.5 kPa"}


def figures(rows: Sequence[Row]) -> dict[str, Figure]:
    """By file name."""
    drawn = {f"figure-{i + 2}": _paper(rows[0]["example"], i) for i in range(6)} if "example" in rows[0] else {}
    return drawn | {"delays": _delays(rows), "false-alarms": _statistics(rows)}


def _paper(example: dict[str, Any], number: int) -> Figure:
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axes, time = figure.subplots(), clock()
    e = {name: np.array(values) for name, values in example.items()}
    axes.axvspan(ONSET, time[-1], color="C3", alpha=0.08, lw=0.0)
    axes.axvline(ONSET, color="C3", ls="--", lw=0.8)
    axes.set_xlabel("time [s]")
    _PANELS[number](axes, time, e)
    axes.legend(fontsize="small", loc="best")
    return figure


def _pressure(axes: Axes, time: np.ndarray, e: dict[str, np.ndarray]) -> None:
    axes.plot(time, e["measured"], "C3.", ms=1.5, label="measured")
    axes.plot(time, e["truth"], "k", lw=1.6, label="true")
    axes.plot(time, e["estimate"], "C0", lw=0.8, label="Kalman filter")
    axes.set(ylabel="pressure [psi]", title="Figure 2: the leak begins at 20 s")


def _std(axes: Axes, time: np.ndarray, e: dict[str, np.ndarray]) -> None:
    axes.plot(time, e["std"], label="filter's std")
    axes.axhline(stationary_std()[0], color="k", lw=0.8, ls=":", label=f"stationary, {stationary_std()[0]:.4f}")
    axes.axhline(0.15, color="C1", lw=0.8, ls="--", label="as the paper says")
    axes.set(ylabel="std [psi]", ylim=(0.0, 0.5), title="Figure 3: it cannot reach 0.15 psi, nor see the leak")


def _innovation(axes: Axes, time: np.ndarray, e: dict[str, np.ndarray]) -> None:
    axes.plot(time, e["innovation"], "m", lw=0.6, label="innovation")
    for sign in (-1.0, 1.0):
        axes.axhline(sign * 3.0 * PUBLISHED.measurement**0.5, color="C3", ls="--", lw=0.8)
    axes.set(ylabel="innovation [psi]", title="Figure 4: with the paper's 3 sqrt(R)")


def _cusum(axes: Axes, time: np.ndarray, e: dict[str, np.ndarray]) -> None:
    axes.plot(time, e["up"], "C0", lw=0.7, label="upward")
    axes.plot(time, e["down"], "C3", lw=0.7, label="downward")
    axes.axhline(PUBLISHED.threshold, color="k", ls="--", lw=0.8, label="threshold")
    axes.set(ylabel="CUSUM [-]", title="Figure 5: alarms all along")


def _alarm(axes: Axes, time: np.ndarray, e: dict[str, np.ndarray]) -> None:
    when = time[e["alarm"] > 0.0]
    before, after = int((when <= ONSET).sum()), int((when > ONSET).sum())
    axes.vlines(when, 0.0, 1.0, lw=0.8, label=f"alarms: {before} before the leak, {after} after")
    axes.set(ylabel="alarm [-]", ylim=(0.0, 1.3), title="Figure 6: the paper shows the first one after 20 s only")


def _slope(axes: Axes, time: np.ndarray, e: dict[str, np.ndarray]) -> None:
    axes.plot(time, e["slope"], "C4", lw=0.7, label="slope of 50 innovations")
    axes.plot(time, -e["rate"], "k--", label="true dp/dt of the leak")
    axes.set(ylabel="[psi/s]", title="Figure 7: the slope of the innovation is not the leak rate")


_PANELS = (_pressure, _std, _innovation, _cusum, _alarm, _slope)


def _delays(rows: Sequence[Row]) -> Figure:
    """Share of leaks found by each time, for every sensor, and for the quickest detector that knows the rate."""
    figure = Figure(figsize=(9.0, 6.0), layout="constrained")
    for axes, name in zip(figure.subplots(2, 2).flat, LEAKS, strict=True):
        for colour, ending in enumerate(SENSORS):
            found = trials(rows, name + ending)
            delays = np.sort([t["delay"] for t in found if t["delay"] is not None])
            if len(delays):
                share = np.arange(1, len(delays) + 1) / len(found)
                axes.step(delays, share, where="post", color=f"C{colour}", label=SENSOR_NAMES[ending])
            if found and not ending:
                every = np.array([t["bound"] for t in found])
                known = np.sort(every[:, every.mean(axis=0).argmin()])
                axes.step(
                    known, np.arange(1, len(known) + 1) / len(known), "k:", where="post",
                    label="20 Hz, rate known",
                )  # fmt: skip
        axes.set(xscale="log", xlabel="time since the leak began [s]", ylim=(0.0, 1.02))
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_title(f"Leak of {LEAK_NAMES[name]}")
    figure.axes[0].set_ylabel("share found [-]")
    figure.axes[2].set_ylabel("share found [-]")
    figure.legend(*figure.axes[0].get_legend_handles_labels(), fontsize="small", loc="outside lower center", ncols=5)
    return figure


def _statistics(rows: Sequence[Row]) -> Figure:
    """Of hours without a leak, how many have a statistic above each level, against the designed rate."""
    figure = Figure(figsize=(6.5, 4.0), layout="constrained")
    axes = figure.subplots()
    for colour, ending in enumerate(SENSORS):
        largest = np.sort([x for row in rows for x in row["sound"][ending]["largest"]])[::-1]
        axes.step(
            largest, np.arange(1, len(largest) + 1) / len(largest), color=f"C{colour}", label=SENSOR_NAMES[ending]
        )
    axes.plot(1.0, 0.01 / 4.0, "ko", label="designed: one in 400 wheel hours")
    axes.set(
        yscale="log", xlim=(0.0, 1.5), xlabel="largest statistic of an hour over its threshold [-]",
        ylabel="share of wheel hours above [-]", title="Hours without a leak",
    )  # fmt: skip
    axes.legend(fontsize="small")
    return figure
