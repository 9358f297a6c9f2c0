"""Suspension force elements along the travel axis: progressive spring, asymmetric damper, stops.

With x the travel (up against the body, 0 at the design load) and v its rate, the force on the wheel (down) is

    F = F0 + k x + k3 x^3 + c(v) v + stop(x - bump clearance)^2 - stop(-x - rebound clearance)^2

c differs for compression (v > 0) and rebound. F0 carries the body at the design load. T1 Fig. 4 shows these shapes.
MuJoCo's polynomial springs cannot do an asymmetric damper nor a stop with free travel, so this is a force of the loop.
Half of the mean damping is left to the travel joint itself, where the integrator takes it implicitly: half implicit,
half held over the step is the trapezoidal rule, and moves the wheel-hop frequency by 0.1 % at 1 ms instead of 1.2 %.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined
from models.vehicle import Vehicle, joint_damping


class Suspension(NamedTuple):
    """Per wheel fl fr rl rr, shape (4,) each; SI."""

    preload: NDArray[np.float64]
    rate: NDArray[np.float64]
    progression: NDArray[np.float64]
    compression: NDArray[np.float64]
    rebound: NDArray[np.float64]
    joint: NDArray[np.float64]  # the part of the damping that the travel joint has
    bump_clearance: NDArray[np.float64]
    rebound_clearance: NDArray[np.float64]
    stop_rate: NDArray[np.float64]
    toe_static: NDArray[np.float64]
    toe_gain: NDArray[np.float64]
    camber_static: NDArray[np.float64]
    camber_gain: NDArray[np.float64]


def suspension(vehicle: Vehicle) -> Suspension:
    """The four suspensions of a vehicle. The preload acts along the inclined axis and so carries its cosine."""
    load = np.repeat(vehicle.static_sprung_load(), 2)
    lean = np.array([1.0 / np.sqrt(1.0 + a.axis_lateral**2 + a.axis_forward**2) for a in vehicle.axles])

    joint = np.array([joint_damping(axle) for axle in vehicle.axles])

    def each(name: str) -> NDArray[np.float64]:
        return np.array([getattr(axle, name) for axle in vehicle.axles])

    return Suspension(
        load * lean, each("spring_rate"), each("spring_progression"), each("damping_compression"),
        each("damping_rebound"), joint, each("bump_clearance"), each("rebound_clearance"), each("stop_rate"),
        each("toe_static"), each("toe_gain"), each("camber_static"), each("camber_gain"),
    )  # fmt: skip


@inlined
def strut_force(s, w, travel, rate):
    """Force [N] that pushes wheel w down and the body up, without the travel joint's own; travel [m], rate [m/s]."""
    force = s.preload[w] + (s.rate[w] + s.progression[w] * travel * travel) * travel
    force += ((s.compression[w] if rate > 0.0 else s.rebound[w]) - s.joint[w]) * rate
    bump = travel - s.bump_clearance[w]
    if bump > 0.0:
        force += s.stop_rate[w] * bump * bump
    rebound = -travel - s.rebound_clearance[w]
    if rebound > 0.0:
        force -= s.stop_rate[w] * rebound * rebound
    return force
