"""The threshold of a CUSUM-like statistic at a rate too low to be counted, from the largest values of sound drives.

Run lengths of a CUSUM grow as exp(r h) (Cramer), so the number of drives whose largest statistic M passes h falls
exponentially, as `detectors.empirical` takes it too: with k of the drives above u, mean excess b, in T hours

    rate(h) = k / T exp(-(h - u) / b)          h(rate) = u + b ln(k / (T rate))

u leaves a SHARE of the drives above it; for b the upper end of its one-sided 97.5 % interval, 2 k b / chi2(0.025, 2 k),
is taken. Drives of one record are independent, samples and seconds of one drive are not. Left out: whether the tail
stays as it is; a study counts the alarms of other drives.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import chi2

SHARE = 0.1
LEAST = 5  # drives above u


def threshold_at(largest: Sequence[float], hours: float, rate: float) -> float:
    """largest: M of each drive; hours: of all; rate [1/h]. ValueError for too few drives, or where M is mostly 0."""
    values = np.sort(np.asarray(largest, dtype=np.float64))
    count = int(SHARE * len(values))
    if count < LEAST:
        raise ValueError(f"{len(values)} drives, want at least {round(LEAST / SHARE)}")
    u = float(values[-count - 1])
    excess = float(np.mean(values[-count:] - u))
    if not (u > 0.0 and excess > 0.0):
        raise ValueError(f"the statistic is 0 in all but {count} of {len(values)} drives: it has no tail to speak of")
    upper = 2.0 * count * excess / float(chi2.ppf(0.025, 2 * count))
    return u + upper * float(np.log(max(count / (hours * rate), 1.0)))
