"""A CUSUM for every one of several shifts, and the leak rate that each of them sees.

CUSUM on the whitened innovation x of the quiet tyre, g = max(g - x - shift / 2, 0); alarm above its threshold.

Since g last was 0 a loss [offset, rate] explains the innovations, by the signature with which each goes through the
filter (Friedland's bias filter, IEEE Trans. Automatic Control 14, 1969): b, the mean of (truth - filter's state) for a
unit loss, follows b- = F b - [dt, 0] (rate only), s = (b_a + b_e) / sqrt(S), b = (1 - K H) b-. With A = sum s x and
B = sum s s' the loss is B^-1 A, its covariance B^-1. The offset stands for a leak that began before or after that
moment; its prior is OFFSET, and what a leak from any moment of an interval makes of it.
"""

from __future__ import annotations

from estimators.compiled import inlined
from estimators.direct_pressure.numbers import CLIP, SHIFTS

OFFSET = 2e4  # Pa, std before anything is seen, and 0.3 intervals of
FASTEST = 2e4  # Pa/s, the same of the rate

G, SINCE, OFFSET_A, OFFSET_E, RATE_A, RATE_E, A_OFFSET, A_RATE, B_OO, B_OR, B_RR, SIZE = range(12)


@inlined
def begin(row, time, interval):
    """A CUSUM at 0 since `time` [s], samples coming every `interval` [s]."""
    row[:] = 0.0
    row[SINCE], row[OFFSET_A], row[B_OO], row[B_RR] = (
        time,
        -1.0,
        1.0 / (OFFSET**2 + (0.3 * FASTEST * interval) ** 2),
        FASTEST**-2,
    )


@inlined
def predict(bank, keeps, dt):
    """The signatures one interval on."""
    for row in bank:
        row[OFFSET_E] *= keeps
        row[RATE_E] *= keeps
        row[RATE_A] -= dt


@inlined
def take(bank, x, time, interval, gain_a, gain_e, total):
    """A whitened innovation x [std]; gains 0 if the filter does not follow it."""
    scale = 1.0 / total**0.5
    for i, row in enumerate(bank):
        row[G] += -min(max(x, -CLIP), CLIP) - 0.5 * SHIFTS[i]
        if row[G] <= 0.0:
            begin(row, time, interval)
            continue
        offset, rate = row[OFFSET_A] + row[OFFSET_E], row[RATE_A] + row[RATE_E]
        s_offset, s_rate = scale * offset, scale * rate
        row[A_OFFSET] += s_offset * x
        row[A_RATE] += s_rate * x
        row[B_OO] += s_offset * s_offset
        row[B_OR] += s_offset * s_rate
        row[B_RR] += s_rate * s_rate
        row[OFFSET_A] -= gain_a * offset
        row[OFFSET_E] -= gain_e * offset
        row[RATE_A] -= gain_a * rate
        row[RATE_E] -= gain_e * rate


@inlined
def loss(row):
    """(offset [Pa], rate [Pa/s], their variances and covariance) that one CUSUM sees."""
    determinant = row[B_OO] * row[B_RR] - row[B_OR] ** 2
    oo, rr, both = row[B_RR] / determinant, row[B_OO] / determinant, -row[B_OR] / determinant
    return oo * row[A_OFFSET] + both * row[A_RATE], both * row[A_OFFSET] + rr * row[A_RATE], oo, both, rr
