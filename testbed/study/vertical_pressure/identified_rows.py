"""Rows of Table 3: the quarter cars by road class, the paper's beside those identified of this car, and how well they
follow it (mean of the nine cases' root mean square errors)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estimators.quarter_car.quarter_car import PUBLISHED
from models.identified import identified_by_class
from testbed.study.study import StudyRow

COLUMNS = {
    "damping": ("c_s", "N s/m", 0), "quadratic_damping": ("c_snl", "N s^2/m^2", 1), "spring_rate": ("k_s", "N/m", 2),
    "spring_progression": ("k_snl", "N/m^3", 3),
}  # fmt: skip


def table() -> Iterator[StudyRow]:
    """See the module; the paper has one quarter car, here it is compared with the front's."""
    for axle, classes in identified_by_class().items():
        for road, values in classes.items():
            for name, (symbol, unit, place) in COLUMNS.items():
                paper = PUBLISHED[road][place] if axle == "front" else None
                yield StudyRow(f"table3.{axle}_{road}_{symbol}", unit, paper, values[name])
            for part in ("body", "hub"):
                error = float(np.mean(values[f"error_{part}"]))
                yield StudyRow(f"table3.{axle}_{road}_rmse_{part}", "m/s^2", None, error)
