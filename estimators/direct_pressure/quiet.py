"""A tyre without a leak: Kalman filter on [a, e, l], whose whitened innovation is what the alarm watches.

a  pressure at the reference temperature [Pa]: random walk
e  what the temperature leaves over [Pa]: Gauss-Markov, e = exp(-dt / tau) e + w
l  what a change of load adds [Pa]: the same, but its time goes on only while the car stands (`standing`)
z = a + e + l + v,  v of variance r, measured (`noise`)

State: shape (3, 4), for each component its value and its row of the covariance.
"""

from __future__ import annotations

from estimators.compiled import inlined

A, E, L, SIZE = range(4)
SHAPE = (SIZE, SIZE + 1)


@inlined
def start(q, z, variance, disturbance):
    """Before anything is known of the tyre but a sample z; the load is what it then is."""
    q[:] = 0.0
    q[A, 0], q[A, 1 + A], q[E, 1 + E] = z, variance, disturbance**2


@inlined
def predict(q, keeps, gained):
    """keeps: what each component keeps of itself; gained: variance that each gains [Pa^2]."""
    for i in range(SIZE):
        q[i, 0] *= keeps[i]
        for j in range(SIZE):
            q[i, 1 + j] *= keeps[i] * keeps[j]
        q[i, 1 + i] += gained[i]


@inlined
def gains(q, r):
    """Gains of a, e and l, variance of the innovation."""
    of_a = q[A, 1 + A] + q[A, 1 + E] + q[A, 1 + L]
    of_e = q[E, 1 + A] + q[E, 1 + E] + q[E, 1 + L]
    of_l = q[L, 1 + A] + q[L, 1 + E] + q[L, 1 + L]
    total = of_a + of_e + of_l + r
    return (of_a / total, of_e / total, of_l / total), total


@inlined
def correct(q, innovation, gain, total):
    """Takes an innovation [Pa] of variance `total`."""
    for i in range(SIZE):
        q[i, 0] += gain[i] * innovation
        for j in range(SIZE):
            q[i, 1 + j] -= gain[i] * gain[j] * total
