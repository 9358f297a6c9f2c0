"""The monitor on made-up days: hours without a leak, and leaks that begin at a random moment of a drive. JSON values.

The monitor is the estimator's own compiled code, with the wheel's speed at every telegram and once a second. Hours:
after an alarm it is reset, so alarms can be counted. Leaks: 25 to 35 min after the sensors woke up; a trial with an
alarm before the leak is left out of the delays (and counted). The leak rate is compared with the truth at the alarm,
and once more as long after the leak's beginning again.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.direct_pressure.monitor import LEAK, PRESSURE, SAID, SPEED, TEMPERATURE, follow, new_memory, recover
from estimators.direct_pressure.numbers import REFERENCE
from estimators.drive_log import WHEELS
from testbed.study.study import run_seed
from testbed.study.tpms_leak.bound import SHIFTS, first_alarms, first_matched, length, levels
from testbed.study.tpms_leak.plant import DAYS, Days, Sensor, days, new_state

HOUR = 3600.0
BEFORE = (1500.0, 2100.0)  # s, within which a leak begins
ROLLING_RADIUS = 0.36  # m

Array = NDArray[np.float64]


@compiled
def _count(m, time, kind, value, said, excess):
    """False alarms among events; the largest excess between two of them goes to `excess`, shape (1,)."""
    alarms = 0
    for i in range(len(time)):
        if follow(m, time[i : i + 1], kind[i : i + 1], value[i : i + 1], said) == 0:
            continue
        excess[0] = max(excess[0], said[0, 5])
        if said[0, 6] == LEAK:
            alarms += 1
            recover(m)
    return alarms


def events(sent: Array, speed: bool = True) -> tuple[Array, NDArray[np.int64], Array]:
    """What `days` gives as the monitor takes it: speed (if it is to know it) and temperature before the pressure."""
    kinds = [SPEED, TEMPERATURE, PRESSURE] if speed else [TEMPERATURE, PRESSURE]
    rows = {SPEED: sent[5] / ROLLING_RADIUS, TEMPERATURE: sent[2], PRESSURE: sent[1]}
    value = np.stack([rows[kind] for kind in kinds], axis=1).reshape(-1)
    return np.repeat(sent[0], len(kinds)), np.tile(kinds, sent.shape[1]), value


def sound_hours(
    sensor: Sensor, hours: float, seed: int, number: int, plan: Days = DAYS, speed: bool = True
) -> dict[str, Any]:
    """Four wheels for so many hours: false alarms, and the largest statistic over its threshold of every hour."""
    alarms, largest = 0, []
    span = max(hours, 1.0 / 60.0)
    pieces = max(round(span), 1)
    for wheel in range(len(WHEELS)):
        state, memory, said = new_state(), new_memory(), np.zeros((1, len(SAID)))
        for piece in range(pieces):
            rng = np.random.default_rng(run_seed(seed, number, 1000 * wheel + piece))
            sent = days(
                plan, state, rng, span / pieces * HOUR, sensor.interval, sensor.noise, sensor.step, 0.0, np.inf,
            )  # fmt: skip
            excess = np.zeros(1)
            alarms += _count(memory, *events(sent, speed), said, excess)
            largest.append(float(excess[0]))
    return {"alarms": int(alarms), "hours": span, "largest": largest}


def leak(sensor: Sensor, rate: float, longest: float, seed: int) -> dict[str, Any]:
    """One leak of `rate` [Pa/s], watched for `longest` [s]: delay [s] or None, whether an alarm came before, rates at
    the alarm and later as (estimate, std, truth), and the bound's delays: by shift, and matched."""
    rng = np.random.default_rng(seed)
    onset = float(rng.uniform(*BEFORE))
    sent = days(
        DAYS, new_state(), rng, onset + longest, sensor.interval, sensor.noise, sensor.step, rate, onset,
    )  # fmt: skip
    given = events(sent)
    said = np.zeros((len(sent[0]), len(SAID)))
    follow(new_memory(), *given, said)
    found = np.flatnonzero(said[:, 6] == LEAK)
    row: dict[str, Any] = {"early": bool(len(found) and sent[0, found[0]] < onset), "delay": None, "rates": []}
    if len(found) and not row["early"]:
        row["delay"] = float(sent[0, found[0]] - onset)
        later = np.searchsorted(sent[0], sent[0, found[0]] + row["delay"])
        for at in (found[0], min(later, len(said) - 1)):
            row["rates"].append([float(said[at, 3]), float(said[at, 4]), float(sent[4, at])])
    quiet = new_memory()
    quiet.levels[:] = np.inf
    follow(quiet, *given, said)
    first = int(np.searchsorted(sent[0], onset))
    told = first_alarms(said[:, 7], np.array(SHIFTS), levels(sensor.interval), first)
    row["bound"] = [float(sent[0, first + k] - onset) if k >= 0 else longest for k in told.tolist()]
    quiet = new_memory()
    quiet.levels[:] = np.inf
    warm = REFERENCE / sent[2, first]
    matched = first_matched(
        quiet, *given, said, rate * warm, sensor.interval, length(sensor.interval), onset
    )  # fmt: skip
    row["bound"].append(min(float(matched), longest))
    return row
