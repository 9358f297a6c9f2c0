"""Figure 5: the slope of slip against normalised traction on grippy, loose and slippery ground, found by the filter.

The paper shows slip curves of asphalt, gravel and snow, without numbers. Here one car drives with friction 1.0, 0.6
and 0.2. Truth: a straight line through the slip that the simulated tyres really have, driven less free wheel, over
their traction (force over load), tenths of a second with less than TRACTION; the Magic Formula's slope at zero does not
depend on friction, so it is the bend of the curve that the line sees. Estimate: 1/k of both sides at the end.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from estimators.scores.interval import mean_interval
from testbed.campaign.variants import variant_of
from testbed.scenario import Scenario
from testbed.session import Session
from testbed.study.study import Row, StudyRow

if TYPE_CHECKING:
    from matplotlib.figure import Figure

METHOD = "wheel_radius"
FRICTIONS = ("1.0", "0.6", "0.2")
SIDES = ("left", "right")
DURATION, SPEED = 160.0, 80.0 / 3.6  # s, m/s
TRACTION = 0.3  # [-], as the estimator reads
CELL = 100  # steps of a cell
BINS = np.linspace(-0.06, 0.18, 13)  # of the traction, for the picture


def slope_drives(nominal: Scenario, share: float) -> dict[str, Any]:
    """Scenarios by friction, from the nominal one of a repetition."""
    base = dataclasses.replace(nominal, manoeuvre="motorway", speed=SPEED, duration=share * DURATION)
    return {friction: dataclasses.replace(base, friction=friction).as_notes() for friction in FRICTIONS}


def drive_slopes(drives: dict[str, Any]) -> dict[str, Any]:
    """slope/FRICTION/{value,std,truth} [-], and slope/FRICTION/slip [-], mean of each of BINS (nan where empty)."""
    row: dict[str, Any] = {}
    for friction, notes in drives.items():
        scenario = Scenario.from_notes(notes)
        traction: list[np.ndarray] = []
        slip: list[np.ndarray] = []
        said: dict[str, float] = {}
        variant = dataclasses.replace(variant_of(scenario, {}, {}, {}), only_read=True)
        with Session(scenario, None, [METHOD], variant) as session:
            for stretch, words in session.run():
                pull = stretch["fx"] / np.maximum(stretch["load"], 1.0)
                cells = len(pull) // CELL
                for given, kept in ((pull, traction), (stretch["slip_ratio"], slip)):
                    means = given[: cells * CELL].reshape(cells, CELL, 4).mean(axis=1)
                    kept.append(means[:, :2].mean(axis=1) - means[:, 2:].mean(axis=1))
                said |= {name: signal.value[-1] for name, signal in words.items() if "inverse_stiffness" in name}
        mu, s = np.concatenate(traction), np.concatenate(slip)
        line = np.abs(mu) < TRACTION
        prefix = f"slope/{friction}"
        row[f"{prefix}/truth"] = float(np.polyfit(mu[line], s[line], 1)[0])
        for key, end in (("value", ""), ("std", "/std")):
            both = [said.get(f"est/{METHOD}/inverse_stiffness_{side}{end}", np.nan) for side in SIDES]
            row[f"{prefix}/{key}"] = float(np.mean(both))
        place = np.digitize(mu, BINS)
        row[f"{prefix}/slip"] = [
            float(s[place == i].mean()) if (place == i).any() else float("nan") for i in range(1, len(BINS))
        ]
    return row


def slope_rows(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """Recovered slope, `limit` the true one, and the errors in their std."""
    for friction in FRICTIONS:
        prefix = f"slope/{friction}"
        if any(f"{prefix}/value" not in row for row in rows):
            continue
        value, std, truth = (
            np.array([row[f"{prefix}/{key}"] for row in rows], float) for key in ("value", "std", "truth")
        )
        if not np.isfinite(value).all():
            continue
        limit = 1e3 * float(truth.mean())
        yield StudyRow.of(
            f"slip slope 1/k at friction {friction}", "1e-3", mean_interval(value), limit=limit, scale=1e3
        )
        error = mean_interval(((value - truth) / std) ** 2)
        yield StudyRow.of(f"mean NEES of 1/k at friction {friction}", "-", error, limit=1.0)


def slope_figure(rows: Sequence[Row]) -> Figure:
    """Slip against traction of the simulated tyres (points), and lines of the recovered slopes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.5, 4.4), layout="constrained")
    axes = figure.subplots()
    middle = 0.5 * (BINS[1:] + BINS[:-1])
    for friction, colour in zip(FRICTIONS, ("k", "C1", "C0"), strict=True):
        slip = 1e3 * np.array([row[f"slope/{friction}/slip"] for row in rows], float)
        seen = np.isfinite(slip).any(axis=0)
        axes.plot(np.nanmean(slip[:, seen], axis=0), middle[seen], "o", color=colour, ms=4)
        slope = 1e3 * float(np.mean([row[f"slope/{friction}/value"] for row in rows]))
        at = middle[seen]
        start = float(np.nanmean(slip[:, seen])) - slope * float(at.mean())
        axes.plot(start + slope * at, at, color=colour, label=f"friction {friction}: 1/k = {1e-3 * slope:.3f}")
    axes.set(
        xlabel="slip, driven less free wheels [1e-3]", ylabel="normalised traction [-]",
        title="Points: the simulated tyres; lines: slope found by the filter",
    )  # fmt: skip
    axes.legend()
    return figure
