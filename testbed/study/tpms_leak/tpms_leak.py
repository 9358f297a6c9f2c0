"""Study `tpms-leak`: the seed's direct tyre-pressure monitor as published (`paper`), and one that works (`trials`).

The published detector: `published_false_alarm_interval_s`, limit exact for its drift and threshold; the same without
process noise, and with the one that gives its RMSE. `published_delay_*_s`: from 20 s to the next alarm, with the leak
and without: the same, so what it reports as detection is a false alarm.

The estimator `direct_pressure` on a sensor of the paper's noise at 20 Hz, on days with warming, stops and load changes:
`delay_s_*` mean delay, limit the bound: the quickest detector that knows the rate (`bound`); `delay_over_bound` the
worst of them; `matched_over_constant_*` what a detector that knows the ramp too gains on the best CUSUM of constant
drift; the leak rate's errors in units of their reported std, one delay after the alarm and at it; false alarms of four
wheels at a designed one in 100 h. The same for sensors of 1 Hz (the testbed's), and of a telegram in 30 or 60 s in
steps of 2.5 kPa; and false alarms where tyre and days are not those that the monitor was tuned on, or it knows no
speed (`plant.MISMATCHES`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import CusumMean, poisson_interval
from estimators.direct_pressure.numbers import BETWEEN_FALSE_ALARMS
from estimators.direct_pressure.published import PUBLISHED, stationary_std
from estimators.scores.interval import mean_interval, proportion_interval, rms_interval
from testbed.study.study import Row, Study, StudyRow, Task
from testbed.study.tpms_leak.paper import PROCESSES
from testbed.study.tpms_leak.plant import NOMINAL
from testbed.study.tpms_leak.work import LEAKS, OFF, OFF_HOURS, SENSORS, repeat, task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER_RMSE, PAPER_DELAY = 0.19, 2.5  # psi, s
MOST_OVER_BOUND = 1.25
RESAMPLED = 1000
MOST_OF_NOMINAL = 0.05  # of the pressure, lost within an interval, for a rate to be judged


class TpmsLeakStudy(Study):
    name = "tpms-leak"
    about = "Does the published leak detector detect leaks, and how soon can one with a designed false-alarm rate?"
    paper = "Javaid, TPMS with Kalman filter and CUSUM in Matlab, Figures 2 to 7."
    runs = 8

    @property
    def work(self) -> Callable[[Task], Row]:
        return repeat

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        return [task(seed, number, small) for number in range(runs)]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        worst = _over_bound(rows)
        return [*_published(rows), *_delays(rows, ""), worst, *_gains(rows), *_rates(rows), *_slow(rows), *_off(rows)]

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.tpms_leak.figures import figures  # matplotlib, only where something is drawn

        return figures(rows)


def _published(rows: Sequence[Row]) -> Iterator[StudyRow]:
    exact = CusumMean(PUBLISHED.drift, PUBLISHED.threshold, "both").average_run_length().mean * PUBLISHED.step
    for ending in PROCESSES:
        alarms = sum(row["paper"][f"alarms{ending}"] for row in rows)
        seconds = sum(row["paper"][f"seconds{ending}"] for row in rows)
        low, high = poisson_interval(alarms)
        yield StudyRow(
            f"published_false_alarm_interval_s{ending}", "s", None, seconds / max(alarms, 1),
            (seconds / high, seconds / low if low else np.inf), None if ending else exact,
        )  # fmt: skip
    squares = mean_interval([x for row in rows for x in row["paper"]["squares"]])
    root = squares.mapped(lambda x: float(np.sqrt(max(x, 0.0))))
    yield StudyRow.of("published_filter_rmse_psi", "psi", root, PAPER_RMSE, stationary_std()[0])
    for kind, paper in (("with_leak", PAPER_DELAY), ("without_leak", None)):
        every = [x for row in rows for x in row["paper"][kind]]
        yield StudyRow.of(f"published_delay_{kind}_s", "s", mean_interval(every), paper)


def trials(rows: Sequence[Row], name: str) -> list[dict[str, Any]]:
    """Those of a leak without an alarm before it."""
    return [trial for row in rows for trial in row["leaks"][name] if not trial["early"]]


def _bound(found: Sequence[Mapping[str, Any]]) -> tuple[float, NDArray[np.float64]]:
    """Mean delay of the quickest detector that knows the rate [s], and its delays, shape (trials,)."""
    every = np.array([trial["bound"] for trial in found])
    best = int(every.mean(axis=0).argmin())
    return float(every[:, best].mean()), every[:, best]


def _delays(rows: Sequence[Row], ending: str) -> Iterator[StudyRow]:
    for name in LEAKS:
        found = trials(rows, name + ending)
        seen = [trial["delay"] for trial in found if trial["delay"] is not None]
        here = mean_interval(seen) if seen else None
        yield StudyRow.of(f"delay_s_{name}{ending}", "s", here, limit=_bound(found)[0] if found else None)


def _over_bound(rows: Sequence[Row]) -> StudyRow:
    """Interval: trials resampled in pairs."""
    rng, worst, ends = np.random.default_rng(0), 0.0, None
    for name in LEAKS:
        found = [trial for trial in trials(rows, name) if trial["delay"] is not None]
        if not found:
            continue
        here, known = np.array([trial["delay"] for trial in found]), _bound(found)[1]
        if here.mean() / known.mean() > worst:
            worst = float(here.mean() / known.mean())
            drawn = rng.integers(0, len(found), (RESAMPLED, len(found)))
            low, high = np.quantile(here[drawn].mean(axis=1) / known[drawn].mean(axis=1), (0.025, 0.975))
            ends = (min(float(low), worst), max(float(high), worst))
    return StudyRow("delay_over_bound", "-", None, worst or None, ends, MOST_OVER_BOUND)


def _gains(rows: Sequence[Row]) -> Iterator[StudyRow]:
    for name in LEAKS:
        every = np.array([trial["bound"] for trial in trials(rows, name)])
        ratio = every[:, -1].mean() / every[:, :-1].mean(axis=0).min() if len(every) else None
        yield StudyRow(f"matched_over_constant_{name}", "-", here=ratio)


def normalised(rows: Sequence[Row], ending: str, late: bool) -> list[float]:
    """Errors of the leak rate in units of their std, at the alarm or one delay later. Of all leaks that do not empty
    the tyre between two samples: a rate that is over tells nothing."""
    shown = [name for name, (rate, _) in LEAKS.items() if rate * SENSORS[ending].interval < MOST_OF_NOMINAL * NOMINAL]
    every = [t["rates"][int(late)] for name in shown for t in trials(rows, name + ending) if t["rates"]]
    return [(value - truth) / std for value, std, truth in every]


def _rates(rows: Sequence[Row]) -> Iterator[StudyRow]:
    for ending in SENSORS:
        for late, name in ((True, ""), (False, "_at_the_alarm")):
            errors = normalised(rows, ending, late)
            here = rms_interval(errors) if len(errors) > 1 else None
            yield StudyRow.of(f"leak_rate_rmse_over_reported_std{name}{ending}", "-", here, limit=1.0)


def _counted(name: str, parts: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    """False alarms and hours of `parts`."""
    alarms, hours = sum(part["alarms"] for part in parts), sum(part["hours"] for part in parts)
    designed = hours * 3600.0 / BETWEEN_FALSE_ALARMS
    yield StudyRow(f"false_alarms{name}", "-", None, float(alarms), poisson_interval(alarms), designed)
    yield StudyRow(f"hours{name}", "h", None, hours)


def _slow(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """False alarms of every sensor, leaks missed, and the delays that a slower sensor costs."""
    for ending in SENSORS:
        yield from _counted(ending, [row["sound"][ending] for row in rows])
        every = [trial for name in LEAKS for trial in trials(rows, name + ending)]
        missed = sum(trial["delay"] is None for trial in every)
        yield StudyRow.of(f"share_of_leaks_missed{ending}", "-", proportion_interval(missed, max(len(every), 1)))
        if ending:
            yield from _delays(rows, ending)


def _off(rows: Sequence[Row]) -> Iterator[StudyRow]:
    """False alarms with tyres and days that the monitor was not tuned for."""
    for ending in OFF_HOURS:
        for name in OFF:
            yield from _counted(f"{ending}_{name}", [row["off"][f"{ending}_{name}"] for row in rows])
