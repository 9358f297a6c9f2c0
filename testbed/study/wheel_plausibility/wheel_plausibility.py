"""Study `wheel-plausibility`: is an outlier of 13 km/h in a wheel speed found within 1 s, and nothing else?

58 scenarios (`scenarios`) that stand for the thesis' test drives, its own methods (`published`) beside the estimator
`wheel_plausibility` on the same cells. Rows: outlier_SIZEkmh_p95_s and double_...: errors added at random moments and
wheels (`trials`), both accused where there are two; isolation_rate: of those found, nobody else accused; real_...:
wheels that really slip by more than 13 km/h; false_alarms: accusations of a wheel within 13 km/h (`truth`);
designed_false_alarms_per_100h from the tail of the evidence; vehicle_speed_error_p95_mps: median and quantiles over
scenarios. METHOD.ROW is a method of the thesis. Tables 6.2 to 6.4: METHOD.constant_ERRORS_s; 6.9 to 6.12:
GEOMETRY.RESIDUAL_kmh (all) and circle.GEOMETRY.RESIDUAL_kmh, the circle of 10 m at 18 km/h, which is what the thesis'
own figures fit, not the 30 km/h that its caption says."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from estimators.detectors import poisson_interval
from estimators.scores.interval import Interval, proportion_interval
from estimators.scores.survival import EventTimes, event_curve
from estimators.scores.tail import fit_tail
from estimators.wheel_plausibility.geometry import GEOMETRIES
from estimators.wheel_plausibility.kernel import STEP
from estimators.wheel_plausibility.published import METHODS
from estimators.wheel_plausibility.residuals import AVERAGES, PAIRS
from estimators.wheel_plausibility.thresholds import FALSE_ALARMS_PER_HOUR
from testbed.scenario import Scenario
from testbed.study.study import Row, Study, StudyRow, Task, run_seed
from testbed.study.wheel_plausibility import work
from testbed.study.wheel_plausibility.paper import CONSTANT, RESIDUALS
from testbed.study.wheel_plausibility.scenarios import CASES, DURATION
from testbed.study.wheel_plausibility.trials import SIZES, WATCH
from testbed.study.wheel_plausibility.truth import SECOND

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SMALL, SMALL_DURATION, STRAIGHT = 8, 8.0, 75.0  # cases; s
PAPER = {"20": 2.51, "50": 0.84}  # s, Wheel-to-Wheel B
NAMES = (*(f"eps_{i + 1}{j + 1}" for i, j in PAIRS), *(f"eps_{name}" for name in AVERAGES))
CIRCLE = "circle_18_0.9"


class WheelPlausibilityStudy(Study):
    name = "wheel-plausibility"
    about = "Are wheel speeds that are off by 13 km/h found and named within a second, without false alarms?"
    paper = "Razavi, Lund 2006 (seed 004), chapter 6: Tables 6.2 to 6.12, Figures 6.3 and 6.4."
    runs = 34

    @property
    def work(self) -> Callable[[Task], Row]:
        return work.run

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        duration = SMALL_DURATION if small else DURATION
        places = range(0, len(CASES), len(CASES) // SMALL) if small else range(len(CASES))
        return [
            {
                "number": number,
                "seed": run_seed(seed, number, 1000),
                "cases": [
                    {"name": CASES[p].name, "group": CASES[p].group,
                     "scenario": CASES[p].scenario(seed, number, p, duration).as_notes()} for p in places
                ],
                "straight": Scenario(
                    road="A", speed=80.0 / 3.6, duration=0.4 * STRAIGHT if small else STRAIGHT,
                    seed=run_seed(seed, number, 2000),
                ).as_notes(),
            }
            for number in range(runs)
        ]  # fmt: skip

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        found = [json.loads(row["found"]) for row in rows]
        cases = [case for row in found for case in row["cases"] if not case["ended"]]
        return [
            *_trials(cases, "monitor"), *_false(cases), *_speed(cases), *_real(cases, "monitor"),
            *(row for method in METHODS for row in (*_trials(cases, method), *_real(cases, method))),
            *_constant(found), *_residuals(cases),
        ]  # fmt: skip

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.wheel_plausibility.figures import figures  # matplotlib, only where something is drawn

        return figures([json.loads(row["found"]) for row in rows])


def prefix(method: str) -> str:
    """Of a method's rows; the estimator's have none."""
    return "" if method == "monitor" else f"{method}."


def delays(cases: Sequence[Mapping[str, Any]], method: str, sizes: Sequence[float]) -> EventTimes | None:
    """Of the trials of these sizes [km/h], censored after WATCH; None without any."""
    told = [trial[method][0] for case in cases for trial in case["trials"] if trial["sizes"] == list(sizes)]
    if not told:
        return None
    return EventTimes([WATCH * STEP if t is None else t for t in told], [t is not None for t in told])


def _trials(cases: Sequence[Mapping[str, Any]], method: str) -> Iterator[StudyRow]:
    start, right = prefix(method), list[bool]()
    for sizes in SIZES:
        events = delays(cases, method, sizes)
        if events is None:
            continue
        label = "_".join(f"{size:g}" for size in sizes)
        name = "double_outlier_13kmh" if sizes == (13.0, 13.0) else f"{'double_' * (len(sizes) - 1)}outlier_{label}kmh"
        paper = PAPER.get(label) if method in ("monitor", "B") else None
        yield StudyRow.of(f"{start}{name}_p95_s", "s", event_curve(events).quantile(0.95), paper)
        right += [
            trial[method][1] for case in cases for trial in case["trials"]
            if trial["sizes"] == list(sizes) and trial[method][0] is not None and min(sizes) >= 13.0
        ]  # fmt: skip
    if right:
        yield StudyRow.of(f"{start}isolation_rate", "-", proportion_interval(sum(right), len(right)), limit=1.0)


def _false(cases: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    hours = sum(case["hours"] for case in cases)
    for method in ("monitor", *METHODS):
        count = sum(case["false"][method] for case in cases)
        limit = FALSE_ALARMS_PER_HOUR * hours if method == "monitor" else None
        yield StudyRow(f"{prefix(method)}false_alarms", "-", None, float(count), poisson_interval(count), limit)
    yield StudyRow("hours", "h", here=hours)
    try:
        tail = fit_tail([case["peaks"] for case in cases if case["peaks"]], SECOND * STEP / 3600.0)
        rate: Interval | None = tail.rate_at(1.0)
    except ValueError:  # too few blocks above nothing: no tail to speak of
        rate = None
    yield StudyRow.of(
        "designed_false_alarms_per_100h", "1/100 h", rate, limit=100.0 * FALSE_ALARMS_PER_HOUR, scale=100.0
    )


def _speed(cases: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    errors = np.array([case["speed_error"] for case in cases if case["speed_error"]])
    if len(errors):
        low, middle, high = np.quantile(errors[:, 0], [0.025, 0.5, 0.975])
        yield StudyRow("vehicle_speed_error_p95_mps", "m/s", here=float(middle), ci95=(float(low), float(high)))
        yield StudyRow("vehicle_speed_error_largest_mps", "m/s", here=float(errors[:, 1].max()))


def _real(cases: Sequence[Mapping[str, Any]], method: str) -> Iterator[StudyRow]:
    """Wheels that slip by more than 13 km/h for at least a second."""
    real = [found for case in cases for found in case["real"][method] if found[1] >= 1.0]
    if not real:
        return
    events = EventTimes([d if d is not None else t for _, t, d in real], [d is not None for _, _, d in real])
    yield StudyRow.of(f"{prefix(method)}real_outlier_p95_s", "s", event_curve(events).quantile(0.95))
    told = sum(d is not None for _, _, d in real)
    yield StudyRow.of(f"{prefix(method)}real_outliers_found", "-", proportion_interval(told, len(real)), limit=1.0)


def _constant(rows: Sequence[Row]) -> Iterator[StudyRow]:
    for method in ("monitor", *METHODS, "diagonal"):
        for errors, paper in CONSTANT[method].items():
            told = [row["constant"][method][errors][0] for row in rows]
            seen = [t for t in told if t is not None]
            here = float(np.median(seen)) if len(seen) > len(told) / 2 else None
            ends = (min(seen), max(seen)) if here is not None else None
            yield StudyRow(f"{prefix(method)}constant_{errors}_s", "s", paper, here, ends)


def _residuals(cases: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    for start, kept in (("", cases), ("circle.", [case for case in cases if case["name"] == CIRCLE])):
        for geometry in GEOMETRIES if kept else ():
            means = np.mean([case["residuals"][geometry] for case in kept], axis=0)
            for name, paper, mean in zip(NAMES, RESIDUALS[start + geometry], means, strict=True):
                yield StudyRow(f"{start}{geometry}.{name}_kmh", "km/h", paper, float(mean))
