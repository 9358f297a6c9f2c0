"""Magic Formula 6.1, written out equation by equation: the slow twin of magic_formula.slip_forces.

Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 4.3.2, the equation's number behind each line; symbols are the book's.
Signs, inputs and the treatment outside the measured range are those of magic_formula; its shared limits are imported.
Parameters are read from the property set by name, with no array between: an index that is wrong there shows here.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

from models.tyre_properties import TyreProperties
from testbed.tyre.magic_formula import FADE_SPEED, FLOOR, LARGEST_ANGLE, LARGEST_DFZ, SMALLEST_FRICTION, SMALLEST_LOAD

atan, cos, sin, sqrt, exp = math.atan, math.cos, math.sin, math.sqrt, math.exp


def _sign(x: float) -> float:
    return math.copysign(1.0, x)


def _operating_point(T: TyreProperties, kappa, tan_alpha, gamma, Fz, p, v_x, mu, side) -> SimpleNamespace:
    """The tyre's own inputs: seen in its rolling direction and on the side it was measured on."""
    o = SimpleNamespace()
    o.direction = 1.0 if v_x >= 0.0 else -1.0
    o.kappa = o.direction * kappa
    o.alpha_s = o.direction * side * tan_alpha  # alpha* = tan alpha (4.E3)
    o.gamma = o.direction * side * gamma
    o.gamma_s = sin(o.gamma)  # gamma* (4.E4)
    o.Fz = Fz
    o.dfz = min((Fz - T.fz0) / T.fz0, LARGEST_DFZ)  # (4.E2a)
    o.dpi = (max(p, 0.5 * T.p0) - T.p0) / T.p0  # (4.E2b)
    o.cos_alpha = 1.0 / sqrt(1.0 + o.alpha_s**2)  # (4.E6)
    o.mu = max(mu, SMALLEST_FRICTION)  # lambda_mu, and lambda'_mu with A_mu = 1 (4.E7, 4.E8)
    o.fade = v_x**2 / (v_x**2 + FADE_SPEED**2)
    return o


def longitudinal_slip_stiffness(T: TyreProperties, Fz: float, dfz: float, dpi: float) -> float:
    """Kxk [N] (4.E15)."""
    by_load = max(T.pkx1 + T.pkx2 * dfz, FLOOR * T.pkx1)
    by_pressure = max(1.0 + T.ppx1 * dpi + T.ppx2 * dpi**2, FLOOR)
    return Fz * by_load * exp(T.pkx3 * dfz) * by_pressure


def cornering_stiffness(T: TyreProperties, Fz: float, dpi: float, gamma_s: float) -> float:
    """Kya [N], negative in ISO axes for PKY1 < 0 (4.E25)."""
    peak_load = (T.pky2 + T.pky5 * gamma_s**2) * max(1.0 + T.ppy2 * dpi, FLOOR)
    angle = min(T.pky4 * atan(Fz / T.fz0 / max(peak_load, FLOOR * T.pky2)), LARGEST_ANGLE)
    by_camber = max(1.0 - T.pky3 * abs(gamma_s), FLOOR)
    return T.pky1 * T.fz0 * max(1.0 + T.ppy1 * dpi, FLOOR) * by_camber * sin(angle)


def _pure_longitudinal(T: TyreProperties, o: SimpleNamespace) -> SimpleNamespace:
    r = SimpleNamespace()
    S_Hx = (T.phx1 + T.phx2 * o.dfz) * o.fade  # (4.E17)
    kappa_x = o.kappa + S_Hx  # (4.E10)
    C_x = T.pcx1  # (4.E11)
    mu_x = max(T.pdx1 + T.pdx2 * o.dfz, FLOOR * T.pdx1) * max(1.0 + T.ppx3 * o.dpi + T.ppx4 * o.dpi**2, FLOOR)
    mu_x *= max(1.0 - T.pdx3 * o.gamma**2, FLOOR) * o.mu  # (4.E13)
    D_x = mu_x * o.Fz  # (4.E12)
    E_x = (T.pex1 + T.pex2 * o.dfz + T.pex3 * o.dfz**2) * (1.0 - T.pex4 * o.fade * _sign(kappa_x))
    E_x = min(E_x, 1.0)  # (4.E14)
    r.K_xk = longitudinal_slip_stiffness(T, o.Fz, o.dfz, o.dpi)
    B_x = r.K_xk / (C_x * D_x)  # (4.E16)
    S_Vx = o.Fz * (T.pvx1 + T.pvx2 * o.dfz) * o.fade * o.mu  # (4.E18)
    x = B_x * kappa_x
    r.F_x0 = D_x * sin(C_x * atan(x - E_x * (x - atan(x)))) + S_Vx  # (4.E9)
    return r


def _pure_lateral(T: TyreProperties, o: SimpleNamespace, gamma_s: float) -> SimpleNamespace:
    r = SimpleNamespace()
    r.K_ya = cornering_stiffness(T, o.Fz, o.dpi, gamma_s)
    S_Vyg = o.Fz * (T.pvy3 + T.pvy4 * o.dfz) * gamma_s * o.mu  # (4.E28)
    K_yg0 = o.Fz * (T.pky6 + T.pky7 * o.dfz) * (1.0 + T.ppy5 * o.dpi)  # (4.E30)
    r.S_Hy = (T.phy1 + T.phy2 * o.dfz) * o.fade + T.phy3 * gamma_s + (K_yg0 * gamma_s - S_Vyg) / r.K_ya  # (4.E27)
    r.S_Vy = o.Fz * (T.pvy1 + T.pvy2 * o.dfz) * o.fade * o.mu + S_Vyg  # (4.E29)
    alpha_y = o.alpha_s + r.S_Hy  # (4.E20)
    C_y = T.pcy1  # (4.E21)
    share = max(1.0 + T.pdy2 / T.pdy1 * o.dfz, FLOOR) * max(1.0 + T.ppy3 * o.dpi + T.ppy4 * o.dpi**2, FLOOR)
    r.mu_y = T.pdy1 * share * max(1.0 - T.pdy3 * gamma_s**2, FLOOR) * o.mu  # (4.E23)
    D_y = r.mu_y * o.Fz  # (4.E22)
    skew = (T.pey3 * o.fade + T.pey4 * gamma_s) * _sign(alpha_y)
    E_y = min((T.pey1 + T.pey2 * o.dfz) * (1.0 + T.pey5 * gamma_s**2 - skew), 1.0)  # (4.E24)
    r.B_y = r.K_ya / (C_y * D_y)  # (4.E26)
    x = r.B_y * alpha_y
    r.F_y0 = D_y * sin(C_y * atan(x - E_y * (x - atan(x)))) + r.S_Vy  # (4.E19)
    return r


def _weights(T: TyreProperties, o: SimpleNamespace, mu_y: float) -> tuple[float, float, float]:
    """G_xa, G_yk and S_Vyk of combined slip."""
    B_xa = (T.rbx1 + T.rbx3 * o.gamma_s**2) * cos(atan(T.rbx2 * o.kappa))  # (4.E54)
    C_xa = T.rcx1  # (4.E55)
    E_xa = min(T.rex1 + T.rex2 * o.dfz, 1.0)  # (4.E56)
    S_Hxa = T.rhx1 * o.fade  # (4.E57)
    x0, x = B_xa * S_Hxa, B_xa * (o.alpha_s + S_Hxa)  # (4.E53)
    G_xa0 = cos(C_xa * atan(x0 - E_xa * (x0 - atan(x0))))  # (4.E52)
    G_xa = max(cos(C_xa * atan(x - E_xa * (x - atan(x)))), 0.0) / max(G_xa0, FLOOR)  # (4.E51)
    B_yk = (T.rby1 + T.rby4 * o.gamma_s**2) * cos(atan(T.rby2 * (o.alpha_s - T.rby3 * o.fade)))  # (4.E62)
    C_yk = T.rcy1  # (4.E63)
    E_yk = min(T.rey1 + T.rey2 * o.dfz, 1.0)  # (4.E64)
    S_Hyk = (T.rhy1 + T.rhy2 * o.dfz) * o.fade  # (4.E65)
    x0, x = B_yk * S_Hyk, B_yk * (o.kappa + S_Hyk)  # (4.E61)
    G_yk0 = cos(C_yk * atan(x0 - E_yk * (x0 - atan(x0))))  # (4.E60)
    G_yk = max(cos(C_yk * atan(x - E_yk * (x - atan(x)))), 0.0) / max(G_yk0, FLOOR)  # (4.E59)
    D_Vyk = mu_y * o.Fz * (T.rvy1 + T.rvy2 * o.dfz + T.rvy3 * o.gamma_s) * cos(atan(T.rvy4 * o.alpha_s))  # (4.E67)
    S_Vyk = D_Vyk * sin(T.rvy5 * atan(T.rvy6 * o.kappa)) * o.fade  # (4.E66)
    return G_xa, G_yk, S_Vyk


def _moment(T: TyreProperties, o: SimpleNamespace, x: SimpleNamespace, y: SimpleNamespace) -> tuple[float, float]:
    """Pneumatic trail t [m] and residual moment Mzr [N m] of combined slip."""
    S_Ht = T.qhz1 + T.qhz2 * o.dfz + (T.qhz3 + T.qhz4 * o.dfz) * o.gamma_s  # (4.E35)
    alpha_t = o.alpha_s + S_Ht  # (4.E34)
    alpha_r = o.alpha_s + y.S_Hy + y.S_Vy / y.K_ya  # (4.E37, 4.E38)
    by_camber = 1.0 + T.qbz4 * o.gamma_s + T.qbz5 * abs(o.gamma_s)
    B_t = (T.qbz1 + T.qbz2 * o.dfz + T.qbz3 * o.dfz**2) * by_camber / o.mu  # (A58) for (4.E40)
    C_t = T.qcz1  # (4.E41)
    D_t0 = o.Fz * (T.r0 / T.fz0) * (T.qdz1 + T.qdz2 * o.dfz) * (1.0 - T.ppz1 * o.dpi)  # (4.E42)
    D_t = D_t0 * (1.0 + T.qdz3 * o.gamma_s + T.qdz4 * o.gamma_s**2)  # (A60) for (4.E43)
    skew = 1.0 + (T.qez4 + T.qez5 * o.gamma_s) * 2.0 / math.pi * atan(B_t * C_t * alpha_t)
    E_t = min((T.qez1 + T.qez2 * o.dfz + T.qez3 * o.dfz**2) * skew, 1.0)  # (4.E44)
    B_r = T.qbz9 / o.mu + T.qbz10 * y.B_y * T.pcy1  # (4.E45)
    by_camber = (T.qdz8 + T.qdz9 * o.dfz) * (1.0 + T.ppz2 * o.dpi) + (T.qdz10 + T.qdz11 * o.dfz) * abs(o.gamma_s)
    D_r = o.Fz * T.r0 * (T.qdz6 + T.qdz7 * o.dfz + by_camber * o.gamma_s) * o.mu * o.cos_alpha  # (4.E47)
    alpha_teq = sqrt(alpha_t**2 + (x.K_xk / y.K_ya) ** 2 * o.kappa**2) * _sign(alpha_t)  # (4.E77)
    alpha_req = sqrt(alpha_r**2 + (x.K_xk / y.K_ya) ** 2 * o.kappa**2) * _sign(alpha_r)  # (4.E78)
    b = B_t * alpha_teq
    t = D_t * cos(C_t * atan(b - E_t * (b - atan(b)))) * o.cos_alpha  # (4.E73)
    return t, D_r * cos(atan(B_r * alpha_req))  # (4.E75), C_r = 1 (4.E46)


def reference_slip_forces(
    tyre: TyreProperties, kappa: float, tan_alpha: float, gamma: float, fz: float, pressure: float,
    v_x: float, mu: float, side: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Fx [N], Fy [N], Mz [N m]; arguments as in magic_formula.slip_forces, with the property set for q."""
    if fz <= SMALLEST_LOAD:
        return 0.0, 0.0, 0.0
    o = _operating_point(tyre, kappa, tan_alpha, gamma, fz, pressure, v_x, mu, side)
    x = _pure_longitudinal(tyre, o)
    y = _pure_lateral(tyre, o, o.gamma_s)
    G_xa, G_yk, S_Vyk = _weights(tyre, o, y.mu_y)
    F_x = G_xa * x.F_x0  # (4.E50)
    F_y = G_yk * y.F_y0 + S_Vyk  # (4.E58)
    F_y_upright = G_yk * _pure_lateral(tyre, o, 0.0).F_y0  # (4.E74)
    t, M_zr = _moment(tyre, o, x, y)
    s = tyre.ssz1 * o.fade + tyre.ssz2 * F_y / tyre.fz0 + (tyre.ssz3 + tyre.ssz4 * o.dfz) * o.gamma_s
    s *= tyre.r0  # (4.E76)
    M_z = (-t * F_y_upright + M_zr) * o.fade + s * F_x  # (4.E71, 4.E72)
    return o.direction * F_x, o.direction * side * F_y, side * M_z
