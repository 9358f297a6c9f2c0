"""A tyre without a leak: Kalman filter on [a, e], whose whitened innovation is what the alarm watches.

a  pressure at the reference temperature [Pa]: random walk
e  what the temperature leaves over [Pa]: Gauss-Markov, e = exp(-dt / tau) e + w
z = a + e + v,  v of variance r, measured (`noise`)
"""

from __future__ import annotations

from estimators.compiled import inlined

A, E, AA, AE, EE, SIZE = range(6)


@inlined
def start(q, z, variance, disturbance):
    """Before anything is known of the tyre but a sample z."""
    q[A], q[E], q[AA], q[AE], q[EE] = z, 0.0, variance, 0.0, disturbance**2


@inlined
def predict(q, keeps, wander, disturbance):
    """keeps: exp(-dt / tau); wander: variance that a gains [Pa^2]; disturbance: std of e [Pa]."""
    q[E] *= keeps
    q[AA] += wander
    q[AE] *= keeps
    q[EE] = keeps * keeps * q[EE] + (1.0 - keeps * keeps) * disturbance**2


@inlined
def gains(q, r):
    """Gains of a and e, variance of the innovation."""
    total = q[AA] + 2.0 * q[AE] + q[EE] + r
    return (q[AA] + q[AE]) / total, (q[AE] + q[EE]) / total, total


@inlined
def correct(q, innovation, gain_a, gain_e):
    """Takes an innovation [Pa]."""
    row_a, row_e = q[AA] + q[AE], q[AE] + q[EE]
    q[A] += gain_a * innovation
    q[E] += gain_e * innovation
    q[AA] -= gain_a * row_a
    q[AE] -= gain_a * row_e
    q[EE] -= gain_e * row_e
