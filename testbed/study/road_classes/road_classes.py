"""Study `road-classes`: the car on every ISO 8608 class, several speeds and pressures: ride, load variation, wheel hop,
rotation, rolling radius, stiffness, errors of the wheel-radius estimates; and whether all that is as learnt.

The table's `limit`: for a frequency the linearised car's, for an estimate's error the std that it reported, for t its
limit at the stated false-alarm probability. No paper gives numbers for this car.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from estimators.scores.interval import (
    Interval,
    mean_interval,
    positive_mean_interval,
    proportion_interval,
    shared_proportion_interval,
)
from testbed.study.road_classes.cells import FULL, PRESSURES, SMALL, SPEEDS, Cell, tasks
from testbed.study.road_classes.expectations import Deviation, load, paired, unpaired, worst
from testbed.study.road_classes.learn import gate_seeds
from testbed.study.road_classes.linearised import frequencies
from testbed.study.road_classes.measure import measure
from testbed.study.road_classes.quantities import AXLES, ERRORS, SHOWN, by_cell, values
from testbed.study.study import Row, Study, StudyRow, Task, run_seed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOMINAL = PRESSURES[0]
SMOOTH, ROUGH = ("A", "B", "C", "D"), ("E", "F", "G")
RESOLVED = 0.8  # share of drives whose spectrum must hold a resonance for its mean to mean something
UPRIGHT = "H"  # the class on which a car need not come through


def over_seeds(rows: Sequence[Row], quantity: str) -> Interval | None:
    """Mean of a quantity, the seed being the independent unit: its drives share a road. None without any."""
    x = values(rows, quantity)
    seeds = np.array([row["seed"] for row in rows])
    known = np.isfinite(x)
    means = [x[known & (seeds == seed)].mean() for seed in sorted(set(seeds[known].tolist()))]
    return mean_interval(means) if means else None


class RoadClasses(Study):
    name = "road-classes"
    about = "What does the car do on road classes A to H, and is it what it did before?"
    paper = "ISO 8608 roads, ISO 2631-1 ride; a regression, no paper's experiment."
    runs = 8

    @property
    def work(self) -> Callable[[Task], Row]:
        return measure

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        seeds = [run_seed(seed, number) for number in range(runs)]
        if small:
            return tasks(SMALL, gate_seeds()[:1]) + tasks(SMALL[::2], seeds)
        return tasks(SMALL, gate_seeds()) + tasks(FULL, seeds)

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        every = compared(rows)
        rows = [row for row in rows if not _learnt_on(row)]
        cells = {cell: drives for cell in FULL if (drives := by_cell(rows).get(cell.name))}
        found = [row for cell, drives in cells.items() if cell.pressure == NOMINAL for row in _ride(cell, drives)]
        found += _slow_resonances(cells)
        found += [row for kind in ("hop", "antiphase") for row in _smooth_resonances(cells, kind)]
        found += [row for kind in ("radius", "stiffness") for row in _means(cells, kind)]
        found += [row for roads in (SMOOTH, ROUGH) for row in _errors(cells, roads)]
        for road in SPEEDS:
            drives = [row for cell, of in cells.items() if cell.road == road for row in of]
            if drives:
                share = proportion_interval(sum(row["driven"] for row in drives), len(drives))
                found.append(StudyRow.of(f"drives ended upright and under way, {road}", "-", share))
        return found + _summary(every)

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.road_classes.figures import figures  # matplotlib, only where something is drawn

        return figures([row for row in rows if not _learnt_on(row)], compared(rows)["new roads"])

    def objections(self, rows: Sequence[Row]) -> list[str]:
        fell = [row for row in rows if not row["driven"] and not row["cell"].startswith(("G", UPRIGHT))]
        lines = [f"{row['cell']}, seed {row['seed']}: the car fell over or was stuck" for row in fell]
        every = compared(rows)
        return lines + [f"not as learnt, {roads}: {d}" for roads, found in every.items() for d in found if d.exceeds]


def _learnt_on(row: Row) -> bool:
    """Whether the row's road is one of those of the paired check."""
    return row["seed"] in gate_seeds()


def compared(rows: Sequence[Row]) -> dict[str, list[Deviation]]:
    """Deviations from what was learnt, on new roads and on the very same; over all cells only where all were driven."""
    learnt = load()
    new = [row for row in rows if not _learnt_on(row)]
    whole = {row["cell"] for row in new} >= set(learnt["unpaired"]["cells"])
    return {
        "new roads": [d for d in unpaired(new, learnt["unpaired"]) if whole or "," in d.what],
        "same roads": paired([row for row in rows if _learnt_on(row)], learnt["paired"]),
    }


def _summary(every: Mapping[str, Sequence[Deviation]]) -> list[StudyRow]:
    """Each quantity over all cells, and the worst single cell of each kind of roads."""
    found = [(f"t, {d.what}, new roads", d) for d in every["new roads"] if "," not in d.what]
    for roads, deviations in every.items():
        single = [d for d in deviations if "," in d.what]
        if single:
            found.append((f"t, worst cell of {len(single)}, {roads}", worst(single)))
    return [StudyRow(name, "-", None, d.t, None, d.limit) for name, d in found]


def _row(kind: str, what: str, here: Interval | None, limit: float | None = None) -> StudyRow:
    name, unit, scale = SHOWN[kind]
    return StudyRow.of(f"{name}, {what}", unit, here, limit=limit, scale=scale)


def _ride(cell: Cell, drives: Sequence[Row]) -> list[StudyRow]:
    what = f"{cell.road} at {cell.speed:g} km/h"
    if over_seeds(drives, "ride") is None:
        return []
    return [_row("ride", what, over_seeds(drives, "ride"))] + [
        _row("load_variation", f"{axle}, {what}", over_seeds(drives, f"load_variation/{axle}")) for axle in AXLES
    ]


def _slow_resonances(cells: Mapping[Cell, Sequence[Row]]) -> list[StudyRow]:
    """In-phase rotation by speed: the mean where the spectra hold it, else how wide of it a fit is."""
    found = []
    for speed in sorted({cell.speed for cell in cells}):
        for pressure in PRESSURES:
            rows = [row for cell, drives in cells.items() if (cell.speed, cell.pressure) == (speed, pressure)
                    for row in drives if row["driven"]]  # fmt: skip
            if not rows:
                continue
            for axle in AXLES:
                quantity, what = f"in_phase/{axle}", f"{axle}, {speed:g} km/h, {pressure:g} kPa"
                if np.isfinite(values(rows, quantity)).mean() >= RESOLVED:
                    limit = frequencies(speed, pressure).get(quantity)
                    found.append(_row("in_phase", what, over_seeds(rows, quantity), limit))
                else:
                    found.append(
                        StudyRow.of(f"spectra that hold the {SHOWN['in_phase'][0]}, {what}", "-", _held(rows, quantity))
                    )
    return found


def _held(rows: Sequence[Row], quantity: str) -> Interval:
    """Share of the drives that gave a quantity."""
    known = np.isfinite(values(rows, quantity))
    seeds = np.array([row["seed"] for row in rows])
    return shared_proportion_interval([known[seeds == seed].mean() for seed in sorted(set(seeds.tolist()))])


def _smooth_resonances(cells: Mapping[Cell, Sequence[Row]], kind: str) -> list[StudyRow]:
    """By pressure, over the cells of classes A to D."""
    found = []
    for pressure in PRESSURES:
        chosen = {c: drives for c, drives in cells.items() if c.road in SMOOTH and c.pressure == pressure}
        rows = [row for drives in chosen.values() for row in drives]
        for axle in AXLES:
            here = over_seeds(rows, f"{kind}/{axle}")
            if here is not None:
                known = [frequencies(c.speed, pressure).get(f"{kind}/{axle}", np.nan) for c in chosen]
                found.append(_row(kind, f"{axle}, A to D, {pressure:g} kPa", here, float(np.nanmean(known))))
    return found


def _means(cells: Mapping[Cell, Sequence[Row]], kind: str) -> list[StudyRow]:
    """By pressure, on class C at 80 km/h."""
    return [
        _row(kind, f"{axle}, C at 80 km/h, {cell.pressure:g} kPa", over_seeds(drives, f"{kind}/{axle}"))
        for cell, drives in cells.items()
        if (cell.road, cell.speed) == ("C", 80.0)
        for axle in AXLES
    ]


def _errors(cells: Mapping[Cell, Sequence[Row]], roads: Sequence[str]) -> list[StudyRow]:
    """Root mean square error of each residual, beside the root mean square of its reported std."""
    rows = [row for cell, drives in cells.items() if cell.road in roads for row in drives]
    found = []
    for quantity in ERRORS:
        name = quantity.removeprefix("error/")
        squares = [row | {"square": row[quantity] ** 2} for row in rows if row.get(quantity) is not None]
        if not squares:
            continue
        seeds = sorted({row["seed"] for row in squares})
        means = [np.mean([row["square"] for row in squares if row["seed"] == seed]) for seed in seeds]
        reported = float(np.sqrt(np.mean([row[f"std/{name}"] ** 2 for row in squares])))
        here = positive_mean_interval(means).mapped(np.sqrt)
        given = sorted({row["cell"][0] for row in squares})  # none on G: too slow for the estimator
        what = f"r.m.s. error of {name}, {given[0]} to {given[-1]}"
        found.append(StudyRow.of(what, "1e-3", here, limit=1e3 * reported, scale=1e3))
    return found
