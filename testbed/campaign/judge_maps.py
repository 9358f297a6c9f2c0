"""Figures over two of the fields that differ: road and speed where they do, else the first swept, else drawn ones, in
equal shares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Any

import numpy as np

from estimators.scores.accuracy import rmse
from testbed.campaign.judge_columns import QUANTITIES, Drives
from testbed.campaign.judge_estimates import errors
from testbed.campaign.plan import Campaign

FAVOURED = ("road", "road_gd", "speed_kmh")
MOST = 12  # different values that are shown one by one
BINS = 4


@dataclass(frozen=True)
class Axis:
    """A field: labels of its groups, and the group of each drive."""

    field: str
    labels: tuple[str, ...]
    group: tuple[int, ...]


def axes_of(campaign: Campaign, drives: Drives) -> list[Axis]:
    """At most two."""
    fields = [*campaign.swept, *campaign.drawn]
    wanted = [f for f in FAVOURED if f in fields] + [f for f in fields if f not in FAVOURED]
    return [_axis(field, [row[field] for row in drives.rows], field in campaign.swept) for field in wanted[:2]]


def _axis(field: str, values: Sequence[Any], swept: bool) -> Axis:
    """Swept values in the order of the file, of which the first drives are."""
    different = list(dict.fromkeys(values)) if swept else sorted(set(values))
    if len(different) <= MOST or isinstance(different[0], str):
        return Axis(field, tuple(f"{v:g}" if isinstance(v, float) else str(v) for v in different),
                    tuple(different.index(v) for v in values))  # fmt: skip
    edges = np.quantile(np.array(values, dtype=np.float64), np.linspace(0.0, 1.0, BINS + 1))
    groups = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, BINS - 1)
    return Axis(field, tuple(f"{a:.3g} to {b:.3g}" for a, b in pairwise(edges)),
                tuple(int(g) for g in groups))  # fmt: skip


def judge_maps(campaign: Campaign, drives: Drives) -> dict[str, Any] | None:
    """RMSE of each method and quantity by group, None if nothing differs. cells: [x][y], null without a drive."""
    axes = axes_of(campaign, drives)
    if not axes:
        return None
    x, y = axes[0], axes[1] if len(axes) > 1 else Axis("", ("all drives",), (0,) * len(drives))
    groups = np.array([x.group, y.group])
    maps = []
    for (method, kind), group in groupby(drives.names(), key=lambda n: (n.method, n.quantity)):
        error = errors(drives, list(group))
        if not np.isfinite(error).any():
            continue
        cells = [
            [_cell(error[(groups == [[i], [j]]).all(axis=0)]) for j in range(len(y.labels))]
            for i in range(len(x.labels))
        ]
        label, unit = QUANTITIES[kind].label, QUANTITIES[kind].unit
        maps.append({"method": method, "quantity": kind, "label": label, "unit": unit, "cells": cells})
    return {"x": x.field, "x_labels": x.labels, "y": y.field, "y_labels": y.labels, "maps": maps}


def _cell(error: np.ndarray) -> dict[str, Any] | None:
    seen = int(np.isfinite(error).any(axis=1).sum()) if error.size else 0
    return {"drives": seen, "rmse": rmse(error).json()} if seen else None
