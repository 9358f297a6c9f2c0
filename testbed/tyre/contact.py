"""The tyre as a force element: road under one wheel -> forces on its belt ring and rim, every step.

    effective road plane (enveloping) -> residual deflection -> load -> contact length, rolling radius, drag moment
    slip velocities -> relaxation (contact deflections u, v) -> Magic Formula 6.1 -> Fx, Fy, Mz

Relaxation [Pacejka ch. 7, 9]:  du/dt = (Omega Re - Vx) - |Vx| u / sigma_x,   dv/dt = Vy - |Vx| v / sigma_y,
transient slip kappa' = u / sigma_x, tan alpha' = v / sigma_y; integrated exactly over a step for constant coefficients,
so it needs no smallest speed: at rest u and v are the tyre's shear springs. There they are bounded near the slip of the
largest force, and a contact damper, which fades out at LOW_SPEED, takes out the energy.
sigma_x = Kxk / c_rx with the residual longitudinal stiffness (belt and torsion spring act in series); sigma_y = Kya /
Cy.

The moment about the spin axis is -Re Fx - My: with that lever the power of Fx is exactly the slip's loss Fx (Omega Re -
Vx). Below a deflection of the sidewall's height the rim bottoms and carries the load. Left out: overturning moment Mx,
turn slip. Axes ISO 8855; forces in the road's effective plane.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined
from models.tyre_properties import TyreProperties
from testbed.tyre import vertical
from testbed.tyre.enveloping import Cam, cam, effective_plane
from testbed.tyre.magic_formula import slip_forces, slip_stiffness
from testbed.tyre.vertical import VerticalLaw, vertical_law

LOW_SPEED = 2.5  # m/s, below which the contact damper acts
SLIP_AT_REST = 0.15  # bound of the transient slip at rest: a little past the largest force
SLIP_BOUND = 2.0  # bound of the transient slip when rolling: far on the sliding branch

# columns of a wheel's state (what the contact remembers from step to step)
STATE = ("shear_x", "shear_y", "half_length", "fx", "fy")
SHEAR_X, SHEAR_Y, HALF_LENGTH, LAST_FX, LAST_FY = range(len(STATE))

# columns of a wheel's output; stiffness is the tyre's own, without the rim that a flat tyre may run on
OUTPUT = ("load", "rolling_radius", "stiffness", "slip_ratio", "slip_angle", "fx", "fy", "mz", "drag_moment",
          "road_height", "deflection", "slip_loss", "drag_loss")  # fmt: skip
(LOAD, ROLLING_RADIUS, STIFFNESS, SLIP_RATIO, SLIP_ANGLE, FX, FY, MZ, DRAG_MOMENT,
 ROAD_HEIGHT, DEFLECTION, SLIP_LOSS, DRAG_LOSS) = range(len(OUTPUT))  # fmt: skip


class TyreElement(NamedTuple):
    """Everything constant about one tyre; SI."""

    law: VerticalLaw
    shape: Cam
    slip: NDArray[np.float64]
    sidewall: float  # c_b of the belt at p0 [N/m]
    residual_x: float  # c_rx at p0 [N/m]
    lateral: float  # Cy at p0 [N/m]
    cx_pressure: float  # relative change of c_rx per dpi [-]
    cy_pressure: float  # the same of Cy
    contact_damping: float  # [N s/m]
    rim_contact: float  # rim centre height at which the rim bottoms [m]
    rim_stiffness: float  # [N/m]
    torsion: float  # c_b,theta at p0 [N m/rad]
    torsion_base: float  # its share at zero pressure [-]


def residual_longitudinal_stiffness(tyre: TyreProperties) -> float:
    """c_rx [N/m]: what remains of Cx when belt translation and sidewall torsion are taken out in series."""
    compliance = 1.0 / tyre.cx - 1.0 / tyre.sidewall_stiffness - tyre.r0**2 / tyre.torsional_stiffness
    if compliance <= 0.0:
        raise ValueError(f"tyre {tyre.name}: Cx {tyre.cx:.0f} N/m is stiffer than its sidewall lets it be")
    return 1.0 / compliance


def tyre_element(tyre: TyreProperties) -> TyreElement:
    """Parameters of the force element of a property set."""
    return TyreElement(
        law=vertical_law(tyre),
        shape=cam(tyre),
        slip=tyre.slip_array(),
        sidewall=tyre.sidewall_stiffness,
        residual_x=residual_longitudinal_stiffness(tyre),
        lateral=tyre.cy,
        cx_pressure=tyre.cx_pressure,
        cy_pressure=tyre.cy_pressure,
        contact_damping=2.0 * 0.3 * math.sqrt(tyre.cx * tyre.belt_mass),
        rim_contact=tyre.rim_radius + tyre.bottom_offset,
        rim_stiffness=tyre.bottom_stiffness,
        torsion=tyre.torsional_stiffness,
        torsion_base=tyre.torsion_base,
    )


@inlined
def sidewall_stiffness(tyre, pressure):
    """Belt translation stiffness c_b [N/m]: follows the vertical law, so that ring and residual keep their ratio."""
    return tyre.sidewall * vertical.pressure_factor(tyre.law, pressure)


@inlined
def torsional_stiffness(tyre, pressure):
    """Belt against rim about the spin axis [N m/rad]: c (base + (1 - base) p/p0), a declared law."""
    return tyre.torsion * (tyre.torsion_base + (1.0 - tyre.torsion_base) * max(pressure, 0.0) / tyre.law.p0)


@inlined
def _relaxed(shear, rate, speed, sigma, bound, step):
    """Contact deflection one step on, held within bound * sigma."""
    decay = speed / sigma * step
    weight = -math.expm1(-decay) / decay if decay > 1e-9 else 1.0
    shear = shear * math.exp(-decay) + rate * step * weight
    return min(max(shear, -bound * sigma), bound * sigma)


@inlined
def _slip(tyre, state, out, pressure, fz, v_x, v_y, slip_speed, camber, friction, side, step):
    """Relaxation and Magic Formula of one wheel; fills slip, Fx, Fy, Mz of `out` and the wheel's state."""
    kx, ky = slip_stiffness(tyre.slip, fz, pressure)
    dpi = max(pressure, 0.5 * tyre.law.p0) / tyre.law.p0 - 1.0
    sigma_x = max(kx / (tyre.residual_x * (1.0 + tyre.cx_pressure * dpi)), 0.02)
    sigma_y = max(ky / (tyre.lateral * (1.0 + tyre.cy_pressure * dpi)), 0.02)
    speed = abs(v_x)
    rolling = min(speed / LOW_SPEED, 1.0)
    bound = SLIP_AT_REST + (SLIP_BOUND - SLIP_AT_REST) * rolling * rolling
    state[SHEAR_X] = _relaxed(state[SHEAR_X], slip_speed, speed, sigma_x, bound, step)
    state[SHEAR_Y] = _relaxed(state[SHEAR_Y], v_y, speed, sigma_y, bound, step)
    kappa = state[SHEAR_X] / sigma_x
    tan_alpha = state[SHEAR_Y] / sigma_y
    fx, fy, mz = slip_forces(tyre.slip, kappa, tan_alpha, camber, fz, pressure, v_x, friction, side)
    if rolling < 1.0:
        damping = tyre.contact_damping * (1.0 - rolling)
        limit = friction * fz
        fx = min(max(fx + damping * slip_speed, -limit), limit)
        fy = min(max(fy - damping * v_y, -limit), limit)
    state[LAST_FX], state[LAST_FY] = fx, fy
    out[SLIP_RATIO], out[SLIP_ANGLE] = kappa, math.atan(tan_alpha)
    out[FX], out[FY], out[MZ] = fx, fy, mz


@inlined
def wheel_forces(tyre, heights, origin, state, out, wrench, centre, rim_height, velocity, turning, spin, axis,
                 pressure, radius_factor, friction, side, step):  # fmt: skip
    """Forces of the road on one wheel; returns the extra force that acts on the rim of a flat tyre [N], upwards.

    heights, origin: the road window. state (5,), out (13,), wrench (6,): written; wrench is force and torque on the
    belt in the world. centre, velocity, turning: of the belt [m], [m/s], [rad/s], shape (3,); rim_height: how far the
    belt centre lies above the rim's, along z [m]; spin: absolute angular velocity about `axis` [rad/s]; axis: unit spin
    axis, to the left, cambered.
    """
    law = tyre.law
    norm = math.hypot(axis[0], axis[1])
    forward_x, forward_y = axis[1] / norm, -axis[0] / norm
    height, along, across = effective_plane(
        heights, origin, tyre.shape, centre[0], centre[1], forward_x, forward_y, state[HALF_LENGTH]
    )
    # unit normal of the effective plane, and the wheel's forward and left directions in it
    nx = -along * forward_x + across * forward_y
    ny = -along * forward_y - across * forward_x
    scale = 1.0 / math.sqrt(nx * nx + ny * ny + 1.0)
    nx, ny, nz = nx * scale, ny * scale, scale
    fwx, fwy, fwz = axis[1] * nz - axis[2] * ny, axis[2] * nx - axis[0] * nz, axis[0] * ny - axis[1] * nx
    scale = 1.0 / math.sqrt(fwx * fwx + fwy * fwy + fwz * fwz)
    fwx, fwy, fwz = fwx * scale, fwy * scale, fwz * scale
    lfx, lfy, lfz = ny * fwz - nz * fwy, nz * fwx - nx * fwz, nx * fwy - ny * fwx
    sin_camber = axis[0] * nx + axis[1] * ny + axis[2] * nz
    cos_camber = math.sqrt(1.0 - sin_camber * sin_camber)

    clearance = (centre[2] - height) * nz
    loaded_radius = clearance / cos_camber
    factor = vertical.pressure_factor(law, pressure)
    amplitude = vertical.load_amplitude(law, factor, spin, state[LAST_FX], state[LAST_FY])
    grown = radius_factor * vertical.free_radius(law, spin)
    residual = grown - loaded_radius
    belt_load = vertical.load_behind_sidewall(law, amplitude, residual, tyre.sidewall * factor)
    rim_load = tyre.rim_stiffness * max(tyre.rim_contact - (clearance - rim_height * nz), 0.0)
    fz = belt_load + rim_load
    radius = radius_factor * vertical.effective_rolling_radius(law, spin, belt_load, pressure)
    radius = min(radius, grown)
    out[LOAD], out[ROLLING_RADIUS], out[ROAD_HEIGHT] = fz, radius, height
    out[STIFFNESS] = vertical.stiffness(law, amplitude, belt_load)
    out[DEFLECTION] = residual + belt_load / (tyre.sidewall * factor)

    v_x = velocity[0] * fwx + velocity[1] * fwy + velocity[2] * fwz
    # the contact point lies a loaded radius below the belt's centre: the wheel's roll moves it sideways
    v_y = velocity[0] * lfx + velocity[1] * lfy + velocity[2] * lfz
    v_y += clearance * (turning[0] * fwx + turning[1] * fwy + turning[2] * fwz)
    slip_speed = spin * radius - v_x
    if fz > 0.0:
        state[HALF_LENGTH] = vertical.contact_half_length(law, factor, fz)
        _slip(tyre, state, out, pressure, fz, v_x, v_y, slip_speed, math.asin(sin_camber), friction, side, step)
    else:
        state[SHEAR_X] = state[SHEAR_Y] = state[LAST_FX] = state[LAST_FY] = 0.0
        out[SLIP_RATIO] = out[SLIP_ANGLE] = out[FX] = out[FY] = out[MZ] = 0.0
    fx, fy, mz = out[FX], out[FY], out[MZ]
    drag = vertical.drag_moment(law, vertical.drag_pressure_factor(law, pressure), fz, fx, v_x)
    drag *= spin / math.sqrt(spin * spin + 0.25)
    out[DRAG_MOMENT] = drag
    out[SLIP_LOSS] = fx * slip_speed - fy * v_y
    out[DRAG_LOSS] = drag * spin

    wrench[0] = belt_load * nx + fx * fwx + fy * lfx
    wrench[1] = belt_load * ny + fx * fwy + fy * lfy
    wrench[2] = belt_load * nz + fx * fwz + fy * lfz
    about_spin = -radius * fx - drag
    tilt = clearance * fy
    wrench[3] = about_spin * axis[0] + tilt * fwx + mz * nx
    wrench[4] = about_spin * axis[1] + tilt * fwy + mz * ny
    wrench[5] = about_spin * axis[2] + tilt * fwz + mz * nz
    return rim_load
