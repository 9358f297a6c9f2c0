"""A tyre's telegrams to one value a day: the median of what was news on that day.

Left out of it: what is not finite or no tyre's pressure, and a value that has been repeated without a change for
`STALE` (a parked vehicle that sends its last value again, or a stuck sensor: one that never changes again has no days
any more). The median takes single wrong values and warm hours. A sample counts for the day of its own time stamp,
however late it came; days are those of the time stamp's clock (UTC).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.slow_leak.numbers import DAY, HIGHEST, LEAST_SAMPLES, LOWEST, STALE

FARTHEST = 4e9  # s, time stamps beyond it either way are none


@dataclass(frozen=True, eq=False)
class Days:
    """day: number since the clock's zero, rising, shape (n,); pressure: [Pa], shape (n,). refused: samples that were
    not finite or no tyre's pressure; stale: repeated for too long."""

    day: NDArray[np.int64]
    pressure: NDArray[np.float64]
    refused: int
    stale: int


def days_of(time: ArrayLike, pressure: ArrayLike) -> Days:
    """Of samples at `time` [s] in any order, gauge pressures [Pa] (at one temperature), both of shape (n,).

    ValueError for other shapes.
    """
    stamps, values = np.asarray(time, dtype=np.float64), np.asarray(pressure, dtype=np.float64)
    if stamps.ndim != 1 or stamps.shape != values.shape:
        raise ValueError(f"time has shape {stamps.shape} beside pressure {values.shape}, valid: (n,) both")
    with np.errstate(invalid="ignore"):
        good = (np.abs(stamps) < FARTHEST) & (values >= LOWEST) & (values <= HIGHEST)
    order = np.lexsort((values[good], stamps[good]))  # of equal stamps by value: the order given says nothing
    t, p = stamps[good][order], values[good][order]
    fresh = _fresh(t, p)
    day = np.floor(t[fresh] / DAY).astype(np.int64)
    found, first, count = np.unique(day, return_index=True, return_counts=True)
    enough = count >= LEAST_SAMPLES
    medians = [np.median(p[fresh][i : i + n]) for i, n in zip(first[enough], count[enough], strict=True)]
    return Days(found[enough], np.array(medians, dtype=np.float64), int((~good).sum()), int((~fresh).sum()))


def _fresh(t: NDArray[np.float64], p: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether the value is still news: changed less than `STALE` ago."""
    if len(t) == 0:
        return np.zeros(0, dtype=np.bool_)
    changed = np.concatenate([[True], np.diff(p) != 0.0])
    since = t[np.maximum.accumulate(np.where(changed, np.arange(len(t)), 0))]
    return t - since < STALE


def together(tyres: list[Days]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Days on which any tyre has a value, shape (n,), and pressures [Pa], shape (n, tyres), NaN where one has none."""
    every = np.unique(np.concatenate([t.day for t in tyres])) if tyres else np.empty(0, dtype=np.int64)
    table = np.full((len(every), len(tyres)), np.nan)
    for column, tyre in enumerate(tyres):
        table[np.searchsorted(every, tyre.day), column] = tyre.pressure
    return every, table
