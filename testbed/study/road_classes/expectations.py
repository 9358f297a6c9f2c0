"""What the car is known to do, as statistics with bounds, and whether drives agree with it.

Two checks; each alarms with a probability of FALSE_ALARM a run if nothing has changed.

`unpaired`, for roads that were not learnt on. Learnt for each cell and quantity: mean m_c and standard deviation s_c
between M seeds. With n new seeds, Student t with M - 1 degrees of freedom,

    cell        t = (mean - m_c) / (s_c sqrt(1/n + 1/M)), s_c at least NUMERIC_FLOOR of m_c
    quantity    q = mean over cells of (x - m_c)/s_c, one number a seed, its standard deviation s_q learnt as well, so
                that cells on the same seed's road may correlate: t = mean(q) / (s_q sqrt(1/n + 1/M))

Half of FALSE_ALARM is shared (Bonferroni) by the cells and quantities, half by the quantities. A quantity sees a change
that all cells share, well below what a cell can see. Its power is bounded by the roads: they move ride and load
variation by some per cent, so that 3 % of tyre stiffness shows by itself, 3 % of damper or road level does not.

`paired`, for the very roads that were learnt on: with them a drive is determined, and what is left is rounding, another
machine's or another version's. How much a figure moves with next to nothing is learnt from starts that are 1e-4 and
2e-4 faster or slower: K differences of r.m.s. s. By 30 s the car is then up to 0.2 m elsewhere on its road, far
more than rounding can do. s is at least NUMERIC_FLOOR of the figure. With n seeds

    t = mean(x - learnt) / (s sqrt(1/n)), K degrees of freedom, all of FALSE_ALARM shared by cells and quantities

so FALSE_ALARM is an upper bound there, and the check sees changes that the roads' variety hides. The study drives both
kinds of roads; the tests gate with the second.

A quantity that fewer than ENOUGH of a cell's drives gave (a resonance that its spectrum does not hold) expects nothing.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from testbed.study.road_classes.quantities import QUANTITIES, Rows, by_cell, values

FILE = Path(__file__).with_name("expected.json")
FALSE_ALARM = 1e-4
NUMERIC_FLOOR = 1e-5
ENOUGH = 0.8
DIGITS = 9
Expected = Mapping[str, Any]


@dataclass(frozen=True)
class Deviation:
    """what: quantity, or cell and quantity; t: of Student; limit: of |t|; change: relative to what was learnt [-]."""

    what: str
    t: float
    limit: float
    change: float

    @property
    def exceeds(self) -> bool:
        return not abs(self.t) <= self.limit

    def __str__(self) -> str:
        return f"{self.what}: t {self.t:+.1f}, limit {self.limit:.1f} ({100.0 * self.change:+.2f} %)"


def learn_unpaired(rows: Rows) -> dict[str, Any]:
    """{"runs": M, "cells": {cell: {quantity: [mean, std]}}, "quantities": {quantity: std}} of drives."""
    cells: dict[str, dict[str, list[float]]] = {}
    for cell, drives in by_cell(rows).items():
        for quantity in QUANTITIES:
            x = values(drives, quantity)
            x = x[np.isfinite(x)]
            if len(x) >= max(ENOUGH * len(drives), 2):
                std = max(float(x.std(ddof=1)), NUMERIC_FLOOR * abs(float(x.mean())))
                cells.setdefault(cell, {})[quantity] = [_rounded(x.mean()), _rounded(std)]
    spreads = {}
    for quantity in QUANTITIES:
        q = list(_pooled(rows, cells, quantity).values())
        if len(q) > 1:
            spreads[quantity] = _rounded(np.std(q, ddof=1))
    return {"runs": len({row["seed"] for row in rows}), "cells": cells, "quantities": spreads}


def learn_paired(plain: Rows, moved: Rows) -> dict[str, Any]:
    """Figures by seed and their numerical spread; {cell: {quantity: {"values": {seed: x}, "std": s, "degrees": K}}}."""
    found: dict[str, dict[str, Any]] = {}
    near = by_cell(moved)
    for cell, drives in by_cell(plain).items():
        for quantity in QUANTITIES:
            learnt = {row["seed"]: x for row, x in zip(drives, values(drives, quantity), strict=True)}
            d = values(near[cell], quantity) - np.array([learnt[row["seed"]] for row in near[cell]])
            if np.isfinite(d).all():
                std = max(float(np.sqrt(np.mean(d**2))), NUMERIC_FLOOR * max(map(abs, learnt.values())))
                kept = {str(seed): _rounded(x) for seed, x in learnt.items()}
                found.setdefault(cell, {})[quantity] = {"values": kept, "std": _rounded(std), "degrees": len(d)}
    return found


def _rounded(x: Any) -> float:
    return float(f"{x:.{DIGITS}g}")


def _pooled(rows: Rows, cells: Mapping[str, Any], quantity: str) -> dict[int, float]:
    """q of each seed."""
    scores: dict[int, list[float]] = {}
    for cell, drives in by_cell(rows).items():
        if quantity in cells.get(cell, {}):
            mean, std = cells[cell][quantity]
            for row, x in zip(drives, values(drives, quantity), strict=True):
                if np.isfinite(x):
                    scores.setdefault(row["seed"], []).append((x - mean) / std)
    return {seed: float(np.mean(z)) for seed, z in scores.items()}


def _limit(degrees: int, tests: int, share: float) -> float:
    return float(stats.t.isf(0.5 * share * FALSE_ALARM / max(tests, 1), degrees))


def unpaired(rows: Rows, learnt: Mapping[str, Any]) -> list[Deviation]:
    """Deviations of drives on roads that were not learnt on: each quantity over all cells, then each cell and quantity.
    All cells must be there."""
    runs, cells, spreads = learnt["runs"], learnt["cells"], learnt["quantities"]
    limit = _limit(runs - 1, len(spreads), 0.5)
    found = []
    for quantity, spread in spreads.items():
        q = list(_pooled(rows, cells, quantity).values())
        if q:
            t = np.mean(q) / (spread * np.sqrt(1.0 / len(q) + 1.0 / runs))
            found.append(Deviation(quantity, float(t), limit, _mean_change(rows, cells, quantity)))
    limit = _limit(runs - 1, sum(map(len, cells.values())), 0.5)
    for cell, drives in by_cell(rows).items():
        for quantity, (mean, std) in cells.get(cell, {}).items():
            x = values(drives, quantity)
            x = x[np.isfinite(x)]
            if len(x):
                t = (x.mean() - mean) / (std * np.sqrt(1.0 / len(x) + 1.0 / runs))
                found.append(Deviation(f"{cell}, {quantity}", float(t), limit, float(x.mean() / mean - 1.0)))
    return found


def _mean_change(rows: Rows, cells: Mapping[str, Any], quantity: str) -> float:
    """Mean over cells of the change relative to what was learnt [-]."""
    changes = [
        np.nanmean(x) / cells[cell][quantity][0] - 1.0
        for cell, drives in by_cell(rows).items()
        if quantity in cells.get(cell, {}) and np.isfinite(x := values(drives, quantity)).any()
    ]
    return float(np.mean(changes))


def paired(rows: Rows, learnt: Mapping[str, Any]) -> list[Deviation]:
    """Deviations of drives on the very roads that were learnt on; any of the cells and seeds. What was learnt and is
    missing deviates without limit."""
    tests = sum(map(len, learnt.values()))
    found = []
    for cell, drives in by_cell(rows).items():
        for quantity, entry in learnt[cell].items():
            known = np.array([entry["values"][str(row["seed"])] for row in drives])
            d = float(np.mean(values(drives, quantity) - known))
            t = d / (entry["std"] / np.sqrt(len(drives))) if np.isfinite(d) else float("inf")
            limit = _limit(entry["degrees"], tests, 1.0)
            found.append(Deviation(f"{cell}, {quantity}", t, limit, d / abs(float(known.mean()))))
    return found


def worst(deviations: Iterable[Deviation]) -> Deviation:
    """The one nearest to its limit, or farthest beyond."""
    return max(deviations, key=lambda d: abs(d.t) / d.limit)


def load(path: Path = FILE) -> Expected:
    """{"unpaired": ..., "paired": ...}"""
    return json.loads(path.read_text())
