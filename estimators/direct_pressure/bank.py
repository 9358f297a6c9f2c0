"""A CUSUM for every one of several shifts of the quiet tyre's whitened innovation x: g = max(g - x - shift / 2, 0)."""

from __future__ import annotations

from estimators.compiled import inlined
from estimators.direct_pressure.numbers import CLIP, SHIFTS


@inlined
def take(g, x):
    """A whitened innovation x [std]. g: shape (shifts,)."""
    for i in range(len(g)):
        g[i] = max(g[i] - min(max(x, -CLIP), CLIP) - 0.5 * SHIFTS[i], 0.0)
