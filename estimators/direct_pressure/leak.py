"""A tyre that may leak: Kalman filter on [a, r, e], whose states are the estimates.

    a  pressure at the reference temperature [Pa], da/dt = -r
    r  leak rate at the reference temperature [Pa/s], > 0 for a loss; random walk, and through an orifice it dies out
       with the gauge pressure p:  dr/dt = -r^2 / p
    e  as in the quiet tyre
At the alarm it starts anew from the loss that the alarm's CUSUM saw (`bank`).
"""

from __future__ import annotations

import numpy as np

from estimators.compiled import inlined
from estimators.direct_pressure import bank, quiet

A, R, E, AA, AR, AE, RR, RE, EE, SIZE = range(10)


@inlined
def start(x, z, variance, disturbance, rate_variance):
    """Before anything is known but a sample z."""
    x[:] = 0.0
    x[A], x[AA], x[RR], x[EE] = z, variance, rate_variance, disturbance**2


@inlined
def start_from(x, q, row):
    """From the quiet tyre's state q and a CUSUM's loss: x = q + b loss, P = P_q + b cov b'."""
    offset, rate, oo, both, rr = bank.loss(row)
    ao, ar, eo, er = row[bank.OFFSET_A], row[bank.RATE_A], row[bank.OFFSET_E], row[bank.RATE_E]
    x[A] = q[quiet.A] + ao * offset + ar * rate
    x[E] = q[quiet.E] + eo * offset + er * rate
    x[R] = rate
    x[AA] = q[quiet.AA] + ao * ao * oo + 2.0 * ao * ar * both + ar * ar * rr
    x[AE] = q[quiet.AE] + ao * eo * oo + (ao * er + ar * eo) * both + ar * er * rr
    x[EE] = q[quiet.EE] + eo * eo * oo + 2.0 * eo * er * both + er * er * rr
    x[AR], x[RE], x[RR] = ao * both + ar * rr, eo * both + er * rr, rr


@inlined
def predict(x, dt, keeps, wander, disturbance, rate_wander, gauge):
    """dt [s] on; wander, rate_wander: variances gained in that time; gauge: pressure that drives the leak [Pa]."""
    dies = np.exp(-max(x[R], 0.0) * dt / gauge)
    x[A] -= dt * x[R]
    x[R] *= dies
    x[E] *= keeps
    x[AA] += dt * (dt * x[RR] - 2.0 * x[AR]) + wander + rate_wander * dt * dt / 3.0
    x[AR] = dies * (x[AR] - dt * x[RR]) - rate_wander * dt / 2.0
    x[AE] = keeps * (x[AE] - dt * x[RE])
    x[RR] = dies * dies * x[RR] + rate_wander
    x[RE] *= dies * keeps
    x[EE] = keeps * keeps * x[EE] + (1.0 - keeps * keeps) * disturbance**2


@inlined
def correct(x, z, r):
    """Takes a sample z [Pa] of variance r."""
    row_a, row_r, row_e = x[AA] + x[AE], x[AR] + x[RE], x[AE] + x[EE]
    total = row_a + row_e + r
    miss = (z - x[A] - x[E]) / total
    x[A] += row_a * miss
    x[R] += row_r * miss
    x[E] += row_e * miss
    x[AA] -= row_a * row_a / total
    x[AR] -= row_a * row_r / total
    x[AE] -= row_a * row_e / total
    x[RR] -= row_r * row_r / total
    x[RE] -= row_r * row_e / total
    x[EE] -= row_e * row_e / total
