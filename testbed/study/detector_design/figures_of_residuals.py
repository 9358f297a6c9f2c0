"""Figures 4.13 to 4.17 on simulated residuals, and the delays of local detectors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import norm

from testbed.study.detector_design.local import BURSTS, ERRORS, GAUSSIAN, PART, SHIFTS, TRIAL, delay, median_delay
from testbed.study.detector_design.residuals import HOLD, RANGE, conform, residuals
from testbed.study.detector_design.thesis import CONFORMED, RATE
from testbed.study.study import Row

SHOWN = 200_000  # residuals
STRETCH = 6000  # of them, against time
COLOURS = {name: f"C{number}" for number, name in enumerate(BURSTS)}


def conformed() -> dict[str, Figure]:
    """Histograms with the Gaussian of their spread, and a stretch of the residuals."""
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    (whole, *first), rest = figure.subplots(2, 3)
    r = residuals(HOLD)(np.random.default_rng(0), SHOWN)
    whole.hist(r, np.linspace(*RANGE, 120), density=True, color="0.6")
    whole.set(title="4.13: all (simulated)", yscale="log", xlabel="residual", ylabel="density")
    for axes, case in zip((*first, *rest[:2]), CONFORMED, strict=True):
        kept = conform(r, case.cut, case.zeros)
        edges = np.linspace(-case.cut, case.cut, 81)
        axes.hist(kept, edges, density=True, color="0.6")
        axes.plot(edges, norm.pdf(edges, 0.0, kept.std()), "C0-", label=f"Gaussian, sigma {kept.std():.1f}")
        axes.plot(edges, norm.pdf(edges, 0.0, 15.0), "C3--", label="Gaussian, sigma 15")
        without = "" if case.zeros else ", no zeros"
        axes.set(title=f"{case.figure}: |r| <= {case.cut:g}{without}", xlabel="residual", ylim=(0.0, 0.04))
        axes.legend(fontsize="small")
    rest[0].set_ylabel("density")
    rest[2].plot(np.arange(STRETCH) / RATE, r[:STRETCH], lw=0.5)
    rest[2].set(title="in bursts", xlabel="time [s]", ylabel="residual")
    return {"figures-4.13-4.17-residuals": figure}


def local(rows: Sequence[Row]) -> dict[str, Figure]:
    """Delays against the size of the change, Gaussian and in bursts."""
    own = [row for row in rows if row["part"] == PART]
    if not own:
        return {}
    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    for name in GAUSSIAN:
        found = [delay(own, name, place).value for place in range(len(SHIFTS))]
        left.plot(SHIFTS, found, "o-", ms=3.0, color=COLOURS[name])
    for place, name in enumerate(BURSTS):
        found = [median_delay(own, name, error).value for error in range(len(ERRORS))]
        aside = 1.0 + 0.01 * (place - len(BURSTS) // 2)  # of lines that would hide each other
        right.plot(ERRORS, aside * np.minimum(found, TRIAL), "o-", ms=3.0, color=COLOURS[name], label=name)
    right.axhline(TRIAL, color="0.5", lw=0.8)
    left.set(title=f"Gaussian, ARL0 {own[0]['arl0']:g}", xlabel="shift [std]", ylabel="mean delay [samples]")
    right.set(
        title="Residuals in bursts; top: over half not found", xlabel="constant error",
        ylabel="median delay [samples]", xscale="log",
    )  # fmt: skip
    left.set_yscale("log")
    right.set_yscale("log")
    figure.legend(fontsize="small", loc="outside lower center", ncols=4)
    return {"local-detectors": figure}
