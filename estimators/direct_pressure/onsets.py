"""When may a leak have begun, and how fast is it then? The evidence for each of some onsets, and their posterior.

A leak of rate r that began at an onset explains the quiet tyre's innovations by the signature with which it goes
through the filter (Friedland's bias filter, IEEE Trans. Automatic Control 14, 1969): b, the mean of (truth - filter's
state) for a unit rate, follows b- = F b - [dt, 0, 0], s = sum(b-) / sqrt(S), b = b- - K sum(b-). The whitened
innovation is x = s r + noise, so with A = sum s x and B = sum s^2 its likelihood is exp(A r - B r^2 / 2).

Onsets: some within every interval (`PARTS` where a sample is much of a leak), the older the fewer, so that the gap of
two of them is about the same share of their age. Posterior: onset uniform in time, ln r uniform (the one prior that
knows no scale), r > 0: of each onset Laplace's form about its mode, and all of them together by their moments. Taking
the one onset that the CUSUM chose, as if it had been known, gave a std up to 2.5 times too small at the alarm: the
alarm selects the noise that helped it, and the onset.
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import inlined
from estimators.direct_pressure import quiet

MOST = 40  # onsets kept
PARTS, CLOSE = 4, 0.5  # onsets within an interval, of at least so many s; else one
WEAK = 2.5  # std of a rate above 0, below which an onset says nothing

AT, A, B, SIGNATURE, SIZE = 0, 1, 2, 3, 3 + quiet.SIZE


@inlined
def predict(rows, known, keeps, dt, time):
    """One interval on, with the onsets within it; their number. rows: shape (MOST, SIZE), oldest first."""
    for k in range(known):
        for i in range(quiet.SIZE):
            rows[k, SIGNATURE + i] *= keeps[i]
        rows[k, SIGNATURE] -= dt
    parts = PARTS if dt >= CLOSE else 1
    while known > MOST - parts:
        closest, least = 1, np.inf
        for k in range(1, known - 1):
            gap = (rows[k + 1, AT] - rows[k - 1, AT]) / (time - rows[k, AT])
            if gap < least:
                closest, least = k, gap
        for k in range(closest, known - 1):
            rows[k] = rows[k + 1]
        known -= 1
    for part in range(parts):
        age = dt * (parts - part - 0.5) / parts
        rows[known] = 0.0
        rows[known, AT], rows[known, SIGNATURE] = time - age, -age
        known += 1
    return known


@inlined
def take(rows, known, x, gain, total):
    """A whitened innovation x [std]; gains 0 if the filter does not follow it; total: variance before whitening."""
    scale = 1.0 / total**0.5
    for k in range(known):
        seen = rows[k, SIGNATURE] + rows[k, SIGNATURE + 1] + rows[k, SIGNATURE + 2]
        rows[k, A] += scale * seen * x
        rows[k, B] += scale * scale * seen * seen
        for i in range(quiet.SIZE):
            rows[k, SIGNATURE + i] -= gain[i] * seen


@inlined
def posterior(rows, known, time, gauge, mean, second):
    """The onset's mean [s]. Fills the moments of the loss [a, e, l, r] as `leak.start_from` takes them: r at `time`
    [s], after it died out with the gauge pressure [Pa] for as long as it is old."""
    mean[:], second[:] = 0.0, 0.0
    best = -np.inf
    for k in range(known):
        best = max(best, rows[k, A] ** 2 / max(rows[k, B], 1e-300) if rows[k, A] > 0.0 else 0.0)
    whole, began = 0.0, 0.0
    for k in range(known):
        a, b = rows[k, A], rows[k, B]
        if b <= 0.0 or a < WEAK * b**0.5:
            continue
        centre, variance = a / b, 1.0 / b
        rate = 0.5 * (centre + (centre * centre - 4.0 * variance) ** 0.5)
        spread = 1.0 / (b - 1.0 / rate**2)
        left = np.exp(-0.5 * rate * (time - rows[k, AT]) / gauge)  # of the mean rate since then
        before, after = rows[max(k - 1, 0), AT], rows[min(k + 1, known - 1), AT]
        weight = (after - before) * np.exp(a * rate - 0.5 * b * rate**2 - 0.5 * best) * spread**0.5 / rate
        whole += weight
        began += weight * rows[k, AT]
        for i in range(quiet.SIZE + 1):
            b_i = rows[k, SIGNATURE + i] if i < quiet.SIZE else left
            mean[i] += weight * b_i * rate
            for j in range(quiet.SIZE + 1):
                b_j = rows[k, SIGNATURE + j] if j < quiet.SIZE else left
                second[i, j] += weight * b_i * b_j * (rate**2 + spread)
    if whole > 0.0:
        mean /= whole
        second /= whole
        began /= whole
    return began
