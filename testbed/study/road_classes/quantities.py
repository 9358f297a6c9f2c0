"""Quantities that are compared and shown: how they are named, in which unit, and as arrays over drives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_radius.residuals import NAMES
from testbed.study.study import Row

Rows = Sequence[Row]

AXLES = ("front", "rear")
BY_AXLE = ("load_variation", "hop", "in_phase", "antiphase", "radius", "stiffness")
ERRORS = tuple(f"error/{name}" for name in NAMES)
QUANTITIES = ("ride", *(f"{kind}/{axle}" for kind in BY_AXLE for axle in AXLES), *ERRORS)

# kind -> what it is called, unit, factor from SI
SHOWN = {
    "ride": ("weighted vertical acceleration", "m/s^2", 1.0),
    "load_variation": ("load variation", "%", 100.0),
    "hop": ("wheel hop", "Hz", 1.0),
    "in_phase": ("in-phase rotation", "Hz", 1.0),
    "antiphase": ("antiphase rotation", "Hz", 1.0),
    "radius": ("rolling radius", "mm", 1e3),
    "stiffness": ("tyre stiffness", "kN/m", 1e-3),
    "error": ("error of", "1e-3", 1e3),
}


def values(rows: Rows, quantity: str) -> NDArray[np.float64]:
    """A quantity of each row, nan where it is missing, shape (n,)."""
    return np.array([np.nan if row.get(quantity) is None else row[quantity] for row in rows], float)


def by_cell(rows: Rows) -> dict[str, list[Row]]:
    """Rows of each cell, in their order."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row["cell"], []).append(row)
    return found
