"""Magic Formula 6.1: steady-state slip forces and aligning moment of one tyre, compiled.

Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 4.3.2: pure slip (4.E9-4.E49), combined slip (4.E50-4.E78), inflation
pressure. As property files and the reference solver have it, trail slope and size follow Besselink, Schmeitz, Pacejka,
Vehicle System Dynamics 48 (2010) sup. 1, eqs. (A58), (A60): Bt ~ 1 + QBZ4 g + QBZ5 |g|, Dt ~ 1 + QDZ3 g + QDZ4 g^2.
testbed/tyre/reference.py writes the same out equation by equation.

Axes ISO 8855 (x forward, y left, z up); inputs
    kappa      (Omega Re - Vx) / |Vx| [-], driving positive gives Fx > 0
    tan_alpha  Vy / |Vx| [-], contact patch moving left gives Fy < 0
    gamma      camber about x [rad], top to the right positive
    mu         friction over that of the measurement: LMUX = LMUY = mu (with A_mu = 1)
    side       +1: the tyre as the set has it, -1: its mirror image (the other side of the car)
    q          TyreProperties.slip_array(); q[PKX1] is PKX1, and so on for every name of models.slip_coefficients

Beyond the book, so that any input gives a finite and continuous answer:
    - pressure below p0/2 counts as p0/2 and load above 3 Fz0 as 3 Fz0 in the coefficients: the polynomials end there
    - Vx < 0 is the same tyre seen from the other end (kappa, tan_alpha, gamma and the forces change sign, Mz does not)
    - ply steer, conicity and Mz carry the factor Vx^2/(Vx^2 + FADE_SPEED^2): a standing tyre has none
    - weights G stay above 0, curvatures E below 1, falling factors above 0.1
Left out: turn slip, overturning moment, slip-speed dependent friction.
"""

from __future__ import annotations

import math

from numba import njit

from estimators.compiled import compiled
from models.slip_coefficients import SLIP_NAMES

FADE_SPEED = 0.5  # m/s
LARGEST_DFZ = 2.0  # largest load change in the coefficients: 3 Fz0
SMALLEST_LOAD = 1e-6  # N, below which there is no force
SMALLEST_FRICTION = 1e-3
FLOOR = 0.1  # of factors that fall with load, pressure or camber
LARGEST_ANGLE = 0.95 * math.pi  # of the sine in the cornering stiffness, which must not change sign

# Parts of slip_forces: inlined into it before compilation, which takes it from 690 to 350 ns (no arrays are passed).
_inlined = njit(inline="always", nogil=True, error_model="numpy")

# Places in q; the order is SLIP_NAMES, and a test holds the two together.
(
    FZ0, P0, R0,
    PCX1, PDX1, PDX2, PDX3, PEX1, PEX2, PEX3, PEX4, PKX1, PKX2, PKX3, PHX1, PHX2, PVX1, PVX2, PPX1, PPX2, PPX3, PPX4,
    PCY1, PDY1, PDY2, PDY3, PEY1, PEY2, PEY3, PEY4, PEY5, PKY1, PKY2, PKY3, PKY4, PKY5, PKY6, PKY7,
    PHY1, PHY2, PHY3, PVY1, PVY2, PVY3, PVY4, PPY1, PPY2, PPY3, PPY4, PPY5,
    QBZ1, QBZ2, QBZ3, QBZ4, QBZ5, QBZ9, QBZ10, QCZ1, QDZ1, QDZ2, QDZ3, QDZ4, QDZ6, QDZ7, QDZ8, QDZ9, QDZ10, QDZ11,
    QEZ1, QEZ2, QEZ3, QEZ4, QEZ5, QHZ1, QHZ2, QHZ3, QHZ4, PPZ1, PPZ2,
    RBX1, RBX2, RBX3, RCX1, REX1, REX2, RHX1, RBY1, RBY2, RBY3, RBY4, RCY1, REY1, REY2, RHY1, RHY2,
    RVY1, RVY2, RVY3, RVY4, RVY5, RVY6, SSZ1, SSZ2, SSZ3, SSZ4,
) = range(len(SLIP_NAMES))  # fmt: skip


@_inlined
def _sine(c, e, bx):
    """sin(C atan(Bx - E (Bx - atan Bx))), with E at most 1."""
    return math.sin(c * math.atan(bx - min(e, 1.0) * (bx - math.atan(bx))))


@_inlined
def _cosine(c, e, bx):
    """cos(C atan(Bx - E (Bx - atan Bx))), with E at most 1."""
    return math.cos(c * math.atan(bx - min(e, 1.0) * (bx - math.atan(bx))))


@_inlined
def _changes(q, fz, pressure):
    """dfz and dpi [-], within the range of the set."""
    return min(fz / q[FZ0] - 1.0, LARGEST_DFZ), max(pressure / q[P0], 0.5) - 1.0


@_inlined
def _longitudinal_stiffness(q, fz, dfz, dpi):
    """Kxk [N] (4.E15)."""
    load = max(q[PKX1] + q[PKX2] * dfz, FLOOR * q[PKX1])
    return fz * load * math.exp(q[PKX3] * dfz) * max(1.0 + (q[PPX1] + q[PPX2] * dpi) * dpi, FLOOR)


@_inlined
def _cornering_sine(q, fz, dpi, gamma_squared):
    """The load-dependent factor of Kya (4.E25)."""
    peak = (q[PKY2] + q[PKY5] * gamma_squared) * max(1.0 + q[PPY2] * dpi, FLOOR)
    return math.sin(min(q[PKY4] * math.atan(fz / (q[FZ0] * max(peak, FLOOR * q[PKY2]))), LARGEST_ANGLE))


@_inlined
def _cornering_scale(q, dpi):
    """PKY1 Fz0 (1 + PPY1 dpi) [N] (4.E25)."""
    return q[PKY1] * q[FZ0] * max(1.0 + q[PPY1] * dpi, FLOOR)


@compiled
def slip_stiffness(q, fz, pressure):
    """Slip stiffness Kxk and |Kya| [N] at zero camber; fz [N], pressure gauge [Pa]. Both positive for fz > 0."""
    load = max(fz, SMALLEST_LOAD)
    dfz, dpi = _changes(q, load, pressure)
    kya = _cornering_scale(q, dpi) * _cornering_sine(q, load, dpi, 0.0)
    return _longitudinal_stiffness(q, load, dfz, dpi), abs(kya)


@_inlined
def _pure_longitudinal(q, kappa, gamma, fz, dfz, dpi, mu, fade):
    """Fx0 and Kxk (4.E9-4.E18)."""
    friction = max(q[PDX1] + q[PDX2] * dfz, FLOOR * q[PDX1]) * max(1.0 + (q[PPX3] + q[PPX4] * dpi) * dpi, FLOOR)
    dx = friction * max(1.0 - q[PDX3] * gamma * gamma, FLOOR) * mu * fz
    kxk = _longitudinal_stiffness(q, fz, dfz, dpi)
    kappa_x = kappa + (q[PHX1] + q[PHX2] * dfz) * fade
    forward = 1.0 - q[PEX4] * fade * math.copysign(1.0, kappa_x)
    ex = (q[PEX1] + (q[PEX2] + q[PEX3] * dfz) * dfz) * forward
    fx0 = dx * _sine(q[PCX1], ex, kxk / (q[PCX1] * dx) * kappa_x)
    return fx0 + fz * (q[PVX1] + q[PVX2] * dfz) * fade * mu, kxk


@_inlined
def _pure_lateral(q, tan_alpha, gamma, kya, fz, dfz, dpi, mu, fade):
    """Fy0, SHy, SVy, muy, By (4.E19-4.E30); gamma: its sine; kya: at this camber."""
    load = max(1.0 + q[PDY2] / q[PDY1] * dfz, FLOOR) * max(1.0 + (q[PPY3] + q[PPY4] * dpi) * dpi, FLOOR)
    muy = q[PDY1] * load * max(1.0 - q[PDY3] * gamma * gamma, FLOOR) * mu
    dy = muy * fz
    by = kya / (q[PCY1] * dy)
    svy_camber = fz * (q[PVY3] + q[PVY4] * dfz) * gamma * mu
    ky_camber = fz * (q[PKY6] + q[PKY7] * dfz) * (1.0 + q[PPY5] * dpi)
    shy = (q[PHY1] + q[PHY2] * dfz) * fade + q[PHY3] * gamma + (ky_camber * gamma - svy_camber) / kya
    svy = fz * (q[PVY1] + q[PVY2] * dfz) * fade * mu + svy_camber
    alpha_y = tan_alpha + shy
    skew = (q[PEY3] * fade + q[PEY4] * gamma) * math.copysign(1.0, alpha_y)
    ey = (q[PEY1] + q[PEY2] * dfz) * (1.0 + q[PEY5] * gamma * gamma - skew)
    return dy * _sine(q[PCY1], ey, by * alpha_y) + svy, shy, svy, muy, by


@_inlined
def _weight_of_side_slip(q, kappa, tan_alpha, gamma, dfz, fade):
    """Gxa (4.E51-4.E57), between 0 and about 1."""
    slope = (q[RBX1] + q[RBX3] * gamma * gamma) / math.sqrt(1.0 + (q[RBX2] * kappa) ** 2)
    curvature = q[REX1] + q[REX2] * dfz
    shift = q[RHX1] * fade
    at_zero = _cosine(q[RCX1], curvature, slope * shift)
    return max(_cosine(q[RCX1], curvature, slope * (tan_alpha + shift)), 0.0) / max(at_zero, FLOOR)


@_inlined
def _weight_of_longitudinal_slip(q, kappa, tan_alpha, gamma, dfz, fade):
    """Gyk (4.E59-4.E65), between 0 and about 1."""
    across = q[RBY2] * (tan_alpha - q[RBY3] * fade)
    slope = (q[RBY1] + q[RBY4] * gamma * gamma) / math.sqrt(1.0 + across * across)
    curvature = q[REY1] + q[REY2] * dfz
    shift = (q[RHY1] + q[RHY2] * dfz) * fade
    at_zero = _cosine(q[RCY1], curvature, slope * shift)
    return max(_cosine(q[RCY1], curvature, slope * (kappa + shift)), 0.0) / max(at_zero, FLOOR)


@_inlined
def _side_force_of_longitudinal_slip(q, kappa, tan_alpha, gamma, muy, fz, dfz, fade):
    """SVyk (4.E66, 4.E67)."""
    size = muy * fz * (q[RVY1] + q[RVY2] * dfz + q[RVY3] * gamma) / math.sqrt(1.0 + (q[RVY4] * tan_alpha) ** 2)
    return size * math.sin(q[RVY5] * math.atan(q[RVY6] * kappa)) * fade


@_inlined
def _trail(q, tan_alpha, gamma, slip_squared, fz, dfz, dpi, mu, cos_alpha):
    """Pneumatic trail t [m] (4.E73, 4.E33-4.E44); slip_squared: (Kxk kappa / Kya)^2."""
    bt = (q[QBZ1] + (q[QBZ2] + q[QBZ3] * dfz) * dfz) * (1.0 + q[QBZ4] * gamma + q[QBZ5] * abs(gamma)) / mu
    dt = fz * (q[R0] / q[FZ0]) * (q[QDZ1] + q[QDZ2] * dfz) * (1.0 - q[PPZ1] * dpi)
    dt *= 1.0 + (q[QDZ3] + q[QDZ4] * gamma) * gamma
    alpha_t = tan_alpha + q[QHZ1] + q[QHZ2] * dfz + (q[QHZ3] + q[QHZ4] * dfz) * gamma
    skew = 1.0 + (q[QEZ4] + q[QEZ5] * gamma) * (2.0 / math.pi) * math.atan(bt * q[QCZ1] * alpha_t)
    et = (q[QEZ1] + (q[QEZ2] + q[QEZ3] * dfz) * dfz) * skew
    return dt * _cosine(q[QCZ1], et, bt * math.sqrt(alpha_t * alpha_t + slip_squared)) * cos_alpha


@_inlined
def _residual_moment(q, alpha_r, gamma, slip_squared, by, fz, dfz, dpi, mu, cos_alpha):
    """Mzr [N m] (4.E75, 4.E36-4.E47)."""
    br = q[QBZ9] / mu + q[QBZ10] * by * q[PCY1]
    camber = (q[QDZ8] + q[QDZ9] * dfz) * (1.0 + q[PPZ2] * dpi) + (q[QDZ10] + q[QDZ11] * dfz) * abs(gamma)
    dr = fz * q[R0] * (q[QDZ6] + q[QDZ7] * dfz + camber * gamma) * mu * cos_alpha
    return dr / math.sqrt(1.0 + br * br * (alpha_r * alpha_r + slip_squared))


@compiled
def slip_forces(q, kappa, tan_alpha, gamma, fz, pressure, v_x, mu, side):
    """Fx [N], Fy [N], Mz [N m] of steady combined slip in the contact patch; see the module for inputs and signs.

    gamma [rad], fz [N], pressure gauge [Pa], v_x [m/s]. Zero without load.
    """
    if fz <= SMALLEST_LOAD:
        return 0.0, 0.0, 0.0
    way = 1.0 if v_x >= 0.0 else -1.0
    kappa *= way
    tan_alpha *= way * side
    gamma *= way * side
    mu = max(mu, SMALLEST_FRICTION)
    fade = v_x * v_x / (v_x * v_x + FADE_SPEED * FADE_SPEED)
    dfz, dpi = _changes(q, fz, pressure)
    lean = math.sin(gamma)

    fx0, kxk = _pure_longitudinal(q, kappa, gamma, fz, dfz, dpi, mu, fade)
    scale = _cornering_scale(q, dpi)
    upright = scale * _cornering_sine(q, fz, dpi, 0.0)
    kya = upright if q[PKY5] == 0.0 else scale * _cornering_sine(q, fz, dpi, lean * lean)
    kya *= max(1.0 - q[PKY3] * abs(lean), FLOOR)
    fy0, shy, svy, muy, by = _pure_lateral(q, tan_alpha, lean, kya, fz, dfz, dpi, mu, fade)

    fx = fx0 * _weight_of_side_slip(q, kappa, tan_alpha, lean, dfz, fade)
    weight = _weight_of_longitudinal_slip(q, kappa, tan_alpha, lean, dfz, fade)
    fy = fy0 * weight + _side_force_of_longitudinal_slip(q, kappa, tan_alpha, lean, muy, fz, dfz, fade)

    fy0_upright = fy0
    if gamma != 0.0:
        fy0_upright = _pure_lateral(q, tan_alpha, 0.0, upright, fz, dfz, dpi, mu, fade)[0]
    cos_alpha = 1.0 / math.sqrt(1.0 + tan_alpha * tan_alpha)
    slip_squared = (kxk / kya * kappa) ** 2
    trail = _trail(q, tan_alpha, lean, slip_squared, fz, dfz, dpi, mu, cos_alpha)
    residual = _residual_moment(q, tan_alpha + shy + svy / kya, lean, slip_squared, by, fz, dfz, dpi, mu, cos_alpha)
    arm = q[SSZ1] * fade + q[SSZ2] * fy / q[FZ0] + (q[SSZ3] + q[SSZ4] * dfz) * lean
    mz = (residual - trail * fy0_upright * weight) * fade + q[R0] * arm * fx
    return way * fx, way * side * fy, side * mz
