"""One wheel's monitor: events of its two sensors in, estimates and events out. Compiled; the study runs the same code.

For every pressure sample: temperature to that time (`warmth`), pressure at the reference temperature, quiet filter,
CUSUMs on its whitened innovation, leak filter. Intervals are measured: 20 Hz or a sample a minute is the same code.
An innovation beyond OUTLIER is not followed; BELIEVED of them in a row are a new pressure: upward a refill, from which
all starts anew, downward a burst, for which the CUSUMs alarm. The alarm is latched until a refill.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled, inlined
from estimators.direct_pressure import bank, leak, noise, quiet, thresholds, warmth
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

TIME, RUN, LATCHED, SINCE, EXCESS, HEARD, X, STATUS = range(8)
"""Of `status`. RUN: outliers in a row, with sign; EXCESS: largest statistic over its threshold; X: last whitened
innovation."""
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
    """What a wheel's monitor remembers."""

    warmth: Array
    noise: Array
    quiet: Array
    leak: Array
    bank: Array
    status: Array
    levels: Array


def new_memory() -> Memory:
    """Of a wheel of which nothing was heard."""
    return Memory(
        np.zeros(warmth.SIZE), np.zeros(noise.SIZE), np.zeros(quiet.SIZE), np.zeros(leak.SIZE),
        np.zeros((len(SHIFTS), bank.SIZE)), np.zeros(STATUS), thresholds.table(),
    )  # fmt: skip


@inlined
def _begin(m, time, z, variance, disturbance):
    """All but the temperature and the noise starts anew with a sample z."""
    quiet.start(m.quiet, z, variance, disturbance)
    leak.start(m.leak, z, variance, disturbance, 10.0**2)
    for row in m.bank:
        bank.begin(row, time, m.noise[noise.INTERVAL])
    m.status[:] = 0.0
    m.status[TIME], m.status[HEARD] = time, 1.0


@inlined
def _measured(m, time, z, disturbance):
    """The noise is known: the filters start anew from a sample z."""
    quiet.start(m.quiet, z, noise.variance(m.noise), disturbance)
    leak.start(m.leak, z, noise.variance(m.noise), disturbance, 10.0**2)
    _rewind(m, time)


@inlined
def _rewind(m, time):
    """The CUSUMs back to 0."""
    for row in m.bank:
        bank.begin(row, time, m.noise[noise.INTERVAL])


@inlined
def _pressure(m, time, raw):
    """Takes a pressure sample [Pa, gauge]; says what it sets off, and T / T0."""
    w, s, n = m.warmth, m.status, m.noise
    dt = time - s[TIME] if s[HEARD] > 0.0 else 0.0
    known = w[warmth.KNOWN] > 0.0 and time - w[warmth.TIME] < max(120.0, STALE * n[noise.INTERVAL])
    heat = 1.0
    if w[warmth.KNOWN] > 0.0:  # after the last sample its slope is no longer trusted
        heat = (w[warmth.T] + w[warmth.SLOPE] * min(time - w[warmth.TIME], 60.0)) / REFERENCE
    disturbance = MODEL.disturbance_std if known else MODEL.disturbance_std_without_warmth
    tau = MODEL.disturbance_time if known else MODEL.disturbance_time_without_warmth
    z = (raw + ATMOSPHERE) / heat
    if s[HEARD] == 0.0:
        _begin(m, time, z, MODEL.noise_std**2, disturbance)
        noise.start(n)
        noise.heard(n, 0.0, raw, z)
        return NOTHING, heat
    s[TIME] = time
    if noise.heard(n, dt, raw, z):
        _measured(m, time, z, disturbance)
        return NOTHING, heat
    keeps, wander, r = np.exp(-dt / tau), MODEL.wander**2 * dt, noise.variance(n)
    gauge = max(m.leak[leak.A] * heat - ATMOSPHERE, 5e3)
    rate_wander = MODEL.rate_wander**2
    if s[LATCHED] > 0.0:
        rate_wander = MODEL.rate_wander_after_alarm**2 + (MODEL.relative_wander * m.leak[leak.R]) ** 2
    leak.predict(m.leak, dt, keeps, wander, disturbance, rate_wander * dt, gauge)
    quiet.predict(m.quiet, keeps, wander, disturbance)
    bank.predict(m.bank, keeps, dt)
    gain_a, gain_e, total = quiet.gains(m.quiet, r)
    innovation = z - m.quiet[quiet.A] - m.quiet[quiet.E]
    if s[LATCHED] > 0.0:
        spread = m.leak[leak.AA] + 2.0 * m.leak[leak.AE] + m.leak[leak.EE] + r
        innovation, total = z - m.leak[leak.A] - m.leak[leak.E], spread
    s[X] = x = innovation / total**0.5
    if abs(x) > OUTLIER:
        return _outlier(m, time, z, r, x, total, disturbance), heat
    s[RUN] = 0.0
    leak.correct(m.leak, z, r)
    if s[LATCHED] > 0.0:
        return NOTHING, heat
    if n[noise.WARM] == 0.0 and s[EXCESS] < 0.5:
        noise.follow(n, innovation**2 / (total - r + max(n[noise.VARIANCE], 1.0)))
    quiet.correct(m.quiet, innovation, gain_a, gain_e)
    if dt > _KEPT * n[noise.INTERVAL]:
        _rewind(m, time)
    return _alarm(m, time, x, gain_a, gain_e, total), heat


@inlined
def _outlier(m, time, z, r, x, total, disturbance):
    """A sample that the filters do not follow, unless it is one of several."""
    s = m.status
    side = 1.0 if x > 0.0 else -1.0
    s[RUN] = s[RUN] + side if s[RUN] * side > 0.0 else side
    if s[RUN] >= BELIEVED:
        _begin(m, time, z, r, disturbance)
        return REFILL
    if s[RUN] <= -BELIEVED:
        quiet.start(m.quiet, z, r, disturbance)
        m.leak[leak.A], m.leak[leak.AA], m.leak[leak.AR], m.leak[leak.AE] = z, r, 0.0, 0.0
        m.leak[leak.RR] += 1e3**2
    if s[LATCHED] > 0.0:
        return NOTHING
    return _alarm(m, time, x, 0.0, 0.0, total)


@inlined
def _alarm(m, time, x, gain_a, gain_e, total):
    """The CUSUMs take a whitened innovation; the one farthest above its threshold alarms."""
    s, n = m.status, m.noise
    if n[noise.WARM] > 0.0:
        return NOTHING
    bank.take(m.bank, x, time, n[noise.INTERVAL], gain_a, gain_e, total)
    s[EXCESS], first = 0.0, 0
    column, share = thresholds.place(n[noise.INTERVAL])
    for i in range(len(SHIFTS)):
        low, high = m.levels[i, column], m.levels[i, column + 1]
        excess = m.bank[i, bank.G] / (low + share * (high - low))
        if excess > s[EXCESS]:
            s[EXCESS], first = excess, i
    if s[EXCESS] <= 1.0:
        return NOTHING
    s[LATCHED], s[SINCE] = 1.0, m.bank[first, bank.SINCE]
    leak.start_from(m.leak, m.quiet, m.bank[first])
    return LEAK


@compiled
def follow(m, time, warm, value, said):
    """Events in time order: time [s], warm (whether a temperature [K], else a pressure [Pa, gauge]), value, shape (n,).

    said: shape (n, 8), filled with `SAID` for each pressure sample; how many is the result. Rate and std are at the
    present temperature.
    """
    given = 0
    for i in range(len(time)):
        if warm[i]:
            warmth.heard(m.warmth, time[i], value[i])
            continue
        event, heat = _pressure(m, time[i], value[i])
        x = m.leak
        variance = max(x[leak.AA] + 2.0 * x[leak.AE] + x[leak.EE], 0.0)
        said[given, 0] = time[i]
        said[given, 1] = (x[leak.A] + x[leak.E]) * heat - ATMOSPHERE
        said[given, 2] = variance**0.5 * heat
        said[given, 3] = x[leak.R] * heat
        said[given, 4] = max(x[leak.RR], 0.0) ** 0.5 * heat
        said[given, 5] = m.status[EXCESS]
        said[given, 6] = event
        said[given, 7] = m.status[X]
        given += 1
    return given


@compiled
def recover(m):
    """Forgets an alarm, as if the leak had never been: for counting false alarms."""
    m.status[LATCHED] = m.status[EXCESS] = 0.0
    _rewind(m, m.status[TIME])
    leak.start(m.leak, m.quiet[quiet.A], m.quiet[quiet.AA], MODEL.disturbance_std, 10.0**2)
