"""Claims about braking: distance at the friction limit, anti-lock control, standing still."""

from __future__ import annotations

import numpy as np
import pytest

from estimators.drive_log import WHEELS
from models.tyre_properties import load_tyre
from models.vehicle import AIR_DENSITY, load_vehicle
from testbed.brakes import braking_peak
from testbed.tyre.magic_formula import slip_forces
from tests.drives import Driven, drive

KMH = 1.0 / 3.6
DISTANCE_TOLERANCE = 0.05  # the 0.15 s until the tyres reach their peak cost 3 % at friction 1
SLIP_TOLERANCE = 0.015  # the control takes the nominal rolling radius, which load and speed change by 1 %
LOCKED = 0.3  # slip; the peak lies at 0.12, a locked wheel at 1
CREEP = 1e-3  # m within 10 s
ROCKING = 4.0  # s after which a car that stopped at the limit has stopped rocking on its tyres and bushes
SPRING_BACK = 5e-3  # m that the tyres and bushes give when the brakes let go on a slope


@pytest.fixture(scope="module", params=["1.0", "0.5", "0.2"])
def stop(request) -> Driven:
    mu = float(request.param)
    duration = 1.0 + 3.0 / mu + ROCKING + 10.0  # s: 3 s to stop from 100 km/h at friction 1
    return drive(road="flat", manoeuvre="brake", speed=100 * KMH, duration=duration, friction=request.param)


def standstill(driven: Driven) -> int:
    """Row in which the car first stands."""
    return int(np.argmax(driven["velocity"][:, 0] <= 0.0))


def test_braking_distance_is_that_of_the_tyres_peak_friction(stop, claim):
    """v^2/(2 mu g) with the Magic Formula's own peak at the loads during braking, and air drag: the integral of
    m v dv / (F + k v^2)."""
    first, last = int(np.searchsorted(stop["time"], 1.0)), standstill(stop)
    settled = slice(first + 400, last - 400)
    loads = stop["load"][settled].mean(axis=0)
    friction = stop.simulation.constants.friction_left[0]
    grip = sum(braking_peak(stop.simulation.tyre, fz, friction)[1] * fz for fz in loads)
    car = load_vehicle()
    air = 0.5 * AIR_DENSITY * car.chassis.frontal_area * car.chassis.drag_coefficient
    speed = stop["velocity"][first, 0]
    ideal = car.mass / (2.0 * air) * np.log1p(air * speed**2 / grip)
    driven = stop["position"][last, 0] - stop["position"][first, 0]
    what = "braking distance above the tyres' peak friction, friction 1, 0.5, 0.2"
    claim(what, 100.0 * (driven / ideal - 1.0), 100.0 * DISTANCE_TOLERANCE, "%")


def test_no_wheel_locks_above_10_kmh(stop):
    speed = stop["velocity"][:, 0]
    rolling = (speed > 10 * KMH) & (stop["time"] > 1.0)
    slip = 1.0 - stop["rim_speed"][rolling] * stop.simulation.nominal_radius / speed[rolling, None]
    assert slip.max() < LOCKED
    assert slip[-1].max() > 0.01  # they do brake


def test_anti_lock_control_keeps_the_front_wheels_at_the_slip_of_the_tyres_peak(stop):
    """The slip of the peak falls in proportion to friction; the control is not told the friction."""
    first, last = int(np.searchsorted(stop["time"], 1.0)), standstill(stop)
    settled = slice(first + 600, last - 600)
    load = stop["load"][settled, 0].mean()
    best = braking_peak(stop.simulation.tyre, load, stop.simulation.constants.friction_left[0])[0]
    assert -stop["slip_ratio"][settled, :2].mean() == pytest.approx(best, abs=SLIP_TOLERANCE)


def test_braked_car_does_not_creep(stop):
    still = stop["position"][standstill(stop) + round(ROCKING / 1e-3) :, 0]
    assert len(still) > 9000
    assert np.ptp(still[:10000]) < CREEP


@pytest.mark.parametrize("grade", [0.05, -0.05])
def test_stops_on_a_slope_stand_and_pull_away_without_rolling_back(grade):
    run = drive(road="flat", manoeuvre="stops", speed=6.0, duration=45.0, grade=grade)
    plan = run.simulation.constants.plan
    wanted = plan.speed[(run["time"] / 0.01 + 1e-6).astype(int)]
    stands = np.flatnonzero(np.diff((wanted <= 0.0).astype(int), prepend=0))
    assert len(stands) >= 4  # stand, drive, stand, drive
    begin, end = stands[2], stands[3]
    moved = run["position"][begin + 2000 : end, 0]
    assert np.ptp(moved) < CREEP
    away = run["position"][end : end + 2000, 0]
    assert away.min() - away[0] > -SPRING_BACK
    assert away[-1] - away[0] > 0.1


@pytest.mark.parametrize("friction", [1.0, 0.5, 0.25])
def test_peak_slip_and_friction_scale_together(friction):
    """What lets the anti-lock control find the peak without knowing the friction."""
    tyre = load_tyre()
    slip, peak = braking_peak(tyre, tyre.fz0)
    scaled_slip, scaled_peak = braking_peak(tyre, tyre.fz0, friction)
    assert scaled_peak == pytest.approx(friction * peak, rel=0.01)
    assert scaled_slip == pytest.approx(friction * slip, rel=0.03)
    q = tyre.slip_array()
    for other in (0.8 * slip, 1.2 * slip):
        assert -slip_forces(q, -other, 0.0, 0.0, tyre.fz0, tyre.p0, tyre.v0, 1.0, 1.0)[0] < peak * tyre.fz0


def test_braking_on_unequal_friction_keeps_the_car_upright_and_near_its_path():
    """Right wheels on 0.3: finite, less than 10 degrees of yaw, within half a lane."""
    stop = drive(road="flat", manoeuvre="brake", speed=100 * KMH, duration=8.0, friction="1.0/0.3")
    assert np.isfinite(stop.rows).all()
    yaw = 2.0 * np.arctan2(stop["quaternion"][:, 3], stop["quaternion"][:, 0])
    assert np.abs(yaw).max() < np.radians(10.0)
    assert np.abs(stop["path_error"]).max() < 1.75
    assert stop["velocity"][-1, 0] < 0.1


def test_braking_moves_load_forward_as_statics_say():
    """Transfer per axle (F h + J a / R - My) / L, the slowing wheels' spin and rolling resistance included. A tyre's
    force acts on its wheel with the lever Re, so h counts from Re less the loaded radius below the road. Left out
    (2.5 %): the body's weight comes forward as it dives and as the hubs give way."""
    stop = drive(road="flat", manoeuvre="brake", speed=100 * KMH, duration=3.6)
    steady = slice(2000, 3500)
    car, tyre = load_vehicle(), load_tyre()
    mass = car.mass
    wheels = sum(axle.wheel_assembly_mass for axle in car.axles)
    radius, force = stop["rolling_radius"][steady].mean(axis=0), -stop["fx"][steady].mean(axis=0)
    loaded = tyre.r0 * tyre.q_re0 - stop["deflection"][steady].mean(axis=0)
    height = (car.chassis.mass * car.chassis.cg_height + wheels * loaded.mean()) / mass
    moment = force @ (height + radius - loaded)
    slowing = -np.polyfit(stop["time"][steady], stop["velocity"][steady, 0], 1)[0]
    spin = sum(axle.spin_inertia + tyre.belt_iyy for axle in car.axles)
    moment += spin * slowing / radius.mean() - stop["drag_moment"][steady].sum(axis=1).mean()
    transfer = moment / car.wheelbase
    front, rear = car.static_wheel_load()
    loads = stop["load"][steady].mean(axis=0)
    assert loads[:2].sum() - 2.0 * front == pytest.approx(transfer, rel=0.05)
    assert 2.0 * rear - loads[2:].sum() == pytest.approx(transfer, rel=0.05)
    assert loads[0] == pytest.approx(loads[1], rel=1e-6)
    assert len(loads) == len(WHEELS)
