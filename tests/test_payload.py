"""Load of each axle from body and hubs: a linear two-axle car of known mass over noise, and what must not move it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from estimators.car import GRAVITY, Car
from estimators.vertical_pressure.anti_alias import RATE
from estimators.vertical_pressure.bank import SENSOR_STD, laden
from estimators.vertical_pressure.intake import BLOCK
from estimators.vertical_pressure.payload import _SECTIONS, LEAK, PRIOR_STD, SYSTEMATIC, Payload, pass_filters
from tests.chain_drives import ALONE, QUARTER

CAR = Car()
SECONDS = 20.0
SHRUNK = PRIOR_STD**2 / (PRIOR_STD**2 + SYSTEMATIC**2)


def ridden(mass: float, forward: float, seed: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Hub and body accelerations (n, 4) of a rigid body on the maker's struts, whose hubs are moved by noise; forward:
    how far the centre of gravity has moved [m]. Symplectic steps of a quarter of a millisecond."""
    rng = np.random.default_rng(seed)
    fine, n = 4, round(SECONDS * RATE)
    dt = 1.0 / (fine * RATE)
    x = np.array([CAR.cg_to_front_axle - forward, -(CAR.cg_to_rear_axle + forward)])
    k, c = (
        2.0 * np.array([CAR.front_spring_rate, CAR.rear_spring_rate]),
        2.0 * np.array([CAR.front_damping, CAR.rear_damping]),
    )
    inertia = 1.1 * mass * CAR.cg_to_front_axle * CAR.cg_to_rear_axle
    z, v, hub_z, hub_v = np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2)
    hub, body = np.empty((n, 2)), np.empty((n, 2))
    drive = rng.standard_normal((n, 2)) * 12.0
    for t in range(n):
        felt, sprung = np.zeros(2), np.zeros(2)
        for _ in range(fine):
            a_hub = drive[t] - 2.0 * 20.0 * hub_v - 400.0 * hub_z
            force = k * (hub_z - (z[0] + x * z[1])) + c * (hub_v - (v[0] + x * v[1]))
            a = np.array([force.sum() / mass, (force @ x) / inertia])
            felt += a_hub / fine
            sprung += (a[0] + x * a[1]) / fine
            v, hub_v = v + dt * a, hub_v + dt * a_hub
            z, hub_z = z + dt * v, hub_z + dt * hub_v
        hub[t], body[t] = felt, sprung
    noise = SENSOR_STD * rng.standard_normal((2, n, 4))
    return np.repeat(hub, 2, axis=1) + GRAVITY + noise[0], np.repeat(body, 2, axis=1) + GRAVITY + noise[1]


def heard(hub: NDArray[np.float64], body: NDArray[np.float64]) -> Payload:
    payload = Payload(CAR)
    for first in range(0, len(hub) - BLOCK + 1, BLOCK):
        payload.block(hub[first : first + BLOCK], body[first : first + BLOCK])
    return payload


@pytest.mark.parametrize(("more", "forward"), [(1.0, 0.0), (1.24, 0.0), (1.2, -0.15)])
def test_load_of_each_axle_is_found_whatever_moves_the_hubs(more: float, forward: float) -> None:
    payload = heard(*ridden(more * CAR.chassis_mass, forward))
    total, a, b = more**SHRUNK, CAR.cg_to_front_axle, CAR.cg_to_rear_axle
    wanted = total * (1.0 + SHRUNK * forward / b), total * (1.0 - SHRUNK * forward / a)
    assert payload.load == pytest.approx(wanted, rel=0.03)  # noise leaves 1 % of mass, 2 cm of its place
    assert SYSTEMATIC * 0.9 < payload.std < 1.3 * SYSTEMATIC


def test_what_the_struts_do_not_explain_tells_no_load() -> None:
    hub, body = ridden(1.24 * CAR.chassis_mass, 0.0)
    body[:, 1] = GRAVITY  # stuck
    assert heard(hub, body).load == (1.0, 1.0)
    assert heard(hub, np.full_like(body, np.nan)).std == PRIOR_STD
    assert heard(np.full_like(hub, GRAVITY), np.full_like(body, GRAVITY)).std == PRIOR_STD


def test_kernel_is_the_plain_filter_chain() -> None:
    from scipy.signal import lfilter, sosfilt

    rng = np.random.default_rng(2)
    force, damping, heave, pitch = rng.standard_normal((4, 600))
    keeps, dt = np.exp(-2.0 * np.pi * LEAK / RATE), 1.0 / RATE

    def twice(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return lfilter([dt], [1.0, -keeps], lfilter([dt], [1.0, -keeps], x))

    def rate(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.diff(x, prepend=0.0) / dt

    plain = [rate(rate(twice(heave))), rate(rate(twice(pitch))), twice(force) + rate(twice(damping))]
    rows = np.array([sosfilt(_SECTIONS, x) for x in plain])[:, 100:]
    memory, settling, sums = np.zeros((9, 2 * len(_SECTIONS))), np.full(1, 100), np.zeros((3, 3))
    for part in (slice(0, 256), slice(256, 600)):  # a stretch cut anywhere
        pass_filters(_SECTIONS, keeps, force[part], damping[part], heave[part], pitch[part], memory, settling, sums)
    assert sums == pytest.approx(rows @ rows.T, rel=1e-9)


def test_a_laden_corner_has_the_load_s_mass_and_footprint_and_none_changes_nothing() -> None:
    assert laden(QUARTER, ALONE, 1.0) == (QUARTER, ALONE)
    heavy, other = laden(QUARTER, ALONE, 1.3)
    assert heavy.sprung_mass == pytest.approx(1.3 * QUARTER.sprung_mass)
    assert 1.0 < heavy.footprint / QUARTER.footprint < 1.3**QUARTER.softer
    assert other.quarter.sprung_mass == pytest.approx(1.3 * ALONE.quarter.sprung_mass)
