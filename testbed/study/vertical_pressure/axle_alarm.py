"""The alarm of `axles`, judged: how soon it names one tyre that has lost 15 %, and how often it is wrong.

A repetition is one car (`itpms_fusion.cars`: unequal tyres, pressure law off by up to 20 %, the estimator's masses and
lengths by up to 10 %), driven on days of its own (road level log-uniform from the centre of class A to that of D, 40 to
130 km/h, payload to 400 kg, 0 to 40 C, grade, bank, wind):

    calibration           `LEARNING` seconds on sound tyres
    sound, sound_town     `SOUND` seconds on sound tyres, with that calibration; in town the car stands and creeps
    15_constant, 15_country, 15_motorway      one tyre loses 15 % of its pressure of the moment within `WITHIN` seconds,
                          after about `BEFORE` seconds; watched for `WATCH` seconds; nothing learnt before the drive
    15_before             one tyre 15 % low from the start, with the calibration of another day; `WATCH` seconds

Time to the alarm runs from the moment at which the share is lost, in the last case from the start of the drive. Row of
a drive: `wheels`, `onset_s`, `reached_s`, `end_s`, `sound_s`, `alarms` [[time_s, [wheel]]], `largest`: the largest
statistic of each side in each `SPAN` of sound driving.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from estimators.axles.watch import FALSE_ALARMS_PER_HOUR, THRESHOLD
from estimators.detectors import poisson_interval
from estimators.drive_log import WHEELS
from estimators.scores.detection import isolation_rate
from estimators.scores.false_alarms import false_alarms
from estimators.scores.survival import EventTimes, event_curve
from estimators.scores.tail import fit_tail
from testbed.campaign.variants import variant_of
from testbed.session import Session, Variant
from testbed.simulation import Diverged
from testbed.study.itpms_fusion.cars import RepetitionCar
from testbed.study.study import Row, StudyRow, Task, run_seed
from testbed.tyre.inflation import PRESSURE, PressureSet

METHOD = "axles"
LEARNING, SOUND, BEFORE, JITTER, WITHIN, WATCH = 120.0, 240.0, 35.0, 5.0, 1.0, 40.0  # s
SHARE = 0.15
SPAN, GAP = 10.0, 60.0  # s; between alarms that count as two
PAPER_TIME = 60.0  # s: vibration and radius, as published
SMALL = 0.2
ROLLING = ("constant", "country", "motorway")
_CALIBRATION = "calibration"


def alarm_task(seed: int, number: int, small: bool) -> Task:
    """The drives of repetition `number`."""
    return {"axle_alarm": [seed, number, small]}


def alarm_row(task: Task) -> Row:
    """Drives them: {"axle_alarm": JSON of the drives by name}."""
    seed, number, small = task["axle_alarm"]
    car, scale = RepetitionCar(seed, number), SMALL if small else 1.0
    rng = np.random.default_rng(run_seed(seed, number, 20_000))
    learnt: dict[str, Any] = {}
    first = car.day(60, scale * LEARNING, manoeuvre=ROLLING[int(rng.integers(3))])
    _drive(car, first, (), 0.0, None, learnt)
    found = {}
    sound = car.day(61, scale * SOUND, manoeuvre=ROLLING[int(rng.integers(3))])
    found["sound"] = _drive(car, sound, (), 0.0, learnt, {})
    found["sound_town"] = _drive(car, car.day(62, scale * SOUND, manoeuvre="town"), (), 0.0, learnt, {})
    for place, manoeuvre in enumerate(ROLLING[: 1 if small else None]):
        onset = float(round(BEFORE + rng.uniform(-JITTER, JITTER)))
        scenario = car.day(63 + place, onset + WITHIN + WATCH, manoeuvre=manoeuvre)
        wheel = WHEELS[int(rng.integers(4))]
        sets = {wheel: PressureSet((1.0 - SHARE) * scenario.pressures[wheel], onset, WITHIN)}
        lossy = dataclasses.replace(scenario, pressure_sets=sets)
        found[f"15_{manoeuvre}"] = _drive(car, lossy, (wheel,), onset, None, {})
    wheel = WHEELS[int(rng.integers(4))]
    scenario = car.day(66, WATCH, manoeuvre=ROLLING[int(rng.integers(3))])
    low = {**scenario.pressures, wheel: (1.0 - SHARE) * scenario.pressures[wheel]}
    found["15_before"] = _drive(car, dataclasses.replace(scenario, pressures=low), (wheel,), 0.0, learnt, {})
    return {"axle_alarm": json.dumps(found)}


def _drive(
    car: RepetitionCar, scenario: Any, wheels: tuple[str, ...], onset: float, known: Mapping[str, Any] | None,
    learns: dict[str, Any],
) -> dict[str, Any]:  # fmt: skip
    variant = variant_of(scenario, {}, car.tyre, car.believed, {METHOD: known} if known else None)
    only = Variant(variant.vehicle, variant.tyre, variant.car, variant.calibrations, only_read=True)
    statistic: list[tuple[float, float]] = []
    end = 0.0
    with Session(scenario, None, [METHOD], only) as session:
        inflation, gas = session.simulation.constants.inflation, session.simulation.state.gas
        try:
            for stretch, words in session.run():
                end = float(stretch["time"][-1]) + scenario.step
                if onset and round(end) == round(onset):  # the share is of the pressure of the moment
                    for wheel in wheels:
                        w = WHEELS.index(wheel)
                        inflation.set_pressure[w] = (1.0 - SHARE) * gas[w, PRESSURE]
                for side in ("left", "right"):
                    said = words.get(f"est/{METHOD}/{side}/statistic")
                    if said is not None:
                        statistic += zip(said.time.tolist(), said.value.tolist(), strict=True)
        except Diverged:  # what was driven counts
            pass
        learns |= session.bank.calibrations().get(METHOD, {})
        alarms = [[a.time, list(a.wheels)] for a in session.bank.alarms[METHOD]]
    sound = onset if onset else 0.0 if wheels else end
    return {
        "wheels": list(wheels), "onset_s": onset, "reached_s": onset + WITHIN if onset else 0.0, "end_s": end,
        "sound_s": min(sound, end), "alarms": alarms, "largest": _largest(statistic, min(sound, end)),
        "road": scenario.road, "speed_kmh": 3.6 * scenario.speed, "manoeuvre": scenario.manoeuvre,
    }  # fmt: skip


def _largest(statistic: Sequence[tuple[float, float]], end: float) -> list[float]:
    """Of each whole SPAN before `end` [s]."""
    highest: dict[int, float] = {}
    for time, value in statistic:
        highest[int(time // SPAN)] = max(highest.get(int(time // SPAN), 0.0), value)
    return [highest[k] for k in sorted(highest) if (k + 1) * SPAN <= end]


def alarm_table(rows: Sequence[Row]) -> list[StudyRow]:
    """The figures; of all repetitions that have driven their alarms."""
    repetitions = [json.loads(row["axle_alarm"]) for row in rows if row.get("axle_alarm")]
    if not repetitions:
        return []
    return [*_detection(repetitions), *_sound(repetitions)]


def _detection(repetitions: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    names = [f"15_{manoeuvre}" for manoeuvre in ROLLING]
    for group, ending in ((names, ""), *(([name], f"_{name[3:]}") for name in names), (["15_before"], "_before")):
        drives = [r[name] for r in repetitions for name in group if name in r]
        drives = [d for d in drives if d["end_s"] > d["reached_s"]]
        drives = [d for d in drives if not any(t < d["onset_s"] for t, _ in d["alarms"])]
        if not drives:
            continue
        passed = [
            max((min(t for t, _ in d["alarms"]) if d["alarms"] else d["end_s"]) - d["reached_s"], 0.0) for d in drives
        ]
        curve = event_curve(EventTimes(passed, [bool(d["alarms"]) for d in drives]))
        paper = None if ending else PAPER_TIME
        yield StudyRow.of(f"{METHOD}.detect_15pct_1_tyre{ending}_p95_s", "s", curve.quantile(0.95), paper)
        if not ending:
            yield StudyRow.of(f"{METHOD}.detect_15pct_1_tyre_median_s", "s", curve.quantile(0.5))
            named = [d["alarms"][0][1] if d["alarms"] else None for d in drives]
            if any(named):
                rate = isolation_rate(named, [d["wheels"] for d in drives])
                yield StudyRow.of(f"{METHOD}.isolation_rate", "-", rate, limit=1.0)


def _sound(repetitions: Sequence[Mapping[str, Any]]) -> Iterator[StudyRow]:
    drives = [d for r in repetitions for d in r.values() if d["sound_s"] > 0.0]
    before = [[t for t, _ in d["alarms"] if t < d["sound_s"]] for d in drives]
    counted = false_alarms(before, np.array([d["sound_s"] for d in drives]), GAP)
    limit = FALSE_ALARMS_PER_HOUR * counted.hours
    yield StudyRow(
        f"{METHOD}.false_alarms", "-", None, float(counted.count), poisson_interval(counted.count), limit
    )  # fmt: skip
    yield StudyRow(f"{METHOD}.hours", "h", None, counted.hours)
    try:
        rate = fit_tail([d["largest"] for d in drives if d["largest"]], SPAN / 3600.0).rate_at(THRESHOLD)
    except ValueError:  # too few blocks, or a threshold that is no tail
        return
    yield StudyRow.of(f"{METHOD}.designed_false_alarms_per_100h", "1/100 h", rate, limit=1.0, scale=100.0)
