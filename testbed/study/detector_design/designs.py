"""Run lengths that the designs state against simulated ones: every kind of detector, ARL0 from 1e2 to 1e5 samples."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from math import inf, log

import numpy as np

from estimators.detectors import (
    Design,
    design_cusum_mean,
    design_cusum_variance,
    design_ewma,
    design_glr,
    design_integrator,
    design_local_cusum,
    gaussian,
    run_lengths,
)
from estimators.scores.interval import Interval
from testbed.study.study import Row, StudyRow, Task, run_seed

KINDS: dict[str, Callable[[float], Design]] = {
    "CUSUM": lambda arl0: design_cusum_mean(1.0, arl0),
    "CUSUM, two-sided": lambda arl0: design_cusum_mean(0.5, arl0, "both"),
    "CUSUM, variance up": lambda arl0: design_cusum_variance(1.0, 3.0, arl0),
    "CUSUM, variance down": lambda arl0: design_cusum_variance(5.0, 1.0, arl0),
    "GMA": lambda arl0: design_ewma(1.0, arl0),
    "GMA, two-sided": lambda arl0: design_ewma(1.0, arl0, "both", 0.9),
    "GLR, two-sided": lambda arl0: design_glr(1.0, arl0, window=8),
    "local CUSUM": lambda arl0: design_local_cusum(1.0, arl0, (2.0,)),
    "local + global CUSUM": lambda arl0: design_local_cusum(1.0, arl0, (1.5, inf)),
    "double local + global CUSUM": lambda arl0: design_local_cusum(1.0, arl0, (2.0, inf), "both"),
    "AC": lambda arl0: design_integrator(3.0, arl0, period=1),
    "ACF": lambda arl0: design_integrator(1.0, arl0, period=8),
    "ACS": lambda arl0: design_integrator(0.5, arl0, "upper", period=60),
}
ALARMS = {1e2: 2000, 1e3: 2000, 1e4: 2000, 1e5: 1000}  # of a repetition
SMALL = {1e2: 400}
PART = "run lengths"
PURPOSE = 10  # of the seeds, from here on one a kind


@cache
def design(kind: str, arl0: float) -> Design:
    """The same in every process."""
    return KINDS[kind](arl0)


def tasks(seed: int, number: int, small: bool) -> list[Task]:
    """One a kind."""
    alarms = SMALL if small else ALARMS
    return [
        {"part": PART, "kind": kind, "alarms": [list(pair) for pair in alarms.items()],
         "seed": run_seed(seed, number, PURPOSE + place)}
        for place, kind in enumerate(KINDS)
    ]  # fmt: skip


def simulate(task: Task) -> Row:
    """`designs`: for each ARL0 asked, that stated and its method, and of the simulated run lengths [samples] count,
    sum and sum of squares."""
    found = []
    for place, (asked, alarms) in enumerate(task["alarms"]):
        stated = design(task["kind"], asked)
        lengths = run_lengths(stated.detector, gaussian(), alarms, seed=task["seed"] + place).astype(float)
        found.append({
            "asked": asked, "stated": stated.arl0.mean, "method": stated.arl0.method,
            "count": alarms, "sum": float(lengths.sum()), "squares": float(np.square(lengths).sum()),
        })  # fmt: skip
    return {"part": PART, "kind": task["kind"], "designs": found}


def ratios(rows: Sequence[Row]) -> dict[tuple[str, float], Interval]:
    """Stated over simulated run length by kind and ARL0 asked."""
    sums: dict[tuple[str, float], list[float]] = {}
    for row in rows:
        for one in row["designs"] if row["part"] == PART else ():
            total = sums.setdefault((row["kind"], one["asked"]), [one["stated"], 0.0, 0.0, 0.0])
            for place, key in enumerate(("count", "sum", "squares"), 1):
                total[place] += one[key]
    return {key: _ratio(*total) for key, total in sums.items()}


def _ratio(stated: float, count: float, total: float, squares: float) -> Interval:
    mean = total / count
    half = 1.96 * np.sqrt(max(squares / count - mean * mean, 0.0) / count)
    return Interval(stated / mean, stated / (mean + half), stated / (mean - half))


def worst(found: Sequence[Interval]) -> Interval:
    """The one farthest from 1. Its interval is its own; that it was picked is not in it."""
    return max(found, key=lambda ratio: abs(log(ratio.value)))


def table(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """The worst of all, the number of designs, and the worst of each kind."""
    found = ratios(rows)
    if not found:
        return
    yield StudyRow.of("arl0_exact_over_simulated", "-", worst(list(found.values())), limit=1.0)
    yield StudyRow("designs compared", "-", here=float(len(found)))
    for kind in KINDS:
        if own := [ratio for (name, _), ratio in found.items() if name == kind]:
            yield StudyRow.of(f"arl0_exact_over_simulated, {kind}", "-", worst(own), limit=1.0)
