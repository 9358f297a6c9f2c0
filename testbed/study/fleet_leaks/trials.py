"""What the detector would do: leaks of a known size put into sound tyres, and sound tyres' innovations reordered.

Leaks: into the telegrams (in steps of 1 kPa, as the sensors send) of one tyre at a time, from a random moment on,
watched for `WATCHED` days. The tyre's own losses stay in it.

False alarms: whitened innovations of sound tyres as they are for a tyre that loses exactly what is tolerated (mean
taken off: the design's worst case), in blocks of a week in a random order. Tyres are drawn with replacement, so that
the spread of the repetitions says how far so few tyres can be trusted.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.detectors import CusumMean, count_alarms
from estimators.slow_leak import recursion
from estimators.slow_leak.days import days_of, together
from estimators.slow_leak.monitor import find_leaks
from estimators.slow_leak.numbers import BLOCK, DAY, MODEL, MONTH, WARM_UP, Model
from testbed.study.fleet_leaks.fleet import Trailer

RATES = (10.0, 20.0, 40.0)  # kPa/month
QUIET, WATCHED = 30, 60  # days before a leak and after its start
STEP = 1e3  # Pa
REPLICATES, REORDERED = 25, 40

Array = NDArray[np.float64]


def sound_tyres(trailers: tuple[Trailer, ...]) -> list[tuple[int, int]]:
    """Trailer and tyre by number, of those without a finding."""
    found = []
    for number, trailer in enumerate(trailers):
        leaking = {leak.tyre for leak in find_leaks(*trailer.days()).leaks}
        found += [(number, tyre) for tyre in range(len(trailer.tyres)) if tyre not in leaking]
    return found


def leak(
    trailer: Trailer, tyre: int, kpa_month: float, rng: np.random.Generator, model: Model = MODEL
) -> dict[str, Any] | None:
    """tyre: its name; early: whether an alarm came before the leak; delay: days from its start to the alarm, None
    without one; rate: of the whole finding at the end of the watch, as (value, low, high) [kPa/month]. None where the
    record is too short."""
    days = [trailer.tyre_days(i) for i in range(len(trailer.tyres))]
    known = days[tyre].day
    if len(known) < 2 or known[-1] - known[0] < QUIET + WATCHED:
        return None
    start = float(rng.uniform(known[0] + QUIET, known[-1] - WATCHED))
    since = np.maximum(trailer.time / DAY - start, 0.0)
    leaking = np.round((trailer.pressure[:, tyre] - kpa_month * 1e3 / MONTH * DAY * since) / STEP) * STEP
    days[tyre] = days_of(trailer.time, leaking)
    every, pressure = together(days)
    until = every <= start + WATCHED
    found = [one for one in find_leaks(every[until], pressure[until], model).leaks if one.tyre == tyre]
    row: dict[str, Any] = {
        "tyre": f"{trailer.name} {tyre}",
        "early": any(one.alarm < start for one in found),
        "delay": None,
        "rate": None,
    }
    late = [one for one in found if one.alarm >= start]
    if late and not row["early"]:
        row["delay"] = float(late[0].alarm + 1 - start)
        if late[0].whole is not None:
            rate = late[0].whole.rate
            row["rate"] = [1e-3 * MONTH * value for value in (rate.value, rate.low, rate.high)]
    return row


def innovations(trailers: tuple[Trailer, ...], sound: list[tuple[int, int]], model: Model = MODEL) -> list[Array]:
    """Whitened ones of each sound tyre, clipped as the detector does, mean taken off."""
    found = []
    for number, trailer in enumerate(trailers):
        said = find_leaks(*trailer.days(), model._replace(tolerated=0.0)).said
        for tyre in (t for n, t in sound if n == number):
            x = said[:, tyre, recursion.X]
            x = np.clip(x[np.isfinite(x)][WARM_UP:], -model.clip, model.clip)
            found.append(x - x.mean())
    return [x for x in found if len(x) >= BLOCK]


def reordered(white: list[Array], times: int, rng: np.random.Generator) -> Array:
    """So many times all of them, in blocks in a random order, shape (n,)."""
    blocks = [x[i : i + BLOCK] for x in white for i in range(0, len(x) - BLOCK + 1, BLOCK)]
    return np.concatenate([blocks[k] for _ in range(times) for k in rng.permutation(len(blocks))])


def false_alarms(white: list[Array], replicates: int, rng: np.random.Generator) -> list[list[int]]:
    """Alarms and days of each replicate."""
    detector = CusumMean(MODEL.drift, MODEL.threshold, "lower")
    counted = []
    for _ in range(replicates):
        x = reordered([white[k] for k in rng.integers(0, len(white), len(white))], REORDERED, rng)
        counted.append([count_alarms(detector, x), len(x)])
    return counted
