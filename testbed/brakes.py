"""The brakes: an ideal anti-lock control of each wheel's torque, and the brake's friction itself.

Anti-lock: a wheel's slip s = 1 - omega R / v obeys ds/dt = (T - F R) R / (J v), T the brake's torque, F the tyre's
force. With

    T = F R + RATE (s_target - s) J v / R        the slip runs to the target with the time constant 1 / RATE
    s_target = s_peak F / (mu_peak Fz)           s_peak, mu_peak: the tyre's own, on its nominal surface

the target needs no friction estimate: on a surface of any friction the tyre's curve F(s) crosses that line at its
peak, since friction scales slip and force of the peak alike. So the control reads tyre force and load, which a real one
must estimate.
Friction: elastic at rest and Coulomb when turning (Dahl's model), so a braked car stands without creeping.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined
from models.tyre_properties import TyreProperties
from models.vehicle import Vehicle
from testbed.tyre.magic_formula import slip_forces

RATE = 40.0  # 1/s
LEAST_TARGET = 0.2  # of s_peak
QUIET = 0.15  # of s_peak: slip below which the control leaves the brake alone
LOCK_SPEED = 1.5  # m/s below which it lets the wheels lock
BRISTLE = 0.005  # rad of elastic wind-up of brake and hub at the brake torque
DAMPING_RATIO = 0.2  # of the wheel on its wound-up brake


class Brakes(NamedTuple):
    """Per wheel, shape (4,): share of the torque (sums to 1), inertia of rim and belt [kg m^2]; torque: the largest of
    all four wheels together [N m]; radius: rolling [m]; peak_slip, peak_friction: of the tyre [-]."""

    share: NDArray[np.float64]
    inertia: NDArray[np.float64]
    torque: float
    radius: float
    peak_slip: float
    peak_friction: float


def braking_peak(tyre: TyreProperties, load: float, friction: float = 1.0) -> tuple[float, float]:
    """Slip and friction coefficient of the tyre's largest braking force, straight on, at a load [N] and p0."""
    slip = np.linspace(0.005, 0.5, 496)
    q = tyre.slip_array()
    force = np.array([-slip_forces(q, -s, 0.0, 0.0, load, tyre.p0, tyre.v0, friction, 1.0)[0] for s in slip])
    best = int(force.argmax())
    return float(slip[best]), float(force[best] / load)


def brakes(vehicle: Vehicle, tyre: TyreProperties, radius: float) -> Brakes:
    """The brakes of a car on four equal tyres; radius: nominal rolling radius [m]."""
    share = np.array([0.5 * axle.brake_share for axle in vehicle.axles])
    inertia = np.array([axle.spin_inertia + tyre.belt_iyy for axle in vehicle.axles])
    peak_slip, peak_friction = braking_peak(tyre, tyre.fz0)
    return Brakes(share, inertia, vehicle.driveline.max_brake_torque, radius, peak_slip, peak_friction)


@inlined
def anti_lock(brakes, w, wanted, speed, spin, force, load):
    """Torque [N m] that the brake of wheel w is given where `wanted` is asked for. speed: of the wheel's centre along
    the wheel [m/s]; spin [rad/s]; force: of the tyre, driving positive, and load [N]."""
    if speed < LOCK_SPEED or wanted <= 0.0:
        return wanted
    slip = 1.0 - spin * brakes.radius / speed
    if slip < QUIET * brakes.peak_slip:
        return wanted
    used = -force / (brakes.peak_friction * max(load, 100.0))
    target = brakes.peak_slip * min(max(used, LEAST_TARGET), 1.0)
    hold = -force * brakes.radius + RATE * (target - slip) * brakes.inertia[w] * speed / brakes.radius
    return min(max(hold, 0.0), wanted)


@inlined
def brake_moment(bristle, w, limit, spin, inertia, step):
    """Friction moment of a brake on its wheel [N m] (against `spin` [rad/s]), bounded by `limit`.
    bristle: wind-up [rad], shape (4,), written."""
    if limit <= 1.0:
        bristle[w] = 0.0
        return 0.0
    stiff = limit / BRISTLE
    stiff = min(stiff, 0.5 * inertia / (step * step))
    reach = limit / stiff
    decay = abs(spin) * step / reach
    weight = -math.expm1(-decay) / decay if decay > 1e-9 else 1.0
    bristle[w] = bristle[w] * math.exp(-decay) + spin * step * weight
    bristle[w] = min(max(bristle[w], -reach), reach)
    elastic = stiff * bristle[w]
    damping = 2.0 * DAMPING_RATIO * math.sqrt(stiff * inertia) * max(1.0 - abs(bristle[w]) / reach, 0.0)
    return -min(max(elastic + damping * spin, -limit), limit)
