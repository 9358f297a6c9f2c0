"""Claims about the car at rest and on its springs: loads, deflection, rolling radius, body and wheel-hop
frequencies."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from models.tyre_properties import load_tyre
from models.vehicle import GRAVITY, load_vehicle
from testbed.modes import modes
from testbed.simulation import Diverged
from testbed.tyre import vertical
from tests.drives import drive, everywhere, settled

KMH = 1.0 / 3.6
WEIGHT_TOLERANCE = 1e-3
LAW_TOLERANCE = 1e-2
MODE_TOLERANCE = 3e-2
PRESSURES = (150e3, 200e3, 250e3, 300e3, 350e3)  # Pa, all above p0/2, where the published law holds


@pytest.mark.parametrize("payload", [0.0, 400.0])
def test_static_wheel_loads_sum_to_weight(payload, claim):
    car = settled(speed=0.0, payload=payload)
    weight = (car.vehicle.mass + payload) * GRAVITY
    error = car.state.outputs[:, 0].sum() / weight - 1.0
    claim("static wheel loads sum to the weight", 100.0 * abs(error), 100.0 * WEIGHT_TOLERANCE, "%")


def test_static_loads_of_front_and_rear_follow_from_the_lever_arms():
    car = settled(speed=0.0)
    front, rear = car.vehicle.static_wheel_load()
    assert car.state.outputs[:, 0] == pytest.approx([front, front, rear, rear], rel=2e-3)


def test_payload_moves_load_as_its_lever_arm_says():
    payload, behind = 300.0, -0.9
    loads = settled(speed=0.0, payload=payload, payload_position=(behind, 0.4, 0.0)).state.outputs[:, 0]
    empty = settled(speed=0.0).state.outputs[:, 0]
    gain = loads - empty
    body = load_vehicle()
    rear_share = (body.chassis.cg_to_front_axle - behind) / body.wheelbase
    assert gain[2] + gain[3] == pytest.approx(payload * GRAVITY * rear_share, rel=0.02)
    assert (gain[0] + gain[2]) > (gain[1] + gain[3])  # 0.4 m to the left loads the left


def test_car_at_rest_stays_at_rest_for_a_minute(claim):
    rest = drive(road="flat", manoeuvre="constant", speed=0.0, duration=60.0)
    moved = np.abs(rest["position"] - rest["position"][0]).max()
    claim("a car at rest stays at rest for 60 s", 1e3 * moved, 0.01, "mm")
    assert np.abs(rest["velocity"]).max() < 1e-3  # m/s
    assert np.abs(rest["velocity"][-1]).max() < 1e-7


@pytest.mark.parametrize("tyre", ["suv-235-60r18", "book-205-60r15"])
@pytest.mark.parametrize("pressure", PRESSURES)
def test_deflection_and_rolling_radius_follow_the_published_formulas(tyre, pressure, claim):
    """The multibody wheel (ring on its sidewall, residual law) against the formulas, written out here once more."""
    t = load_tyre(tyre)
    car = drive(tyre=t, road="flat", speed=60.0 * KMH, duration=3.0, pressures=everywhere(pressure))
    load, omega = car["load"][-1], car["belt_speed"][-1]
    data, rims = car.simulation.data, car.simulation.index.rim
    free = t.r0 * (t.q_re0 + t.q_v1 * (omega * t.r0 / t.v0) ** 2)
    deflection = free - data.xpos[rims, 2]  # as the multibody car stands on its flat road: rim, sidewall, belt
    dpi = (car["pressure"][-1] - t.p0) / t.p0
    ratio = deflection / t.r0
    q_fz1 = np.sqrt((t.cz0 * t.r0 / t.fz0) ** 2 - 4.0 * t.q_fz2)
    formula = (1 + t.q_v2 * omega * t.r0 / t.v0) * (q_fz1 + t.q_fz2 * ratio) * ratio * (1 + t.pfz1 * dpi) * t.fz0
    error = np.abs(load / formula - 1.0).max()
    claim("load against deflection, five pressures, two tyres", 100.0 * error, 100.0 * LAW_TOLERANCE, "%")
    cz = t.cz0 * (1 + t.pfz1 * t.re_pressure_share * dpi)
    radius = free - t.fz0 / cz * (t.dreff * np.arctan(t.breff * load / t.fz0) + t.freff * load / t.fz0)
    # measured: the way of a freely rolling (rear) wheel over its angle, its slip of 0.05 % at rolling resistance apart
    way = car["position"][-1, 0] - car["position"][-1001, 0]
    turned = car["rim_angle"][-1, 2:] - car["rim_angle"][-1001, 2:]
    error = np.abs(way / turned / radius[2:] - 1.0).max()
    claim("rolling radius, five pressures, two tyres", 100.0 * error, 100.0 * LAW_TOLERANCE, "%")
    assert way / turned == pytest.approx(radius[2:] * (1.0 - car["slip_ratio"][-1, 2:]), rel=1e-4)


@pytest.mark.parametrize("pressure", PRESSURES)
def test_reported_stiffness_is_the_slope_of_the_load_law(pressure):
    law = vertical.vertical_law(load_tyre())
    amplitude = vertical.load_amplitude(law, vertical.pressure_factor(law, pressure), 60.0, 0.0, 0.0)
    at, step = vertical.deflection(law, amplitude, 5000.0), 1e-6
    slope = (vertical.load(law, amplitude, at + step) - vertical.load(law, amplitude, at - step)) / (2.0 * step)
    assert vertical.stiffness(law, amplitude, 5000.0) == pytest.approx(slope, rel=1e-6)
    assert vertical.load(law, amplitude, at) == pytest.approx(5000.0, rel=1e-12)


def test_stiffness_at_nominal_pressure_and_load_is_that_of_the_seed():
    law = vertical.vertical_law(load_tyre())
    assert vertical.mean_stiffness(law, 250e3, 0.0, law.fz0) == pytest.approx(264700.0, rel=1e-9)


@pytest.mark.parametrize("sidewall", [5e5, 2e6, 1e8])
def test_ring_on_its_sidewall_gives_the_total_law(sidewall):
    law = vertical.vertical_law(load_tyre())
    for total in (0.002, 0.01, 0.02, 0.03):
        fz = vertical.load(law, 1.0, total)
        assert vertical.load_behind_sidewall(law, 1.0, total - fz / sidewall, sidewall) == pytest.approx(fz, rel=1e-9)


def test_a_quarter_less_pressure_shrinks_the_rolling_radius_as_on_real_cars(claim):
    low, full = (
        drive(road="flat", speed=80 * KMH, duration=2.0, pressures=everywhere(p))["rolling_radius"][-1]
        for p in (0.75 * 250e3, 250e3)
    )
    change = 100.0 * (low / full - 1.0)
    assert np.all(np.abs(change + 0.25) <= 0.05)
    claim("rolling radius falls by 0.25 % for 25 % less pressure", np.abs(change + 0.25).max(), 0.05, "% of radius")


def _quarter_car(sprung, unsprung, spring, damper, tyre):
    """Natural frequencies [Hz] of the damped quarter car, body then wheel hop."""
    system = np.array([
        [0, 0, 1, 0], [0, 0, 0, 1],
        [-spring / sprung, spring / sprung, -damper / sprung, damper / sprung],
        [spring / unsprung, -(spring + tyre) / unsprung, damper / unsprung, -damper / unsprung],
    ])  # fmt: skip
    return sorted({round(abs(v) / (2 * np.pi), 9) for v in np.linalg.eigvals(system)})


@pytest.mark.parametrize("speed", [0.0, 80.0 * KMH])
def test_body_and_wheel_hop_frequencies_are_those_of_the_quarter_car(speed, claim):
    """Axes upright and dampers symmetric, as the quarter car has them; masses, springs, tyres and payload-free body as
    in the car. With dynamic index 1 front and rear are uncoupled. What is left of the 3 %: the belt moves 0.88 of the
    hub's way (1.7 % in the wheel hop)."""
    v = load_vehicle()

    def plain(axle):
        return dataclasses.replace(
            axle, damping_rebound=3000.0, damping_compression=3000.0, axis_forward=0.0, axis_lateral=0.0
        )

    car = settled(vehicle=dataclasses.replace(v, front=plain(v.front), rear=plain(v.rear)), speed=speed)
    found = modes(car)
    heave, pitch = 2, 4  # of the free joint
    for axle, wheels, load in ((v.front, (0, 1), 0), (v.rear, (2, 3), 1)):
        sprung = v.static_sprung_load()[load] / GRAVITY
        stiffness = car.state.outputs[wheels[0], 2]
        body, hop = _quarter_car(sprung, axle.wheel_assembly_mass, axle.spring_rate, 3000.0, stiffness)
        travels = [int(car.index.travel_v[w]) for w in wheels]
        bodies = [m for m in found if m.shares[heave] + m.shares[pitch] > 0.8]
        assert len(bodies) == 2
        above = v.chassis.cg_to_front_axle if load == 0 else -v.chassis.cg_to_rear_axle
        own = max(bodies, key=lambda m: abs(m.shape[heave] - above * m.shape[pitch]))  # moves most over this axle
        hops = [m for m in found if m.shares[travels].sum() > 0.7 and np.real(np.prod(m.shape[travels])) != 0.0]
        together = [m for m in hops if np.real(m.shape[travels[0]] * np.conj(m.shape[travels[1]])) > 0.0]
        assert len(together) == 1
        error = abs(own.frequency / body - 1.0)
        claim("body frequency against the quarter car", 100.0 * error, 100.0 * MODE_TOLERANCE, "%")
        error = abs(together[0].frequency / hop - 1.0)
        claim("wheel-hop frequency against the quarter car", 100.0 * error, 100.0 * MODE_TOLERANCE, "%")


def test_a_car_that_rolls_over_ends_its_drive_in_one_line():
    with pytest.raises(Diverged, match=r"rolled over at .* road H at 30 km/h is more than it can take"):
        drive(road="H", speed=30.0 * KMH, duration=20.0)
