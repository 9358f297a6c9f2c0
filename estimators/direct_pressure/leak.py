"""A tyre that may leak: Kalman filter on [a, e, l, r], whose states are the estimates.

    a, e, l  as in the quiet tyre, but da/dt = -r
    r        leak rate at the reference temperature [Pa/s], > 0 for a loss; random walk, and through an orifice it dies
             out with the gauge pressure p:  dr/dt = -r^2 / p
At the alarm it starts anew from what the `onsets` say. State: shape (4, 5), as in `quiet`.
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import inlined
from estimators.direct_pressure import quiet
from estimators.direct_pressure.quiet import A, E, L

R, SIZE = 3, 4
SHAPE = (SIZE, SIZE + 1)


@inlined
def start(x, z, variance, disturbance, rate_variance):
    """Before anything is known but a sample z."""
    x[:] = 0.0
    x[A, 0], x[A, 1 + A], x[E, 1 + E], x[R, 1 + R] = z, variance, disturbance**2, rate_variance


@inlined
def start_from(x, q, mean, second):
    """From the quiet tyre's state q and a loss: first moments of [a, e, l, r] beyond q, shape (4,), and second ones,
    shape (4, 4)."""
    for i in range(SIZE):
        x[i, 0] = mean[i]
        for j in range(SIZE):
            x[i, 1 + j] = second[i, j] - mean[i] * mean[j]
    for i in range(quiet.SIZE):
        x[i, 0] += q[i, 0]
        for j in range(quiet.SIZE):
            x[i, 1 + j] += q[i, 1 + j]


@inlined
def jump(x, z, variance, rate_variance):
    """A new level z, whatever was thought of it; the rate may have changed too."""
    for i in range(SIZE):
        x[A, 1 + i] = x[i, 1 + A] = 0.0
    x[A, 0], x[A, 1 + A] = z - x[E, 0] - x[L, 0], variance + x[E, 1 + E] + x[L, 1 + L]
    x[R, 1 + R] += rate_variance


@inlined
def predict(x, dt, keeps, gained, rate_wander, gauge):
    """dt [s] on; keeps, gained: as in `quiet`; rate_wander: variance that r gains [Pa^2/s^2]; gauge: pressure that
    drives the leak [Pa]."""
    share = max(x[R, 0], 0.0) * dt / gauge  # of the gauge pressure that is lost, were the rate to last
    dies = np.exp(-share)
    x[A, 0] -= gauge * (1.0 - dies) if share > 1e-6 else dt * x[R, 0]
    x[R, 0] *= dies
    for j in range(SIZE):
        x[A, 1 + j] -= dt * dies * x[R, 1 + j]
    for i in range(SIZE):
        x[i, 1 + A] -= dt * dies * x[i, 1 + R]
    for i in range(SIZE):
        if i < R:
            x[i, 0] *= keeps[i]
        kept = keeps[i] if i < R else dies * (1.0 - share)
        for j in range(SIZE):
            x[i, 1 + j] *= kept
            x[j, 1 + i] *= kept
    for i in range(quiet.SIZE):
        x[i, 1 + i] += gained[i]
    x[A, 1 + A] += rate_wander * dt * dt / 3.0
    x[A, 1 + R] -= rate_wander * dt / 2.0
    x[R, 1 + A] = x[A, 1 + R]
    x[R, 1 + R] += rate_wander


@inlined
def level(x):
    """What a sample should be at the reference temperature [Pa], and the variance of that [Pa^2]."""
    variance = 0.0
    for i in range(quiet.SIZE):
        variance += x[i, 1 + A] + x[i, 1 + E] + x[i, 1 + L]
    return x[A, 0] + x[E, 0] + x[L, 0], max(variance, 0.0)


@inlined
def correct(x, z, r, row):
    """Takes a sample z [Pa] of variance r. row: scratch of shape (4,)."""
    expected, variance = level(x)
    total = variance + r
    for i in range(SIZE):
        row[i] = x[i, 1 + A] + x[i, 1 + E] + x[i, 1 + L]
    for i in range(SIZE):
        x[i, 0] += row[i] / total * (z - expected)
        for j in range(SIZE):
            x[i, 1 + j] -= row[i] * row[j] / total
