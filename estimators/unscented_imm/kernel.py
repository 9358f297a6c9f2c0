"""The compiled unscented filter of one mode: sigma points, prediction, update, and a covariance that stays definite.

Arithmetic of `reference`, for n = 5 (road given) or 6 (road a state) states; only the lower triangles of covariances
are kept up. What cannot be used is left out: a measured value that is not finite or beyond `PLAUSIBLE` is missing, and
the update takes what is left. Whatever comes, afterwards the state lies within `LIMITS` and its covariance has a
Cholesky factor; each repair is counted. On ordinary input nothing is repaired.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled, inlined
from estimators.quarter_car.quarter_car import QuarterCar, accelerations

PLAUSIBLE = 2e3  # m/s^2: beyond any accelerometer of a car
LOWEST = np.array([-1e3, -1e3, -1e2, -1e2, 1e4, -1e3])  # m, m, m/s, m/s, N/m, m
HIGHEST = np.array([1e3, 1e3, 1e2, 1e2, 2e6, 1e3])
LARGEST = np.array([1e2, 1e2, 1e2, 1e2, 1e6, 1e2])  # std
SMALLEST = 1e-9  # std over the starting std
LOG_2PI = math.log(2.0 * math.pi)


@inlined
def factorised(P, L, n):
    """Lower Cholesky factor of P into L; False if there is none."""
    for j in range(n):
        for i in range(j, n):
            total = P[i, j]
            for k in range(j):
                total -= L[i, k] * L[j, k]
            if i == j:
                if not (total > 0.0 and total < np.inf):
                    return False
                L[j, j] = math.sqrt(total)
            else:
                L[i, j] = total / L[j, j]
    return True


@inlined
def secured(x, P, L, start, start_variance, n):
    """Makes state and covariance usable, with its factor in L; the number of repairs."""
    repairs = 0
    for i in range(n):
        if not (x[i] >= LOWEST[i] and x[i] <= HIGHEST[i]):
            x[i] = min(max(x[i], LOWEST[i]), HIGHEST[i]) if math.isfinite(x[i]) else start[i]
            repairs += 1
    sound = True
    for i in range(n):
        least, largest = SMALLEST * SMALLEST * start_variance[i], LARGEST[i] * LARGEST[i]
        if not (P[i, i] >= least and P[i, i] <= largest):
            sound = False
            P[i, i] = min(max(P[i, i], least), largest) if math.isfinite(P[i, i]) else start_variance[i]
    if sound and factorised(P, L, n):
        return repairs
    for i in range(n):  # correlations are given up, variances stay
        for j in range(i):
            P[i, j] = 0.0
    factorised(P, L, n)
    return repairs + 1


@inlined
def moments(points, weights_mean, weights_covariance, added, x, P, n):
    """Mean and lower covariance of the sigma points (2 n + 1, n), plus variances `added` (n,), into x and P."""
    count = 2 * n + 1
    for i in range(n):
        x[i] = 0.0
        for s in range(count):
            x[i] += weights_mean[s] * points[s, i]
    for s in range(count):
        for i in range(n):
            points[s, i] -= x[i]
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for s in range(count):
                total += weights_covariance[s] * points[s, i] * points[s, j]
            P[i, j] = total
        P[i, i] += added[i]


@inlined
def spread_points(x, L, reach, points, n):
    """Sigma points x, x +- sqrt(n + lambda) column of L, into points (2 n + 1, n)."""
    for i in range(n):
        points[0, i] = x[i]
        for k in range(n):
            step = reach * L[i, k] if k <= i else 0.0
            points[1 + k, i] = x[i] + step
            points[1 + n + k, i] = x[i] - step


@inlined
def predict(q, phi, added, dt, road, x, P, L, points, weights_mean, weights_covariance, reach, n):
    """One forward Euler step of state and covariance, whose factor is in L."""
    spread_points(x, L, reach, points, n)
    for s in range(2 * n + 1):
        p = points[s]
        height = p[5] if n == 6 else road
        a_s, a_us = accelerations(q, p[0], p[1], p[2], p[3], p[4], height)
        p[0] += dt * p[2]
        p[1] += dt * p[3]
        p[2] += dt * a_s
        p[3] += dt * a_us
        if n == 6:
            p[5] *= phi
    moments(points, weights_mean, weights_covariance, added, x, P, n)


@inlined
def update(q, road, measured, noise, x, P, L, points, felt, cross, weights_mean, weights_covariance, reach, n):
    """Takes [a_s, a_us] (2,), either may be missing; the log-likelihood of what was there. P's factor is in L."""
    has_s = abs(measured[0]) <= PLAUSIBLE  # False for NaN too
    has_us = abs(measured[1]) <= PLAUSIBLE
    if not (has_s or has_us):
        return 0.0
    count = 2 * n + 1
    spread_points(x, L, reach, points, n)
    mean_s = mean_us = 0.0
    for s in range(count):
        p = points[s]
        height = p[5] if n == 6 else road
        felt[s, 0], felt[s, 1] = accelerations(q, p[0], p[1], p[2], p[3], p[4], height)
        mean_s += weights_mean[s] * felt[s, 0]
        mean_us += weights_mean[s] * felt[s, 1]
    s00, s01, s11 = noise[0], 0.0, noise[1]
    for i in range(n):
        cross[i, 0] = cross[i, 1] = 0.0
    for s in range(count):
        d0, d1, w = felt[s, 0] - mean_s, felt[s, 1] - mean_us, weights_covariance[s]
        s00 += w * d0 * d0
        s01 += w * d0 * d1
        s11 += w * d1 * d1
        for i in range(n):
            off = w * (points[s, i] - x[i])
            cross[i, 0] += off * d0
            cross[i, 1] += off * d1
    nu0, nu1 = measured[0] - mean_s, measured[1] - mean_us
    if not has_us:
        return _take_one(nu0, s00, cross, 0, x, P, n)
    if not has_s:
        return _take_one(nu1, s11, cross, 1, x, P, n)
    determinant = s00 * s11 - s01 * s01
    i00, i01, i11 = s11 / determinant, -s01 / determinant, s00 / determinant
    for i in range(n):
        g0, g1 = cross[i, 0] * i00 + cross[i, 1] * i01, cross[i, 0] * i01 + cross[i, 1] * i11
        x[i] += g0 * nu0 + g1 * nu1
        for j in range(i + 1):
            P[i, j] -= g0 * cross[j, 0] + g1 * cross[j, 1]
    distance = nu0 * nu0 * i00 + 2.0 * nu0 * nu1 * i01 + nu1 * nu1 * i11
    return -0.5 * (distance + math.log(determinant)) - LOG_2PI


@inlined
def _take_one(nu, variance, cross, column, x, P, n):
    for i in range(n):
        gain = cross[i, column] / variance
        x[i] += gain * nu
        for j in range(i + 1):
            P[i, j] -= gain * cross[j, column]
    return -0.5 * (nu * nu / variance + math.log(variance) + LOG_2PI)


@compiled
def quarter_of(row):
    """QuarterCar of its six numbers (6,)."""
    return QuarterCar(row[0], row[1], row[2], row[3], row[4], row[5])
