"""From white noise to the two accelerometers, as one linear system: what a bank's filter assumes of car and road.

    white noise -> road height -> tyre's footprint -> anti-alias filter -> linear quarter car -> [a_s, a_us]

State [z_s, z_us, v_s, v_us, z_b, v_b, z_r, f1, f2, low-pass states] (m, m/s). The quarter car as in `quarter_car`
without k3, c2; its tyre is a belt of mass m_b between a sidewall of stiffness c_b = `SIDEWALL` k_t and the contact's
c_r, k_t = c_b c_r / (c_b + c_r): near 80 Hz the belt resonates, which at 35 Hz is a fifth of what the hub feels. Road:
slope -2 to its longest waves, q = pi v G (`road_shape`), behind the intake's first-order high-pass, which makes of an
integral of white noise a first-order low-pass: dz_r/dt = -2 pi f_h z_r + sqrt(q) w. With the published corner at 50 m
in its place a real road has up to 1.6 times the expected power below 1 Hz, and k_t came out 2 % low, 4 % at 96 km/h. G
= 1 here, levels scale it. Footprint: the height that counts is the mean of two cams (Pacejka, Tire and Vehicle
Dynamics, 3rd ed., ch. 10.1.6) a length l apart, (1 + e^(-s tau)) / 2 with tau = l / v, by the second-order Pade form of
the delay: (1 + s^2 tau^2/12) / (1 + s tau/2 + s^2 tau^2/12); a softer tyre's is longer, l ~ k_t^-softer. The anti-alias
filter stands before the car instead of behind the sensors: for linear systems the same, and so the model's spectrum at
the decimated rate is that of the filtered signal, without an alias of its own. Sampled exactly. Left out: tyre damping,
the other three corners, whose part in a_s is noise in proportion to the road's level.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from estimators.compiled import compiled
from estimators.vertical_pressure.anti_alias import HIGH_PASS

Z_B, V_B, ROAD, FOOT = 4, 5, 6, 7  # places of z_b, v_b, z_r and f1
FIRST_LOW_PASS = 9
SIDEWALL = 8.0  # c_b / k_t. Declared: a belt of 9 kg at 77 Hz on its sidewall
REFERENCE_STIFFNESS = 250e3  # N/m at which l is stated
_TERMS = 13  # of the series: 0.5^13 / 13! is below rounding


class Quarter(NamedTuple):
    """What is identified of a corner: m_s, m_us without the belt, m_b [kg], k [N/m], c [N s/m], footprint l [m] and
    how it grows for softer tyres [-]; hub_error: variance of what the model does not explain in a_us, in proportion to
    level and speed, over `innovations.ERROR_UNIT`."""

    sprung_mass: float
    unsprung_mass: float
    belt_mass: float
    spring_rate: float
    damping: float
    footprint: float
    softer: float
    hub_error: float


@compiled
def continuous(quarter, tyre_stiffness, speed, low_A, low_B, low_C):
    """(A (n, n), b (n,), C (2, n)): dx/dt = A x + b w for G = 1, [a_s, a_us] = C x. low_*: the low-pass filter."""
    order = low_A.shape[0]
    n = FIRST_LOW_PASS + order
    A, b, C = np.zeros((n, n)), np.zeros(n), np.zeros((2, n))
    k, c = quarter.spring_rate, quarter.damping
    sidewall, contact = SIDEWALL * tyre_stiffness, SIDEWALL / (SIDEWALL - 1.0) * tyre_stiffness
    C[0, :4] = np.array([-k, k, -c, c]) / quarter.sprung_mass
    C[1, :4] = np.array([k, -k - sidewall, c, -c]) / quarter.unsprung_mass
    C[1, Z_B] = sidewall / quarter.unsprung_mass
    A[0, 2] = A[1, 3] = A[Z_B, V_B] = 1.0
    A[2], A[3] = C[0], C[1]
    A[V_B, 1], A[V_B, Z_B] = sidewall / quarter.belt_mass, -(sidewall + contact) / quarter.belt_mass
    A[V_B, FIRST_LOW_PASS:] = low_C * contact / quarter.belt_mass
    A[ROAD, ROAD] = -2.0 * np.pi * HIGH_PASS
    b[ROAD] = np.sqrt(np.pi * speed)
    tau = quarter.footprint * (tyre_stiffness / REFERENCE_STIFFNESS) ** -quarter.softer / speed
    A[FOOT, FOOT + 1] = 1.0
    A[FOOT + 1, ROAD], A[FOOT + 1, FOOT], A[FOOT + 1, FOOT + 1] = 12.0 / tau**2, -12.0 / tau**2, -6.0 / tau
    A[FIRST_LOW_PASS:, FIRST_LOW_PASS:] = low_A
    A[FIRST_LOW_PASS:, ROAD] = low_B
    A[FIRST_LOW_PASS:, FOOT + 1] = -0.5 * tau * low_B
    return A, b, C


@compiled
def sampled(A, b, dt):
    """(exp(A dt), covariance that white noise through b adds in a step dt [s]), each (n, n).

    Both by their Taylor series for a step so short that they converge at once, then doubled: Phi(2h) = Phi(h)^2,
    Q(2h) = Q(h) + Phi(h) Q(h) Phi(h)', which no stiff state can spoil.
    """
    n = A.shape[0]
    norm = np.abs(A).sum(axis=0).max() * dt
    doublings = max(int(np.ceil(np.log2(norm / 0.5))), 0)
    h = dt / 2.0**doublings
    transition, term = np.eye(n), np.eye(n)
    terms = np.empty((_TERMS, n))
    for k in range(_TERMS):
        terms[k] = term @ b
        term = term @ A * (h / (k + 1.0))
        transition += term
    added = np.zeros((n, n))
    for j in range(_TERMS):
        for k in range(_TERMS):
            added += np.outer(terms[j], terms[k]) * (h / (j + k + 1.0))
    for _ in range(doublings):
        added = added + transition @ added @ transition.T
        transition = transition @ transition
    return transition, 0.5 * (added + added.T)
