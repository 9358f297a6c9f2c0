"""Temperature of the gas from a sensor with a coarse step: Kalman filter on [T, dT/dt].

A tyre warms towards a level within about 1000 s at up to 0.02 K/s: dT/dt wanders by HEATING. An error of rounding stays
for as long as the temperature needs to cross the step, so samples closer than ROUNDING count for less each.
"""

from __future__ import annotations

from estimators.compiled import inlined

HEATING = 0.02 * (2.0 / 1000.0) ** 0.5  # K/s/sqrt(s)
ROUNDING = 25.0  # s: half a step of 1 K at 0.02 K/s
VARIANCE = 1.0 / 12.0 + 0.1**2  # K^2, of a sample: step of 1 K and a little noise

T, SLOPE, TT, TS, SS, TIME, KNOWN, SIZE = range(8)


@inlined
def predict(w, time):
    """Brings the state on to `time` [s]."""
    dt = time - w[TIME]
    if dt > 0.0:
        w[T] += w[SLOPE] * dt
        w[TT] += dt * (2.0 * w[TS] + dt * w[SS]) + HEATING**2 * dt**3 / 3.0
        w[TS] += dt * w[SS] + HEATING**2 * dt**2 / 2.0
        w[SS] += HEATING**2 * dt
        w[TIME] = time


@inlined
def heard(w, time, value):
    """Takes a sample [K]. w[KNOWN] is 0 before the first."""
    if w[KNOWN] == 0.0 or abs(value - w[T]) > 15.0:
        w[T], w[SLOPE], w[TT], w[TS], w[SS], w[TIME], w[KNOWN] = value, 0.0, VARIANCE, 0.0, 0.02**2, time, 1.0
        return
    dt = max(time - w[TIME], 1e-3)
    predict(w, time)
    total = w[TT] + VARIANCE * max(1.0, ROUNDING / dt)
    gain, slope_gain, miss = w[TT] / total, w[TS] / total, value - w[T]
    w[T] += gain * miss
    w[SLOPE] += slope_gain * miss
    w[SS] -= slope_gain * w[TS]
    w[TS] -= gain * w[TS]
    w[TT] -= gain * w[TT]
