"""One wheel's monitor: events of its sensors in, estimates and events out. Compiled; the study runs the same code.

For every pressure sample: temperature to that time (`warmth`), how long the load may have changed (`standing`),
pressure at the reference temperature, quiet filter, CUSUMs on its whitened innovation, leak filter. Intervals are
measured: 20 Hz or a sample a minute is the same code. An innovation beyond OUTLIER is not followed; BELIEVED of them in
a row are a new level: above all that was there before a refill, from which all starts anew; a burst, for which the
CUSUMs alarm; or the end of a fast leak. The alarm is latched until a refill.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled, inlined
from estimators.direct_pressure import bank, leak, noise, onsets, quiet, standing, thresholds, warmth
from estimators.direct_pressure.numbers import (
    ATMOSPHERE,
    BELIEVED,
    MODEL,
    OUTLIER,
    REFERENCE,
    SHIFTS,
    STALE,
)

Array = NDArray[np.float64]

PRESSURE, TEMPERATURE, SPEED = range(3)
"""Kinds of events: [Pa, gauge], [K], the wheel's [rad/s]."""
TIME, RUN, LATCHED, SINCE, EXCESS, HEARD, X, KNOWN, BEFORE, STATUS = range(10)
"""Of `status`. RUN: outliers in a row, with sign; EXCESS: largest statistic over its threshold; X: last whitened
innovation; KNOWN: onsets kept; BEFORE: the last level that was believed [Pa, at the reference temperature]."""
NOTHING, LEAK, REFILL = range(3)  # what a sample may set off
SAID = (
    "time",
    "pressure",
    "pressure_std",
    "rate",
    "rate_std",
    "excess",
    "event",
    "x",
)  # columns of what `follow` gives
_KEPT = 8.0  # s; a silence of more than so many intervals leaves no evidence from before


class Memory(NamedTuple):
    """What a wheel's monitor remembers; `scratch` is for the leak filter's own sums."""

    warmth: Array
    noise: Array
    standing: Array
    quiet: Array
    leak: Array
    bank: Array
    onsets: Array
    status: Array
    levels: Array
    scratch: Array


def new_memory() -> Memory:
    """Of a wheel of which nothing was heard."""
    return Memory(
        np.zeros(warmth.SIZE), np.zeros(noise.SIZE), np.zeros(standing.SIZE), np.zeros(quiet.SHAPE),
        np.zeros(leak.SHAPE), np.zeros(len(SHIFTS)), np.zeros((onsets.MOST, onsets.SIZE)), np.zeros(STATUS),
        thresholds.table(), np.zeros((leak.SIZE + 1, leak.SIZE)),
    )  # fmt: skip


@inlined
def _begin(m, time, z, variance, disturbance):
    """All but the temperature and the noise starts anew with a sample z."""
    _settle(m, z, variance, disturbance)
    m.status[:] = 0.0
    m.status[TIME], m.status[HEARD] = time, 1.0
    _rewind(m, z)


@inlined
def _settle(m, z, variance, disturbance):
    """The filters start anew from a sample z."""
    quiet.start(m.quiet, z, variance, disturbance)
    leak.start(m.leak, z, variance, disturbance, 10.0**2)


@inlined
def _rewind(m, level):
    """The CUSUMs back to 0, no evidence of any onset."""
    m.bank[:] = 0.0
    m.status[KNOWN], m.status[BEFORE] = 0.0, level


@inlined
def _pressure(m, time, raw):
    """Takes a pressure sample [Pa, gauge]; says what it sets off, and T / T0."""
    w, s, n = m.warmth, m.status, m.noise
    dt = time - s[TIME] if s[HEARD] > 0.0 else 0.0
    changed = standing.taken(m.standing, time)
    known = w[warmth.KNOWN] > 0.0 and time - w[warmth.TIME] < max(120.0, STALE * n[noise.INTERVAL])
    heat = 1.0
    if w[warmth.KNOWN] > 0.0:  # after the last sample its slope is no longer trusted
        heat = (w[warmth.T] + w[warmth.SLOPE] * min(time - w[warmth.TIME], 60.0)) / REFERENCE
    disturbance, tau, wander = MODEL.disturbance_std, MODEL.disturbance_time, MODEL.wander
    if m.standing[standing.KNOWN] == 0.0:
        disturbance, wander = MODEL.disturbance_std_without_speed, MODEL.wander_without_speed
    if not known:
        disturbance, tau = MODEL.disturbance_std_without_warmth, MODEL.disturbance_time_without_warmth
    z = (raw + ATMOSPHERE) / heat
    if s[HEARD] == 0.0:
        _begin(m, time, z, MODEL.noise_std**2, disturbance)
        noise.start(n)
        noise.heard(n, 0.0, raw, z)
        return NOTHING, heat
    s[TIME] = time
    if noise.heard(n, dt, raw, z):
        _settle(m, z, noise.variance(n), disturbance)
        _rewind(m, z)
        return NOTHING, heat
    r = noise.variance(n)
    e_keeps, l_keeps = np.exp(-dt / tau), np.exp(-changed / MODEL.load_time)
    keeps = (1.0, e_keeps, l_keeps)
    gained = (
        wander**2 * dt,
        (1.0 - e_keeps * e_keeps) * disturbance**2,
        (1.0 - l_keeps * l_keeps) * MODEL.load_std**2,
    )
    gauge = max(m.leak[leak.A, 0] * heat - ATMOSPHERE, 5e3)
    rate_wander = MODEL.rate_wander**2
    if s[LATCHED] > 0.0:
        rate_wander = MODEL.rate_wander_after_alarm**2 + (MODEL.relative_wander * m.leak[leak.R, 0]) ** 2
    leak.predict(m.leak, dt, keeps, gained, rate_wander * dt, gauge)
    quiet.predict(m.quiet, keeps, gained)
    gain, total = quiet.gains(m.quiet, r)
    innovation = z - m.quiet[quiet.A, 0] - m.quiet[quiet.E, 0] - m.quiet[quiet.L, 0]
    if s[LATCHED] > 0.0:
        expected, spread = leak.level(m.leak)
        innovation, total = z - expected, spread + r
    else:
        s[KNOWN] = onsets.predict(m.onsets, int(s[KNOWN]), keeps, dt, time)
    s[X] = x = innovation / total**0.5
    if abs(x) > OUTLIER:
        return _outlier(m, time, z, r, x, total, disturbance, gauge), heat
    s[RUN] = 0.0
    leak.correct(m.leak, z, noise.likely(n), m.scratch[leak.SIZE])
    s[BEFORE] = leak.level(m.leak)[0]
    if s[LATCHED] > 0.0:
        return NOTHING, heat
    if n[noise.WARM] == 0.0 and s[EXCESS] < 0.5:
        noise.follow(n, innovation**2 / (total - r + max(n[noise.VARIANCE], 1.0)))
    quiet.correct(m.quiet, innovation, gain, total)
    if dt > _KEPT * n[noise.INTERVAL]:
        _rewind(m, s[BEFORE])
    return _alarm(m, x, gain, total, gauge), heat


@inlined
def _outlier(m, time, z, r, x, total, disturbance, gauge):
    """A sample that the filters do not follow, unless it is one of several."""
    s = m.status
    side = 1.0 if x > 0.0 else -1.0
    s[RUN] = s[RUN] + side if s[RUN] * side > 0.0 else side
    if abs(s[RUN]) >= BELIEVED:
        if z > s[BEFORE] + OUTLIER * r**0.5:
            _begin(m, time, z, r, disturbance)
            return REFILL
        quiet.start(m.quiet, z, r, disturbance)
        leak.jump(m.leak, z, r, 1e3**2 + m.leak[leak.R, 0] ** 2)
        s[KNOWN], s[BEFORE] = 0.0, z
    if s[LATCHED] > 0.0:
        return NOTHING
    return _alarm(m, x, (0.0, 0.0, 0.0), total, gauge)


@inlined
def _alarm(m, x, gain, total, gauge):
    """The CUSUMs take a whitened innovation; the one farthest above its threshold alarms."""
    s, n = m.status, m.noise
    if n[noise.WARM] > 0.0:
        return NOTHING
    bank.take(m.bank, x)
    likely = total - noise.variance(n) + noise.likely(n)  # an alarm is on the safe side, a rate has no such side
    onsets.take(m.onsets, int(s[KNOWN]), x * (total / likely) ** 0.5, gain, likely)
    s[EXCESS] = 0.0
    column, share = thresholds.place(n[noise.INTERVAL])
    for i in range(len(SHIFTS)):
        low, high = m.levels[i, column], m.levels[i, column + 1]
        s[EXCESS] = max(s[EXCESS], m.bank[i] / (low + share * (high - low)))
    if s[EXCESS] <= 1.0:
        return NOTHING
    s[LATCHED] = 1.0
    mean, second = m.scratch[leak.SIZE], m.scratch[: leak.SIZE]
    s[SINCE] = onsets.posterior(m.onsets, int(s[KNOWN]), s[TIME], gauge, mean, second)
    leak.start_from(m.leak, m.quiet, mean, second)
    return LEAK


@compiled
def follow(m, time, kind, value, said):
    """Events in time order: time [s], kind (PRESSURE, TEMPERATURE or SPEED), value, shape (n,).

    said: shape (n, 8), filled with `SAID` for each pressure sample; how many is the result. Rate and std are at the
    present temperature.
    """
    given = 0
    for i in range(len(time)):
        if kind[i] == TEMPERATURE:
            warmth.heard(m.warmth, time[i], value[i])
            continue
        if kind[i] == SPEED:
            standing.heard(m.standing, time[i], value[i])
            continue
        event, heat = _pressure(m, time[i], value[i])
        level, variance = leak.level(m.leak)
        said[given, 0] = time[i]
        said[given, 1] = level * heat - ATMOSPHERE
        said[given, 2] = variance**0.5 * heat
        said[given, 3] = m.leak[leak.R, 0] * heat
        said[given, 4] = max(m.leak[leak.R, 1 + leak.R], 0.0) ** 0.5 * heat
        said[given, 5] = m.status[EXCESS]
        said[given, 6] = event
        said[given, 7] = m.status[X]
        given += 1
    return given


@compiled
def recover(m):
    """Forgets an alarm, as if the leak had never been: for counting false alarms."""
    m.status[LATCHED] = m.status[EXCESS] = 0.0
    _rewind(m, m.status[BEFORE])
    leak.start(m.leak, m.quiet[quiet.A, 0], m.quiet[quiet.A, 1 + quiet.A], MODEL.disturbance_std, 10.0**2)
    m.leak[leak.L, 0], m.leak[leak.L, 1 + leak.L] = m.quiet[quiet.L, 0], m.quiet[quiet.L, 1 + quiet.L]
