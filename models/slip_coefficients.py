"""The Magic Formula 6.1 slip coefficients by name: the one list that property files, tyres and the slip kernel share.

Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 4.3.2 and App. 3; names as in the standard `.tir` property file, in
lower case. All are dimensionless, except the reference values fz0 [N], p0 [Pa, gauge] and r0 [m]. phy3 belongs to Magic
Formula 5.2 (side-slip shift with camber) and is zero in 6.1 sets. Left out: turn slip, overturning moment, scaling
factors (friction is an argument of the kernel).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class SlipCoefficients:
    """Reference values, then longitudinal, lateral, aligning, combined coefficients, in the kernel's order."""

    fz0: float  # nominal load [N]
    p0: float  # nominal inflation pressure, gauge [Pa]
    r0: float  # unloaded radius [m]
    # longitudinal force
    pcx1: float
    pdx1: float
    pdx2: float
    pdx3: float
    pex1: float
    pex2: float
    pex3: float
    pex4: float
    pkx1: float
    pkx2: float
    pkx3: float
    phx1: float
    phx2: float
    pvx1: float
    pvx2: float
    ppx1: float
    ppx2: float
    ppx3: float
    ppx4: float
    # lateral force
    pcy1: float
    pdy1: float
    pdy2: float
    pdy3: float
    pey1: float
    pey2: float
    pey3: float
    pey4: float
    pey5: float
    pky1: float
    pky2: float
    pky3: float
    pky4: float
    pky5: float
    pky6: float
    pky7: float
    phy1: float
    phy2: float
    phy3: float
    pvy1: float
    pvy2: float
    pvy3: float
    pvy4: float
    ppy1: float
    ppy2: float
    ppy3: float
    ppy4: float
    ppy5: float
    # aligning moment
    qbz1: float
    qbz2: float
    qbz3: float
    qbz4: float
    qbz5: float
    qbz9: float
    qbz10: float
    qcz1: float
    qdz1: float
    qdz2: float
    qdz3: float
    qdz4: float
    qdz6: float
    qdz7: float
    qdz8: float
    qdz9: float
    qdz10: float
    qdz11: float
    qez1: float
    qez2: float
    qez3: float
    qez4: float
    qez5: float
    qhz1: float
    qhz2: float
    qhz3: float
    qhz4: float
    ppz1: float
    ppz2: float
    # combined slip
    rbx1: float
    rbx2: float
    rbx3: float
    rcx1: float
    rex1: float
    rex2: float
    rhx1: float
    rby1: float
    rby2: float
    rby3: float
    rby4: float
    rcy1: float
    rey1: float
    rey2: float
    rhy1: float
    rhy2: float
    rvy1: float
    rvy2: float
    rvy3: float
    rvy4: float
    rvy5: float
    rvy6: float
    ssz1: float
    ssz2: float
    ssz3: float
    ssz4: float


SLIP_NAMES: tuple[str, ...] = tuple(field.name for field in dataclasses.fields(SlipCoefficients))
