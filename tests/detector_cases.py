"""Detectors of every kind, and residuals as sensors really give them, for the tests of the detectors."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.detectors import (
    CusumMean,
    CusumVariance,
    Detector,
    Ewma,
    Glr,
    Integrator,
    LocalCusum,
    Monitor,
    Readings,
)
from estimators.detectors.loops import ALARMS, REFUSED, RESTART, USED, follow

DETECTORS: dict[str, Detector] = {
    "cusum": CusumMean(0.5, 4.0),
    "cusum lower": CusumMean(0.25, 3.0, "lower"),
    "cusum two-sided": CusumMean(0.5, 0.0, "both"),
    "cusum variance": CusumVariance(1.6479, 8.15),
    "cusum variance decrease": CusumVariance(0.5493, 3.0, "decrease"),
    "gma": Ewma(0.9, 0.6),
    "gma two-sided": Ewma(0.0, 2.5, "both"),
    "glr": Glr(7, 6.0, "both"),
    "glr lower": Glr(1, 3.0, "lower"),
    "local cusum": LocalCusum((2.0,), (0.5,), (3.0,)),
    "local and global cusum, double": LocalCusum((1.5, inf), (0.5, 0.4), (3.0, 4.0), "both"),
    "ac": Integrator(1, 3.0),
    "acs": Integrator(20, 9.0, "upper"),
}
WILD = (np.nan, np.inf, -np.inf, 1e308, -1e308, 1e154, 5e-324, 0.0, -0.0)


def broken_sequence(generator: np.random.Generator, n: int) -> NDArray[np.float64]:
    """n residuals with a step, a change of spread, and wild values in a random share of the places."""
    x = generator.standard_normal(n) * 10.0 ** generator.uniform(-3.0, 3.0)
    x[generator.integers(0, n + 1) :] += generator.normal() * 10.0 ** generator.uniform(-1.0, 4.0)
    wild = generator.random(n) < generator.random() ** 2
    x[wild] = generator.choice(WILD, int(wild.sum()))
    return x


def broken_sequences(
    generator: np.random.Generator, number: int, longest: int = 32
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The same for many: shape (number, longest), of which each row counts up to its length, shape (number,)."""
    x = generator.standard_normal((number, longest)) * 10.0 ** generator.uniform(-3.0, 3.0, (number, 1))
    step = generator.standard_normal((number, 1)) * 10.0 ** generator.uniform(-1.0, 4.0, (number, 1))
    place = np.arange(longest)
    x += step * (place >= generator.integers(0, longest + 1, (number, 1)))
    wild = generator.random((number, longest)) < generator.random((number, 1)) ** 2
    x[wild] = generator.choice(WILD, int(wild.sum()))
    gap = generator.integers(0, 2 * longest, (number, 1))  # half of them have one
    x[(place >= gap) & (place < gap + generator.integers(1, longest, (number, 1)))] = np.nan
    return x, generator.integers(1, longest + 1, number)


@compiled
def sound_sequences(kind, numbers, level, mode, state, x, length):
    """How many of the sequences leave a fresh detector sound, as `assert_sound` says, and how many raise an alarm."""
    sound, alarmed = 0, 0
    for i in range(len(x)):
        n = length[i]
        state[:] = 0.0
        last, counts = np.zeros(1), np.zeros(4, dtype=np.int64)
        statistic, alarm = np.empty(n), np.empty(n, dtype=np.bool_)
        follow(kind, numbers, level, mode, state, last, counts, x[i, :n], statistic, alarm)
        good, usable = True, 0
        for k in range(n):
            good = good and np.isfinite(statistic[k]) and statistic[k] >= 0.0
            if np.isfinite(x[i, k]):
                usable += 1
            elif mode != RESTART:
                good = good and statistic[k] == (statistic[k - 1] if k else 0.0)
                good = good and alarm[k] == (k > 0 and alarm[k - 1])
        good = good and counts[USED] == usable and counts[REFUSED] == n - usable and counts[ALARMS] <= usable
        good = good and (counts[ALARMS] > 0) == alarm.any()
        sound += good
        alarmed += counts[ALARMS] > 0
    return sound, alarmed


def assert_sound(monitor: Monitor, x: NDArray[np.float64], readings: Readings) -> None:
    """After a fresh monitor saw x: statistic finite and >= 0, unchanged by what is not a number, counts right."""
    usable = np.isfinite(x)
    assert np.isfinite(readings.statistic).all()
    assert (readings.statistic >= 0.0).all()
    assert monitor.used == usable.sum()
    assert monitor.refused == len(x) - usable.sum()
    assert monitor.alarms <= monitor.used
    assert monitor.alarms == 0 or readings.alarm.any()
