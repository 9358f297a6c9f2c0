"""Which samples of a signal can be believed to be in order: late, repeated and wild time stamps.

A stamp that is not after the last good one is late or repeated: the sample is refused. A stamp more than `LONGEST_GAP`
ahead is held until the next one confirms it (a true gap) or not (a wild stamp); the held sample itself is never used,
so the decision needs no look ahead. Everything depends on the order of the samples of the one signal, not on how they
are cut into stretches. A clock that is set back for good stays silent until it catches up, and is flagged all along.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FARTHEST = 9e9  # [s] that a count of nanoseconds in 64 bits can hold
LONGEST_GAP = 10.0  # [s]; a stamp further ahead needs a second one to be believed
USUAL_GAPS = 5.0  # times the usual interval, the same for a sensor that seldom speaks


class Intake:
    """Decides sample by sample; remembers the last good stamp and a held one."""

    def __init__(self, longest_gap: float = LONGEST_GAP) -> None:
        """longest_gap: [s], more than `LONGEST_GAP` for a sensor that seldom speaks."""
        self._longest_gap = longest_gap
        self.last: float | None = None
        self._held: float | None = None

    def accept(self, time: NDArray[np.float64]) -> tuple[NDArray[np.bool_], list[tuple[float, str]]]:
        """time [s] in order of arrival -> which to use, and (clock [s], complaint) for each refused one."""
        good = np.ones(len(time), dtype=bool)
        if len(time) == 0:
            return good, []
        if self._in_order(time):
            good[0] = self.last is not None or self._held is not None
            self.last, self._held = float(time[-1]), None
            return good, []
        complaints: list[tuple[float, str]] = []
        for i, stamp in enumerate(time.tolist()):
            good[i], complaint = self._judge(stamp)
            if complaint:
                complaints.append((self.last if self.last is not None else 0.0, complaint))
        return good, complaints

    def _in_order(self, time: NDArray[np.float64]) -> bool:
        """Nothing to decide: every stamp follows closely on the one before (the common case, without a loop)."""
        known = [stamp for stamp in (self.last, self._held) if stamp is not None]
        steps = np.diff(np.concatenate([known, time]))
        plain = len(known) < 2 and len(steps) > 0 and bool((steps > 0.0).all() and (steps <= self._longest_gap).all())
        return plain and bool(max(abs(time[0]), abs(time[-1])) <= FARTHEST)

    def _judge(self, stamp: float) -> tuple[bool, str]:
        """Whether to use the sample, and a complaint about it or about the one that was held."""
        if abs(stamp) > FARTHEST:
            return False, f"time stamps beyond {FARTHEST:g} s"
        complaint = ""
        if self._held is not None:
            confirmed = self._held < stamp <= self._held + self._longest_gap
            complaint = "" if confirmed or self.last is None else "time stamps far ahead of the clock"
            self.last, self._held = self._held if confirmed else self.last, None
        if self.last is None or stamp > self.last + self._longest_gap:
            self._held = stamp
            return False, complaint
        if stamp <= self.last:
            return False, "repeated time stamps" if stamp == self.last else "late time stamps"
        self.last = stamp
        return True, complaint


def arrival_times(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """When each sample of a recorded signal arrived [s]: its own stamp if good, else the last good one before it."""
    usual = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    good, _ = Intake(max(LONGEST_GAP, USUAL_GAPS * usual)).accept(time)
    if not good.any():
        return np.maximum.accumulate(np.clip(time, -FARTHEST, FARTHEST)) if len(time) else time
    clock = np.maximum.accumulate(np.where(good, time, -np.inf))
    return np.where(np.isfinite(clock), clock, time[good][0])
