"""Vertical tyre law: load against deflection, stiffness, free and effective rolling radius, contact length, drag
moment.

Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 4.3 and 9 and App. 3 (MF 6.1, rigid ring).
With dpi = (p - p0)/p0, f = Fz/Fz0 and rho the total deflection [m]:

    R_Omega = R0 (Q_RE0 + Q_V1 (Omega R0/V0)^2)                                   free radius
    Fz      = A Fz0 [Q_FZ1 rho/R0 + Q_FZ2 (rho/R0)^2]                              A = (1 + Q_V2 |Omega| R0/V0 - fc)
    P(p) P(p)    = 1 + PFZ1 dpi above p0/2; below, straight down to the carcass fraction at p = 0 (the polynomial has no
    meaning there) Re      = R_Omega - Fz0/Cz [DREFF atan(BREFF f) + FREFF f]                     effective rolling
    radius a       = R0 [Q_RA2 f' + Q_RA1 sqrt(f')], f' = Fz/(Cz R0)                      half length of the contact
    patch My      = R0 Fz0 [QSY1 + QSY2 Fx/Fz0 + QSY3 |V/V0| + QSY4 (V/V0)^4] f^QSY7 (p/p0)^QSY8   drag moment

The belt ring sits on the sidewall stiffness c_b; what the contact sees is the residual deflection rho_r = rho - Fz/c_b,
so that ring and residual in series give exactly the law above. Pressures are gauge [Pa].
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from estimators.compiled import inlined
from models.tyre_properties import TyreProperties


class VerticalLaw(NamedTuple):
    """Parameters of the vertical law; SI, gauge pressure. Names as in the Magic Formula property file."""

    r0: float
    p0: float
    fz0: float
    v0: float
    q_fz1: float
    q_fz2: float
    pfz1: float
    carcass_fraction: float
    q_re0: float
    q_v1: float
    q_v2: float
    q_fcx: float
    q_fcy: float
    cz0: float
    breff: float
    dreff: float
    freff: float
    re_pressure_share: float
    q_ra1: float
    q_ra2: float
    qsy1: float
    qsy2: float
    qsy3: float
    qsy4: float
    qsy7: float
    qsy8: float


def vertical_law(tyre: TyreProperties) -> VerticalLaw:
    """The law's parameters of a tyre property set."""
    values = {name: float(getattr(tyre, name)) for name in VerticalLaw._fields if name != "q_fz1"}
    q_fz1 = math.sqrt((tyre.cz0 * tyre.r0 / tyre.fz0) ** 2 - 4.0 * tyre.q_fz2)
    return VerticalLaw(q_fz1=q_fz1, **values)


@inlined
def pressure_factor(law, pressure):
    """Vertical stiffness over its value at p0 [-]; pressure: gauge [Pa]."""
    if pressure >= 0.5 * law.p0:
        return 1.0 + law.pfz1 * (pressure - law.p0) / law.p0
    half = 1.0 - 0.5 * law.pfz1
    return law.carcass_fraction + (half - law.carcass_fraction) * max(pressure, 0.0) / (0.5 * law.p0)


@inlined
def free_radius(law, omega):
    """Radius of the unloaded rolling tyre [m]; omega [rad/s]."""
    return law.r0 * (law.q_re0 + law.q_v1 * (omega * law.r0 / law.v0) ** 2)


@inlined
def load_amplitude(law, factor, omega, fx, fy):
    """A of the load law [-]; factor: pressure_factor; fx, fy [N]."""
    shear = (law.q_fcx * fx / law.fz0) ** 2 + (law.q_fcy * fy / law.fz0) ** 2
    return (1.0 + law.q_v2 * abs(omega) * law.r0 / law.v0 - shear) * factor


@inlined
def load(law, amplitude, deflection):
    """Wheel load [N] at the total deflection [m]; zero off the ground."""
    if deflection <= 0.0:
        return 0.0
    ratio = deflection / law.r0
    return amplitude * law.fz0 * (law.q_fz1 + law.q_fz2 * ratio) * ratio


@inlined
def load_behind_sidewall(law, amplitude, residual, sidewall):
    """Wheel load [N] at the residual deflection [m] of a belt on a sidewall of stiffness `sidewall` [N/m].

    Solves F = a1 (r + F/c) + a2 (r + F/c)^2 for the root that vanishes with r.
    """
    if residual <= 0.0:
        return 0.0
    a1 = amplitude * law.fz0 * law.q_fz1 / law.r0
    a2 = amplitude * law.fz0 * law.q_fz2 / law.r0**2
    b = 1.0 - (a1 + 2.0 * a2 * residual) / sidewall
    c = (a1 + a2 * residual) * residual
    root = math.sqrt(max(b * b - 4.0 * a2 * c / sidewall**2, 0.0))
    return 2.0 * c / (b + root)


@inlined
def stiffness(law, amplitude, fz):
    """dFz/drho [N/m] of the load law at the load fz [N]."""
    scaled = max(fz, 0.0) / law.fz0
    return law.fz0 / law.r0 * math.sqrt((amplitude * law.q_fz1) ** 2 + 4.0 * amplitude * law.q_fz2 * scaled)


@inlined
def deflection(law, amplitude, fz):
    """Total deflection [m] at the load fz [N]: the inverse of `load`."""
    quadratic, linear = amplitude * law.q_fz2, amplitude * law.q_fz1
    return 2.0 * fz / law.fz0 * law.r0 / (linear + math.sqrt(linear**2 + 4.0 * quadratic * fz / law.fz0))


@inlined
def effective_rolling_radius(law, omega, fz, pressure):
    """Re [m]. `re_pressure_share` scales the pressure's part only (real cars move a third to a half of the book
    tyre)."""
    cz = law.cz0 * (1.0 + law.pfz1 * law.re_pressure_share * (max(pressure, 0.0) - law.p0) / law.p0)
    scaled = max(fz, 0.0) / law.fz0
    return free_radius(law, omega) - law.fz0 / cz * (law.dreff * math.atan(law.breff * scaled) + law.freff * scaled)


@inlined
def contact_half_length(law, factor, fz):
    """a [m]; factor: pressure_factor."""
    scaled = max(fz, 0.0) / (law.cz0 * factor * law.r0)
    return law.r0 * (law.q_ra2 * scaled + law.q_ra1 * math.sqrt(scaled))


@inlined
def drag_pressure_factor(law, pressure):
    """(p/p0)^QSY8 [-], frozen below p0/2, where the power law runs away."""
    return (max(pressure, 0.5 * law.p0) / law.p0) ** law.qsy8


@inlined
def drag_moment(law, drag_factor, fz, fx, v_x):
    """Rolling resistance moment, at least zero [N m]; drag_factor: drag_pressure_factor; v_x [m/s]."""
    if fz <= 0.0:
        return 0.0
    v = abs(v_x) / law.v0
    bracket = law.qsy1 + law.qsy2 * fx / law.fz0 + law.qsy3 * v + law.qsy4 * (v * v) * (v * v)
    return law.r0 * law.fz0 * max(bracket, 0.0) * (fz / law.fz0) ** law.qsy7 * drag_factor


def mean_stiffness(law: VerticalLaw, pressure: float, omega: float, fz: float) -> float:
    """dFz/drho [N/m] at a mean load [N], speed [rad/s] and pressure [Pa]: what a table reports."""
    amplitude = load_amplitude(law, pressure_factor(law, pressure), omega, 0.0, 0.0)
    return float(stiffness(law, amplitude, np.float64(fz)))
