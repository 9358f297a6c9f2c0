"""Rows on scatter against the bound, and on the signal-to-noise of a drive."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special

from estimators.drive_log import WHEELS
from estimators.scores.interval import chi_square_root, mean_interval
from estimators.wheel_speed.edge_speed import TEETH
from testbed.study.itpms_vibration.bound import frequency_bound
from testbed.study.itpms_vibration.drives import CELLS, mode_of
from testbed.study.itpms_vibration.listening import JUDGED, METHODS, timer_noise
from testbed.study.study import Row, StudyRow

MOST_OVER_BOUND = 1.5
TIMERS = (1e-6, 5e-6)  # s


@dataclass(frozen=True)
class Cell:
    """value: by method [Hz], shape (runs, wheels); std: reported [Hz]; bound [Hz]: shape (wheels,); signal_to_noise: by
    timer, mean of the wheels, shape (runs,)."""

    name: str
    mode: str
    frequency: float
    value: dict[str, NDArray[np.float64]]
    std: NDArray[np.float64]
    bound: NDArray[np.float64]
    signal_to_noise: dict[float, NDArray[np.float64]]


def cells(rows: Sequence[Row]) -> list[Cell]:
    """Those with any run in which every wheel was heard."""
    found = []
    for road, speed, kind in CELLS:
        of = [
            row for row in rows
            if row["task"]["kind"] == "cell" and (row["task"]["road"], row["task"]["speed"]) == (road, speed)
            and all(w["parameters"] for w in row["words"])
        ]  # fmt: skip
        if of:
            found.append(_cell(f"{road}_{speed:g}_km_h", kind, of))
    return found


def _cell(name: str, kind: str, of: Sequence[Row]) -> Cell:
    mode = mode_of(kind)
    table = {
        key: np.array([[w[key] for w in row["words"]] for row in of], float) for key in (*METHODS, "std", "parameters")
    }
    omega, level = (np.array([row[key] for row in of]) for key in ("omega", "level"))
    mean = table["parameters"].mean(axis=0)
    rate = TEETH * omega.mean(axis=0) / (2.0 * np.pi)
    bound = np.array([frequency_bound(mode, mean[w], JUDGED, float(rate[w])) for w in range(len(WHEELS))])
    to_noise = {t: (level / timer_noise(1.0, mode.frequency, t) / omega).mean(axis=1) for t in TIMERS}
    value = {method: table[method] for method in METHODS}
    return Cell(name, kind, float(np.exp(mean[:, 0].mean())), value, table["std"], bound, to_noise)


def squares(cell: Cell, method: str) -> tuple[float, int]:
    """Sum of squared deviations from each wheel's mean, in bounds, and its degrees of freedom."""
    value = cell.value[method]
    good = np.isfinite(value)
    mean = np.where(good, value, 0.0).sum(axis=0) / np.maximum(good.sum(axis=0), 1)
    deviation = np.where(good, value - mean, 0.0) / cell.bound
    return float(np.sum(deviation**2)), int(good.sum() - (good.sum(axis=0) > 0).sum())


def _ratio(name: str, total: float, degrees: int, limit: float | None) -> StudyRow:
    return StudyRow.of(name, "-", chi_square_root(total / degrees, degrees).at(0), limit=limit)


def median_of_worst(degrees: Sequence[int]) -> float:
    """Median of the largest of independent estimates of one std, in units of it, each of so many degrees of freedom:
    half of all repetitions of cells that are all alike show a worst one beyond it."""

    def excess(square: float) -> float:
        return float(np.prod([special.gammainc(0.5 * n, 0.5 * n * square) for n in degrees])) - 0.5

    return float(optimize.brentq(excess, 1e-6, 100.0) ** 0.5)


def table(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """See `itpms_vibration`."""
    every = cells(rows)
    for kind, ending in (("antiphase", ""), ("in_phase", "_in_phase")):
        of = [cell for cell in every if cell.mode == kind]
        for method in METHODS:
            parts = [(*squares(cell, method), cell) for cell in of]
            parts = [part for part in parts if part[1] > 0]
            if not parts:
                continue
            total, degrees, _ = max(parts, key=lambda part: part[0] / part[1])
            limit = MOST_OVER_BOUND if method == "vibration" else None
            yield _ratio(f"{method}_std_over_bound{ending}", total, degrees, limit)
            pooled = sum(p[0] for p in parts), sum(p[1] for p in parts)
            yield _ratio(f"{method}_std_over_bound{ending}_all_cells", *pooled, None)
            chance = (pooled[0] / pooled[1]) ** 0.5 * median_of_worst([part[1] for part in parts])
            yield StudyRow(f"{method}_std_over_bound{ending}_worst_by_chance", "-", None, chance)
        yield from _reported(of, ending)
        for cell in of:
            bound = float(np.sqrt(np.mean(cell.bound**2)))
            percent = 100.0 * bound / cell.frequency / mode_of(kind).sensitivity
            yield StudyRow(f"bound_60_s_{kind}_{cell.name}", "Hz", None, bound)
            yield StudyRow(f"bound_60_s_of_pressure_{kind}_{cell.name}", "%", None, percent)
    for cell in every:
        if cell.name.startswith("A_"):
            for timer, ratio in cell.signal_to_noise.items():
                name = f"signal_to_timing_noise_{timer * 1e6:g}_us_{cell.mode}_{cell.name}"
                yield StudyRow.of(name, "-", mean_interval(ratio))


def _reported(of: Sequence[Cell], ending: str) -> Iterator[StudyRow]:
    """Scatter over the std that the fit reports."""
    total, degrees = 0.0, 0
    for cell in of:
        value = cell.value["vibration"]
        if len(value) > 1:
            total += float(np.sum(((value - value.mean(axis=0)) / np.sqrt(np.mean(cell.std**2, axis=0))) ** 2))
            degrees += value.size - value.shape[1]
    if degrees:
        yield _ratio(f"vibration_std_over_reported{ending}", total, degrees, 1.0)
