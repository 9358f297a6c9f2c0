"""Steady linear filters over decimated hub accelerations, and how likely the samples are to them.

With nu the innovation and S its variance for a level G0 (model error in proportion to the level), a level lambda G0
makes N samples of log-likelihood -(s / lambda + N ln lambda + N ln S) / 2, where s = sum nu^2 / S, as long as the
sensor's own noise is small: so each filter tells of all levels near its own, and the level is continuous.

The body's acceleration is not used. Beside the hub's it tells next to nothing of the stiffness: without it the bound
for unknown level rises from 5.49 to 5.52 % (10 s, 36 Hz); and on a car it is no quarter car's: the other axle rolls
over the same road a wheelbase later, which makes a comb of 0.5 to 2.3 times the quarter car's spectrum, and that moved
the estimate by 3 to 5 % with speed.
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import compiled, inlined
from estimators.vertical_pressure.chain import continuous, sampled
from estimators.vertical_pressure.riccati import steady_filter

ERROR_UNIT = 1e6 / 16.7  # of hub_error: (m/s^2)^2 for G = 1 m^3/rad and each m/s: about what the hub's innovation has


@inlined
def step(A, c, K, x, scratch, measured):
    """Takes a sample [m/s^2], moves x (n,) on; the innovation."""
    n = x.shape[0]
    nu = measured
    for i in range(n):
        nu -= c[i] * x[i]
    for i in range(n):
        scratch[i] = x[i] + K[i] * nu
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += A[i, j] * scratch[j]
        x[i] = total
    return nu


@compiled
def filter_from(A, c, Q, speed, hub_error, level, sensor_variance):
    """(K (n,), S) for G = level [m^3/rad], S in units of that level; sensor_variance: of a decimated sample."""
    R = np.array([[hub_error * ERROR_UNIT * speed + sensor_variance / level]])
    K, S = steady_filter(A, c.reshape(1, -1).copy(), Q, R)
    return K[:, 0].copy(), S[0, 0]


@compiled
def filter_of(quarter, tyre_stiffness, speed, level, sensor_variance, low, dt):
    """(A, c, K, S) of the steady filter of one quarter car, stiffness [N/m], speed [m/s] and level."""
    M, b, C = continuous(quarter, tyre_stiffness, speed, low[0], low[1], low[2])
    A, Q = sampled(M, b, dt)
    c = C[1].copy()
    K, S = filter_from(A, c, Q, speed, quarter.hub_error, level, sensor_variance)
    return A, c, K, S


@compiled
def squares(A, c, K, S, samples):
    """nu^2 / S of every sample (n,), begun at rest."""
    x, scratch, out = np.zeros(A.shape[0]), np.empty(A.shape[0]), np.empty(len(samples))
    for t in range(len(samples)):
        nu = step(A, c, K, x, scratch, samples[t])
        out[t] = nu * nu / S
    return out
