"""The nonlinear quarter car: a body quarter and a wheel on a point-contact tyre.

Brancati & Tufano, Machines 2022, 10, 1221, eq. 1, with its damping corrected. Heights up, zero at rest under the static
load; travel x = z_us - z_s and its rate v (compression positive):

    F          = k x + k3 x^3 + c v + c2 |v| v            force of the suspension, up on the body [N]
    m_s  a_s   =  F
    m_us a_us  = -F - k_t (z_us - z_r)

The published c2 v^2 is even and has the same sign on both masses: it pushes the car up at any motion, and no momentum
balance holds. State [z_s, z_us, v_s, v_us], m and m/s. Left out: tyre damping, wheel lift, stops, unequal compression
and rebound, the other three corners.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.compiled import compiled, inlined
from estimators.drive_log import WHEELS

Z_S, Z_US, V_S, V_US = range(4)


class QuarterCar(NamedTuple):
    """m_s, m_us [kg], k [N/m], k3 [N/m^3], c [N s/m], c2 [N s^2/m^2]."""

    sprung_mass: float
    unsprung_mass: float
    spring_rate: float
    spring_progression: float
    damping: float
    quadratic_damping: float


# Table 3 of the paper (c, c2, k, k3), classes A to D; not physical: the damping ratio is about 1 on C and D
PUBLISHED = {
    "A": (6576.0, 4319.0, 113_086.0, 130_098.0),
    "B": (4585.0, 6016.0, 173_415.0, 151_886.0),
    "C": (14_819.0, 5839.0, 94_544.0, 62_836.0),
    "D": (14_708.0, 4555.0, 118_114.0, 121_723.0),
}


def quarter_masses(car: Car, wheel: str, load: float = 0.0) -> tuple[float, float]:
    """m_s (eq. 2: the share of the body that the axle carries, halved) and m_us of a wheel [kg]; load: payload over
    the centre of gravity [kg]."""
    front = WHEELS.index(wheel) < 2
    opposite = car.cg_to_rear_axle if front else car.cg_to_front_axle
    unsprung = car.front_wheel_mass if front else car.rear_wheel_mass
    return 0.5 * (car.chassis_mass + load) * opposite / car.wheelbase, unsprung


def published_quarter_car(car: Car, wheel: str, road_class: str) -> QuarterCar:
    """The car's masses with Table 3's suspension. KeyError for a class that the table does not have."""
    sprung, unsprung = quarter_masses(car, wheel)
    damping, quadratic, rate, progression = PUBLISHED[road_class]
    return QuarterCar(sprung, unsprung, rate, progression, damping, quadratic)


@inlined
def accelerations(q, z_s, z_us, v_s, v_us, tyre_stiffness, road):
    """(a_s, a_us) [m/s^2]; q: QuarterCar; road: height z_r [m]; tyre_stiffness k_t [N/m]."""
    x, v = z_us - z_s, v_us - v_s
    force = (q.spring_rate + q.spring_progression * x * x) * x + (q.damping + q.quadratic_damping * abs(v)) * v
    return force / q.sprung_mass, (-force - tyre_stiffness * (z_us - road)) / q.unsprung_mass


@compiled
def rk4_step(q, state, tyre_stiffness, road_0, road_half, road_1, dt):
    """State after dt [s] by the classical Runge-Kutta method; road heights at the start, the middle, the end [m]."""
    out = state.copy()
    slope = np.empty(4)
    stage = state.copy()
    for part in range(4):
        road = road_0 if part == 0 else (road_1 if part == 3 else road_half)
        a_s, a_us = accelerations(q, stage[Z_S], stage[Z_US], stage[V_S], stage[V_US], tyre_stiffness, road)
        slope[Z_S], slope[Z_US], slope[V_S], slope[V_US] = stage[V_S], stage[V_US], a_s, a_us
        weight = dt / 6.0 if part in (0, 3) else dt / 3.0
        reach = dt if part == 2 else 0.5 * dt
        for i in range(4):
            out[i] += weight * slope[i]
            stage[i] = state[i] + reach * slope[i]
    return out


@compiled
def _ride(q, road, tyre_stiffness, dt):
    steps = (len(road) - 1) // 2
    states, felt = np.empty((steps + 1, 4)), np.empty((steps + 1, 2))
    state = np.array([road[0], road[0], 0.0, 0.0])
    for k in range(steps + 1):
        states[k] = state
        felt[k, 0], felt[k, 1] = accelerations(
            q, state[Z_S], state[Z_US], state[V_S], state[V_US], tyre_stiffness[k], road[2 * k]
        )
        if k < steps:
            state = rk4_step(q, state, tyre_stiffness[k], road[2 * k], road[2 * k + 1], road[2 * k + 2], dt)
    return states, felt


def ride(
    q: QuarterCar, road: NDArray[np.float64], tyre_stiffness: NDArray[np.float64] | float, dt: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The quarter car over a road from rest: states (n, 4) and accelerations [a_s, a_us] (n, 2), every dt [s].

    road: heights z_r [m] every dt/2, shape (2 n - 1,). tyre_stiffness: [N/m], a number or (n,). ValueError for an even
    number of heights.
    """
    if len(road) % 2 == 0:
        raise ValueError(f"road has {len(road)} heights, want an odd number: one every half step")
    steps = (len(road) - 1) // 2 + 1
    stiffness = np.ascontiguousarray(np.broadcast_to(np.asarray(tyre_stiffness, float), (steps,)))
    return _ride(q, np.ascontiguousarray(road, dtype=float), stiffness, dt)
