"""Study `fleet-leaks`: slow leaks in 18 months of 13 real trailers, by `estimators.slow_leak`.

Five of the trailers sent no pressure. The estimator's numbers were chosen on four (`fleet.TUNED_ON`), having looked at
pictures of all eight; all figures but the findings themselves are of the other four, unless their name says `all`.

- `leak_TRAILER_TYRE_from_DAY_alarm_DAY`: each finding's loss beyond the others', with its interval, whole finding.
- True or false: `verdict` says how, and where that is weak. `precision`: an open one counts as false. Findings of one
  tyre that is filled again and again are not independent, so the interval is too narrow; `leaking_tyres` says of how
  many tyres they are.
- False alarms: findings judged false or open, over the days watched; the record backwards, in which a leak is a rise
  and a filling a step down; innovations in blocks (`trials`), the design's worst case. Limit: the design.
- Recall and delay: leaks put into sound tyres (`trials`), found within 60 days; of the recall the tyre is the unit.
- `week_precision`, `week_recall` (`windows`): comparable in form with the published figures of the fleet's own system
  (segments, 7-day windows); those are of its 2600 vehicles and its own weak labels, these of few leaks.
- `natural_loss_kpa_month`: median over sound tyres of all trailers; `uneven_loss_kpa_month`: the largest of their
  losses beyond the others', which has to stay below what is tolerated (limit).
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from estimators.scores.bootstrap import bootstrap_of_sums
from estimators.scores.interval import (
    Interval,
    poisson_rate_interval,
    proportion_interval,
    quantile_interval,
)
from estimators.slow_leak.numbers import BETWEEN_FALSE_ALARMS, MODEL, MONTH, YEAR
from testbed.study.fleet_leaks.fleet import check_fleet, digest
from testbed.study.fleet_leaks.trials import RATES
from testbed.study.fleet_leaks.work import repeat
from testbed.study.study import Row, Study, StudyRow, Task, run_seed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DATA = Path(__file__).resolve().parents[4] / "shared" / "data" / "krone_fleet_tpms_13_trailers.parquet"
PAPER_PRECISION, PAPER_RECALL = 0.88, 0.90
KPA_MONTH = 1e-3 * MONTH  # of Pa/s


class FleetLeaksStudy(Study):
    name = "fleet-leaks"
    about = "Which tyres of a real fleet leak slowly, how fast, and how many of the alarms are false?"
    paper = "Yin, Dorniak, Beecks, Chronic Tire Pressure Loss Detection at Fleet Scale: 88 % precision, 90 % recall."
    runs = 8
    data = DATA

    @property
    def work(self) -> Callable[[Task], Row]:
        return repeat

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        check_fleet(self.data)
        known = {"data": str(self.data), "digest": digest(self.data)}
        trials = [known | {"kind": "trials", "seed": run_seed(seed, n), "small": small} for n in range(runs)]
        return [known | {"kind": "record"}, *trials]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        trailers = [trailer for row in rows for trailer in row.get("trailers", [])]
        repeated = [row for row in rows if "leaks" in row]
        return [*_findings(trailers), *_real(trailers), *_weeks(trailers), *_false(repeated), *_put_in(repeated)]

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.fleet_leaks.figures import figures  # matplotlib, only where something is drawn

        return figures([trailer for row in rows for trailer in row.get("trailers", [])])


def day_name(day: int) -> str:
    """2024-06-05 of a number of days since 1970."""
    return str(datetime.date(1970, 1, 1) + datetime.timedelta(days=day))


def findings(trailers: Sequence[Mapping[str, Any]]) -> list[tuple[Mapping[str, Any], dict[str, Any]]]:
    """Trailer and finding, in order of trailer and alarm."""
    return [(trailer, one) for trailer in trailers for one in trailer["findings"]]


def _findings(trailers: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    largest: Interval | None = None
    for trailer, one in findings(trailers):
        name = f"leak_{trailer['name']}_{trailer['tyres'][one['tyre']]}"
        rate = None if one["whole"] is None else Interval(*one["whole"]["rate"])
        yield StudyRow.of(
            f"{name}_from_{day_name(one['start'])}_alarm_{day_name(one['alarm'])}", "kPa/month", rate, scale=KPA_MONTH
        )
        if rate is not None and (largest is None or rate.value > largest.value):
            largest = rate
    yield StudyRow.of("largest_rate_kpa_month", "kPa/month", largest, scale=KPA_MONTH)


def _real(trailers: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    """Counts over all trailers, and over those that nothing was tuned on."""
    for ending, chosen in (("_all", trailers), ("", [t for t in trailers if not t["tuning"]])):
        every = findings(chosen)
        years = sum(sum(t["watched"]) for t in chosen) / YEAR
        true = sum(one["verdict"] == "true" for _, one in every)
        false = sum(one["verdict"] == "false" for _, one in every)
        yield StudyRow(f"findings{ending}", "-", None, float(len(every)))
        yield StudyRow(f"leaking_tyres{ending}", "-", None, float(len({(t["name"], f["tyre"]) for t, f in every})))
        yield StudyRow(f"tyres{ending}", "-", None, float(sum(len(t["tyres"]) for t in chosen)))
        yield StudyRow(f"tyre_years_watched{ending}", "year", None, years)
        yield StudyRow(f"judged_false{ending}", "-", None, float(false))
        yield StudyRow(f"judged_open{ending}", "-", None, float(len(every) - true - false))
        if years > 0.0:
            yield StudyRow.of(f"alarms_per_tyre_year{ending}", "1/year", poisson_rate_interval(len(every), years))
            yield StudyRow.of(
                f"false_alarms_per_tyre_year{ending}", "1/year", poisson_rate_interval(len(every) - true, years),
                limit=YEAR / BETWEEN_FALSE_ALARMS,
            )  # fmt: skip
        if every:
            yield StudyRow.of(f"precision{ending}", "-", proportion_interval(true, len(every)))
        back = sum(t["backwards"]["watched"] for t in chosen) / YEAR
        if back > 0.0:
            alarms = poisson_rate_interval(sum(t["backwards"]["alarms"] for t in chosen), back)
            yield StudyRow.of(
                f"backwards_alarms_per_tyre_year{ending}", "1/year", alarms, limit=YEAR / BETWEEN_FALSE_ALARMS
            )
    natural = np.array([rates for t in trailers for rates in t["natural"]]).reshape(-1, 2)
    if len(natural):
        yield StudyRow.of("natural_loss_kpa_month", "kPa/month", quantile_interval(natural[:, 0], 0.5), scale=KPA_MONTH)
        yield StudyRow(
            "uneven_loss_kpa_month", "kPa/month", None, KPA_MONTH * float(natural[:, 1].max()), None,
            KPA_MONTH * MODEL.tolerated,
        )  # fmt: skip


def _weeks(trailers: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    """Leaks, or tyres' stretches with alarms, are the units of the interval."""
    for ending, chosen in (("_all", trailers), ("", [t for t in trailers if not t["tuning"]])):
        units: dict[tuple[str, int, int], list[int]] = {}  # leak and alarm, leak, alarm
        sound = silent = 0
        for trailer in chosen:
            for tyre, every in enumerate(trailer["weeks"]):
                for stretch, leaking, alarmed in every:
                    unit = units.setdefault((trailer["name"], tyre, stretch), [0, 0, 0])
                    unit[0] += leaking and alarmed
                    unit[1] += leaking
                    unit[2] += alarmed
                    sound += not leaking
                    silent += not leaking and not alarmed
        for name, column, paper in (("precision", 2, PAPER_PRECISION), ("recall", 1, PAPER_RECALL)):
            sums = np.array([[u[0], u[column]] for u in units.values() if u[column]], dtype=np.float64)
            yield StudyRow.of(f"week_{name}{ending}", "-", _share(sums), paper)
        yield StudyRow(f"weeks_with_a_leak{ending}", "-", None, float(sum(u[1] for u in units.values())))
        if sound:
            yield StudyRow(f"weeks_sound_and_silent{ending}", "-", None, silent / sound)


def _share(sums: np.ndarray) -> Interval | None:
    """Of hits and cases by unit, shape (units, 2); where all agree, as if a unit were one trial."""
    if len(sums) == 0:
        return None
    share = float(sums[:, 0].sum() / sums[:, 1].sum())
    if len(sums) < 2 or share in (0.0, 1.0):
        ends = proportion_interval(share * len(sums), len(sums))
        return Interval(share, ends.low, ends.high)
    return bootstrap_of_sums(lambda totals: totals[..., 0] / totals[..., 1], sums, seed=0)


def _false(repeated: Sequence[Row]) -> Iterator[StudyRow]:
    """Interval: quantiles over replicates of the tyres."""
    rates = [alarms / (days / YEAR) for row in repeated for alarms, days in row["blocks"]]
    if not rates:
        return
    low, high = np.quantile(rates, (0.025, 0.975))
    mean = float(np.mean(rates))
    designed = YEAR / BETWEEN_FALSE_ALARMS
    yield StudyRow(
        "reordered_false_alarms_per_tyre_year", "1/year", None, mean, (min(float(low), mean), max(float(high), mean)),
        designed,
    )  # fmt: skip
    yield StudyRow(
        "tyre_years_reordered", "year", None, sum(days for row in repeated for _, days in row["blocks"]) / YEAR
    )


def _put_in(repeated: Sequence[Row]) -> Iterator[StudyRow]:
    covered, reported = 0, 0
    for kpa_month in RATES:
        name = f"{kpa_month:g}"
        every = [one for row in repeated for one in row["leaks"].get(name, []) if not one["early"]]
        delays = [math.inf if one["delay"] is None else one["delay"] for one in every]
        if not every:
            continue
        found = [delay for delay in delays if math.isfinite(delay)]
        tyres = sorted({one["tyre"] for one in every})
        sums = [
            [sum(one["delay"] is not None for one in every if one["tyre"] == t), sum(one["tyre"] == t for one in every)]
            for t in tyres
        ]
        yield StudyRow.of(f"recall_{name}_kpa_month", "-", _share(np.array(sums, dtype=np.float64)))
        if found:
            yield StudyRow.of(f"delay_{name}_kpa_month", "day", quantile_interval(found, 0.5))
        rates = [one["rate"] for one in every if one["rate"] is not None]
        if rates:
            error = [value - kpa_month for value, _, _ in rates]
            yield StudyRow.of(f"rate_error_{name}_kpa_month", "kPa/month", quantile_interval(error, 0.5), limit=0.0)
        covered += sum(low <= kpa_month <= high for _, low, high in rates)
        reported += len(rates)
    if reported:
        yield StudyRow.of("rate_interval_coverage", "-", proportion_interval(covered, reported), limit=0.95)
