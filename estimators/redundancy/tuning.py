"""The seed's choice of parameters by a user's priorities: a first criterion that must be met, a second that is best
then.

Seed 003, section 4 and Tables 3 and 4. Each candidate (sigma, threshold) has rates and errors from sound and faulty
records; the first criterion removes all that exceed its limit, and of those left the one with the least second
criterion is taken (the first of equals). Since sigma and threshold are one parameter (`residual.limit`), candidates
with the same limit are the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from estimators.redundancy.published import Judged, Parameters

FALSE_ALARM, MISSED, ERROR = "false_alarm", "missed", "error"


@dataclass(frozen=True)
class Candidate:
    """false_alarm: share of sound samples that are judged faulty [-]; missed: share of faulty samples that are not [-];
    error: largest error of a missed sample, mean over the kinds of faults (equations 21, with its square, and 22)."""

    parameters: Parameters
    false_alarm: float
    missed: float
    error: float


def choose(candidates: Sequence[Candidate], first: str, limit: float, second: str) -> Candidate:
    """first: a criterion that may be at most `limit`; second: one to make least. ValueError if none is left."""
    known = [f.name for f in fields(Candidate) if f.name != "parameters"]
    for name in (first, second):
        if name not in known:
            raise ValueError(f"criterion {name!r}; valid: {', '.join(known)}")
    left = [c for c in candidates if getattr(c, first) <= limit]
    if not left:
        least = min((getattr(c, first) for c in candidates), default=float("nan"))
        raise ValueError(f"no candidate has {first} of at most {limit:g}; valid: from {least:g}")
    return min(left, key=lambda c: getattr(c, second))


def rated(
    parameters: Parameters, sound: Judged, faulty: Sequence[tuple[Judged, NDArray[np.float64]]], source: int
) -> Candidate:
    """The rates of a candidate. sound: judged record without a fault. faulty: for each kind of fault the record judged
    during it, and the error of the faulty source, shape (n,), in the unit of the quantity. source: the faulty one."""
    missed = [~judged.faulty[:, source] for judged, _ in faulty]
    largest = [np.abs(error[m]).max(initial=0.0) for m, (_, error) in zip(missed, faulty, strict=True)]
    return Candidate(
        parameters,
        float(sound.faulty[:, source].mean()),
        float(np.mean([m.mean() for m in missed])),
        float(np.mean(largest)),
    )
