"""What one track of a road makes the front and the rear hub feel, both seen from the rear wheel's place.

Each axle as in `vertical_pressure.chain`: wheel m_us on the strut k + i w c, belt m_b between sidewall c_b and contact
c_r, road height z_r under two cams a footprint l apart, centred on the wheel; and the strut's force F on the body:

    F                                             = (k + i w c) (z_us - z_s)
    (c_b - w^2 m_us) z_us + F                     = c_b z_b
    (c_b + c_r - w^2 m_b) z_b - c_b z_us          = c_r cos(pi f l / v) z_r
    -w^2 z_sf = F_f / m_sf + F_r / m_c            -w^2 z_sr = F_r / m_sr + F_f / m_c

The body is one: a force at one wheel also moves it over the other wheel of that side, m_c. It heaves, pitches and,
since the two tracks of a road have little in common at these frequencies, rolls (`calibration`). So each hub also feels
what the other axle does to the body, a wheelbase earlier or later: a comb over w tau, tau = wheelbase / v, of 5 % at 10
Hz, which two quarter cars do not have. H = -w^2 z_us over the rear wheel's z_r, the front's moved by tau to where the
rear is, times the root of the road's spectrum for G = 1 (`quarter_car.response`, corner of `road_shape`). A car that
gains speed has its front wheel over the same waves at a lower frequency, by `stretch`: 3 % at 10 m/s and 1.2 m/s^2,
which unheeded looks like 6 % of stiffness. Left out: what the other track does, which is noise here and lowers the
coherence.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from estimators.compiled import compiled
from estimators.quarter_car.road_shape import CORNER
from estimators.vertical_pressure.chain import REFERENCE_STIFFNESS, SIDEWALL, Quarter


class Axles(NamedTuple):
    """front, rear: `hub_error` is not used; coupling: 1 / m_c [1/kg]; wheelbase [m]."""

    front: Quarter
    rear: Quarter
    coupling: float
    wheelbase: float


@compiled
def hub_responses(axles, front_stiffness, rear_stiffness, speed, stretch, frequency, out):
    """H of front and rear hub [(m/s^2)/sqrt(Hz m^3/rad)] at frequency (n,) [Hz], into out (2, n). speed [m/s]: of the
    rear wheel; stretch: that of the front wheel on the same road over it."""
    front, rear = axles.front, axles.rear
    corner = CORNER * speed / (2.0 * np.pi)
    cf, cr = SIDEWALL * front_stiffness, SIDEWALL * rear_stiffness
    lf = front.footprint * (front_stiffness / REFERENCE_STIFFNESS) ** -front.softer
    lr = rear.footprint * (rear_stiffness / REFERENCE_STIFFNESS) ** -rear.softer
    for place in range(2 * len(frequency)):
        hub, i = place % 2, place // 2
        f = frequency[i] * (stretch if hub == 0 else 1.0)
        v = speed * (stretch if hub == 0 else 1.0)
        w = 2.0 * np.pi * f
        w2 = w * w
        turn = np.exp(1j * w * axles.wheelbase / v)
        sf, sr = front.spring_rate + 1j * w * front.damping, rear.spring_rate + 1j * w * rear.damping
        bf = cf + cf / (SIDEWALL - 1.0) - w2 * front.belt_mass
        br = cr + cr / (SIDEWALL - 1.0) - w2 * rear.belt_mass
        df = sf + cf - w2 * front.unsprung_mass - cf * cf / bf
        dr = sr + cr - w2 * rear.unsprung_mass - cr * cr / br
        rf = cf * cf / ((SIDEWALL - 1.0) * bf) * np.cos(np.pi * f * lf / v) * turn
        rr = cr * cr / ((SIDEWALL - 1.0) * br) * np.cos(np.pi * f * lr / v)
        # z_us = (r + s z_s) / d, so F = p + q z_s
        pf, pr = sf * rf / df, sr * rr / dr
        qf, qr = sf * (sf / df - 1.0) / w2, sr * (sr / dr - 1.0) / w2
        a, d = 1.0 + qf / front.sprung_mass, 1.0 + qr / rear.sprung_mass
        b, c = qf * axles.coupling, qr * axles.coupling
        det = a * d - b * c
        force_f, force_r = (d * pf - b * pr) / det, (a * pr - c * pf) / det
        scale = -w2 * np.sqrt(speed / (2.0 * np.pi * (frequency[i] ** 2 + corner * corner)))
        if hub == 0:
            zf = -(force_f / front.sprung_mass + axles.coupling * force_r) / w2
            out[0, i] = scale * (rf + sf * zf) / df / turn
        else:
            zr = -(force_r / rear.sprung_mass + axles.coupling * force_f) / w2
            out[1, i] = scale * (rr + sr * zr) / dr
