"""One day of a vehicle's tyres: compiled, all state in one array.

For each tyre a local level, in units in which a day's noise has variance 1 (gain from the days' distances alone):

    y = level + c + noise        c what moves all tyres alike: the median of y - level over the others
    level gains `wander` a day, and after an alarm `wander_leaking`
    z = y - c - level            innovation
    e <- (1 - K) (e - tolerated dt)   what a loss at the tolerated rate would have made of z by now
    x = (z - e) / (s sqrt(S))    s the noise: median deviation of the last innovations from their own median
    g = max(g - clip(x) - drift, 0), alarm if g > threshold and the level goes on falling (`shape`)

Others that are leaking are not compared with, unless too few are left. An innovation beyond the outlier bound is held
back for a day. If the next one is nearer to it than to the level, the tyre has a new level, else it was an outlier.
A step up (filled, or another wheel or sensor) sets g = 0. At a step down g takes what the tyre fell by from the day
held back to this one: nothing for a mere step, much for a leak of several noises a day. Steps up are taken first, each
with the new levels of those before: of tyres that part in two halves, those that rose were filled. A leak ends with a
step up or with g back at 0.
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import compiled
from estimators.slow_leak.numbers import (
    DAY,
    LEAST_OUTLIER,
    MEMORY,
    MOST,
    OTHERS,
    OUTLIER,
    WARM_UP,
)
from estimators.slow_leak.shape import LEAK, STEP, shape_of

LEVEL, VARIANCE, LAST, TOLERATED, G, ON, START, HELD, COUNT, KEPT, HISTORY = range(11)
DAYS = HISTORY + MEMORY  # of the last values, then these themselves, oldest first
VALUES = DAYS + MEMORY
SIZE = VALUES + MEMORY
RELATIVE, X, STATISTIC, EVENT, SINCE, NOISE = range(6)
SAID = 6
NOTHING, ALARM, STEP_UP, STEP_DOWN, OVER, NO_OTHERS, OUTLYING = range(7)
_MAD = 1.4826  # of a Gaussian's median absolute deviation to its std


@compiled
def noise_of(tyre, model):
    """Noise of a day's value [Pa], from innovations in the tyre's memory."""
    kept = min(int(tyre[COUNT]), MEMORY)
    square = model.noise_days * model.noise_std**2
    if kept > 0:
        last = tyre[HISTORY : HISTORY + kept].copy()
        square += kept * (_MAD * np.median(np.abs(last - np.median(last)))) ** 2
    return max(np.sqrt(square / (model.noise_days + kept)), model.least_noise_std)


@compiled
def others_level(surplus, leaking, mine):
    """Median of the others' y - level, those that leak only if too few are left; NaN if there are too few at all."""
    for heed in (True, False):
        number = 0
        chosen = np.empty(len(surplus))
        for j in range(len(surplus)):
            if j != mine and np.isfinite(surplus[j]) and not (heed and leaking[j]):
                chosen[number] = surplus[j]
                number += 1
        if number >= OTHERS:
            return np.median(chosen[:number])
    return np.nan


@compiled
def restart(tyre, day, level, variance):
    """A new level from today on."""
    tyre[LEVEL], tyre[VARIANCE], tyre[LAST], tyre[TOLERATED], tyre[HELD] = level, variance, day, 0.0, np.nan
    tyre[KEPT] = 0.0


@compiled
def keep(tyre, day, r):
    """Adds a day's value to the last ones."""
    kept = int(tyre[KEPT])
    if kept == MEMORY:
        tyre[DAYS : DAYS + kept - 1] = tyre[DAYS + 1 : DAYS + kept].copy()
        tyre[VALUES : VALUES + kept - 1] = tyre[VALUES + 1 : VALUES + kept].copy()
        kept -= 1
    tyre[DAYS + kept], tyre[VALUES + kept] = day, r
    tyre[KEPT] = kept + 1.0


@compiled
def expected(tyre, day, tolerated, model):
    """Today's variance of the level and what a tolerated loss makes of an innovation [Pa]."""
    dt = day - tyre[LAST]
    wander = model.wander_leaking if tyre[ON] else model.wander
    return tyre[VARIANCE] + wander * dt, tyre[TOLERATED] - tolerated * DAY * dt


@compiled
def surprise(tyre, day, r, tolerated, model):
    """1 or -1: r [Pa] lies above or below all that is usual; 2 or -2: and the day held back did too; 0: neither."""
    variance, e = expected(tyre, day, tolerated, model)
    z = r - tyre[LEVEL]
    if abs(z - e) <= max(OUTLIER * noise_of(tyre, model) * np.sqrt(variance + 1.0), LEAST_OUTLIER):
        return 0
    sign = 1 if z > e else -1
    held = tyre[HELD]
    if np.isfinite(held) and (held - tyre[LEVEL]) * sign > 0.0 and abs(r - held) < abs(z):
        return 2 * sign
    return sign


@compiled
def raise_statistic(tyre, x, model):
    """g after a whitened innovation."""
    taken = min(max(x, -model.clip), model.clip)
    tyre[G] = min(max(tyre[G] - taken - model.drift, 0.0), MOST * model.threshold)


@compiled
def judge(tyre, day, model, said):
    """The alarm, from g as it is now."""
    if tyre[G] == 0.0:
        if tyre[ON]:
            said[EVENT] = OVER
        tyre[START], tyre[ON] = day, 0.0
    elif tyre[G] > model.threshold and not tyre[ON]:
        kept = int(tyre[KEPT])
        values = tyre[VALUES : VALUES + kept]
        found, after = shape_of(tyre[DAYS : DAYS + kept], values)
        if found == STEP:
            restart(tyre, day, np.mean(values[after:]), 1.0 / (kept - after))
            tyre[G], tyre[START] = 0.0, day
            said[EVENT] = STEP_DOWN
        elif found == LEAK:
            tyre[ON] = 1.0
            said[EVENT] = ALARM


@compiled
def step(tyre, day, r, up, model, said):
    """A new level, for the second day at least; up: filled, down: what it fell by since the day before counts."""
    held = tyre[HELD]
    said[RELATIVE] = r
    said[EVENT] = STEP_UP if up else STEP_DOWN
    restart(tyre, day, 0.5 * (r + held), 0.5)
    if up:
        tyre[G], tyre[ON], tyre[START] = 0.0, 0.0, day
    elif tyre[COUNT] > WARM_UP:
        tyre[HELD] = r
        raise_statistic(tyre, (r - held) / (noise_of(tyre, model) * np.sqrt(2.0)), model)
        judge(tyre, day, model, said)


@compiled
def take(tyre, day, r, tolerated, model, said):
    """A usual day's value less what is common, r [Pa], of one tyre."""
    said[RELATIVE] = r
    variance, e = expected(tyre, day, tolerated, model)
    z, total, s = r - tyre[LEVEL], variance + 1.0, noise_of(tyre, model)
    gain = variance / total
    tyre[LEVEL] += gain * z
    tyre[VARIANCE] = (1.0 - gain) * variance
    tyre[TOLERATED] = (1.0 - gain) * e
    tyre[LAST], tyre[HELD] = day, np.nan
    if not tyre[ON]:
        tyre[HISTORY + int(tyre[COUNT]) % MEMORY] = z / np.sqrt(total)
        tyre[COUNT] += 1.0
    x = (z - e) / (s * np.sqrt(total))
    said[X], said[NOISE] = x, s
    keep(tyre, day, r)
    if tyre[COUNT] <= WARM_UP:
        tyre[START] = day
        return
    raise_statistic(tyre, x, model)
    judge(tyre, day, model, said)


@compiled
def one_day(memory, day, pressure, tolerated, compare, model, said):
    """All tyres' values of a day: pressure [Pa], shape (tyres,); said: shape (tyres, SAID)."""
    tyres = len(pressure)
    surplus = pressure - memory[:, LEVEL]
    if compare and not np.isfinite(surplus).any():  # the first day of them all: what is common is their median
        present = np.isfinite(pressure)
        surplus[:] = np.where(present, np.median(pressure[present]) if present.any() else np.nan, np.nan)
    leaking = memory[:, ON] > 0.0
    done = ~np.isfinite(pressure)
    for rising in (True, False):
        for i in range(tyres):
            if done[i] or (rising and not np.isfinite(memory[i, LEVEL])):
                continue
            common = others_level(surplus, leaking, i) if compare else 0.0
            r = pressure[i] - common
            if not np.isfinite(common):
                said[i, EVENT] = NO_OTHERS
                continue
            if not np.isfinite(memory[i, LEVEL]):
                said[i, RELATIVE] = r
                restart(memory[i], day, r, 1.0)
                memory[i, START] = day
                continue
            found = surprise(memory[i], day, r, tolerated, model)
            if rising and found != 2:
                continue
            done[i] = True
            if abs(found) == 2:
                step(memory[i], day, r, found > 0, model, said[i])
                surplus[i] = pressure[i] - memory[i, LEVEL]
            elif found != 0:
                memory[i, HELD] = r
                said[i, RELATIVE], said[i, EVENT] = r, OUTLYING
            else:
                take(memory[i], day, r, tolerated, model, said[i])


@compiled
def follow(memory, days, pressure, tolerated, compare, model, said):
    """Takes days in rising order. memory: shape (tyres, SIZE), LEVEL and HELD of NaN in new ones; days: shape (n,);
    pressure: [Pa], shape (n, tyres); tolerated: [Pa/s]; compare: whether there are others to compare with; said:
    filled, (n, tyres, SAID)."""
    said[:] = np.nan
    for t in range(len(days)):
        said[t, :, EVENT] = NOTHING
        one_day(memory, days[t], pressure[t], tolerated, compare, model, said[t])
        said[t, :, STATISTIC], said[t, :, SINCE] = memory[:, G], memory[:, START]
