"""The electromagnetic locking unit: a pin that holds the motor for good once it is told to.

From the order on the motor gets no current; after `delay` [s] the pin has fallen and the motor stands where it is. The
driver then steers with the gear's own ratio i_S. Left out: the notches into which the pin falls, and unlocking.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from estimators.compiled import inlined

NEVER = math.inf


class Lock(NamedTuple):
    """start: time of the order [s], NEVER for none; delay of the pin [s]."""

    start: float
    delay: float


@inlined
def told(lock, time):
    """Whether the order has been given."""
    return time >= lock.start


@inlined
def fallen(lock, time):
    """Whether the pin holds the motor."""
    return time >= lock.start + lock.delay
