"""A worn tyre as factors on a tyre's properties and on its radius, from the depth of tread that is left.

    radius            -(NEW - depth)                                    the tread rubber that is gone
    belt mass         -2 pi r0 width LAND DENSITY (NEW - depth)         and its inertia, times r0^2 about the spin axis
    belt frequencies  the sidewall's stiffness stays, so f ~ 1 / sqrt(mass), 1 / sqrt(inertia)
    Cx, Cy            tread elements are shear springs in series with the carcass: 1/C = (1 - TREAD)/C + TREAD/C d/NEW

Declared, usual for passenger tyres: NEW, LAND, DENSITY, TREAD. Left out: the tread's share of rolling resistance, grip.
"""

from __future__ import annotations

import math

from models.tyre_properties import TyreProperties

NEW = 8e-3  # m
LEGAL = 1.6e-3  # m
LAND = 0.65  # share of the tread's surface that is rubber
DENSITY = 1150.0  # kg/m^3
TREAD = 0.35  # share of the new tyre's horizontal compliance


def worn_factors(tyre: TyreProperties, depth: float) -> tuple[dict[str, float], float]:
    """Factors of a campaign's [tyre] table, and the radius factor. depth: tread left [m], LEGAL to NEW; ValueError."""
    if not LEGAL <= depth <= NEW:
        raise ValueError(f"tread depth {1e3 * depth:g} mm is out of range; valid: {1e3 * LEGAL:g} to {1e3 * NEW:g} mm")
    lost = NEW - depth
    tread = 2.0 * math.pi * tyre.r0 * tyre.width * LAND * DENSITY * lost
    mass = 1.0 - tread / tyre.belt_mass
    spin = 1.0 - tread * tyre.r0**2 / tyre.belt_iyy
    across = 1.0 - 0.5 * tread * tyre.r0**2 / tyre.belt_ixx
    stiffer = 1.0 / (1.0 - TREAD * lost / NEW)
    factors = {
        "belt_mass": mass, "belt_iyy": spin, "belt_ixx": across,
        "freq_long": mass**-0.5, "freq_lat": mass**-0.5, "freq_yaw": across**-0.5, "freq_windup": spin**-0.5,
        "cx": stiffer, "cy": stiffer,
    }  # fmt: skip
    return factors, 1.0 - lost / tyre.r0
