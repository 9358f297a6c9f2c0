"""Whether the car stands, from a wheel's speed: only then, and a moment after, can its load change.

State: for how long since the last pressure sample the load may have changed [s], and what the speed last said. Without
a speed, or where it is silent for more than SILENT, no load change is expected (`KNOWN` is 0).
"""

from __future__ import annotations

from estimators.compiled import inlined

SLOWEST = 1.5  # rad/s: about 2 km/h
AFTER = 5.0  # s after the wheel turns again: the load's own settling, the sensors' clocks
SILENT = 10.0  # s

STANDS, TIME, LEFT, CHANGED, KNOWN, HEARD, SIZE = range(7)


@inlined
def pass_time(s, time):
    """Brings the state on to `time` [s]."""
    dt = time - s[TIME]
    if dt <= 0.0:
        return
    if s[STANDS] > 0.0:
        s[CHANGED] += dt
    else:
        s[CHANGED] += min(dt, s[LEFT])
        s[LEFT] = max(s[LEFT] - dt, 0.0)
    s[TIME] = time
    if time - s[HEARD] > SILENT:
        s[KNOWN] = s[STANDS] = s[LEFT] = 0.0


@inlined
def heard(s, time, speed):
    """A wheel's speed [rad/s]."""
    if s[KNOWN] == 0.0:
        s[TIME], s[CHANGED] = time, 0.0
    pass_time(s, time)
    if abs(speed) <= SLOWEST:
        s[STANDS], s[LEFT] = 1.0, AFTER
    else:
        s[STANDS] = 0.0
    s[KNOWN], s[HEARD] = 1.0, time


@inlined
def taken(s, time):
    """For how long before a pressure sample, since the one before, the load may have changed [s]."""
    if s[KNOWN] > 0.0:
        pass_time(s, time)
    changed, s[CHANGED] = s[CHANGED], 0.0
    return changed
