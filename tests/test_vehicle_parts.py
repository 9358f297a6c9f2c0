"""Claims about the parts of the car, each against its own written-out law: struts, anti-roll bars, steering, brakes,
payload, suspension kinematics, friction, and the numbers' plausibility."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from estimators.compiled import compiled
from models.vehicle import GRAVITY, SUV, load_vehicle
from testbed.driver import ackermann, driver_car
from testbed.roads.friction import friction_at, parse_friction
from testbed.suspension import strut_force, suspension
from tests.drives import drive, settled

EXACT = 1e-12
LIFT = 0.03  # of a load: what the side forces of toe and camber, on inclined axes, carry of it (2 %)
KMH = 1.0 / 3.6


@compiled
def strut(s, w, travel, rate):
    return strut_force(s, w, travel, rate)


@compiled
def axes(car, angle):
    return ackermann(car, angle)


@compiled
def grip(x, y, edges, left, right):
    return friction_at(x, y, edges, left, right)


@pytest.mark.parametrize("wheel", range(4))
def test_strut_force_is_spring_damper_and_stops_as_published_shapes_say(wheel):
    """F0 + k x + k3 x^3 + c(v) v + stops, written out from the numbers of the TOML file; the joint's own part of the
    damping is the quarter of both dampers' sum."""
    v = load_vehicle()
    axle = v.axles[wheel]
    arm = v.chassis.cg_to_rear_axle if wheel < 2 else v.chassis.cg_to_front_axle
    weight = v.chassis.mass * GRAVITY * arm / (2.0 * v.wheelbase)
    preload = weight / math.sqrt(1.0 + axle.axis_lateral**2 + axle.axis_forward**2)
    joint = 0.25 * (axle.damping_compression + axle.damping_rebound)
    for travel in (-0.12, -0.091, -0.05, 0.0, 0.03, 0.069, 0.08, 0.11):
        for rate in (-1.0, -0.1, 0.0, 0.1, 1.0):
            wanted = preload + axle.spring_rate * travel + axle.spring_progression * travel**3
            wanted += (axle.damping_compression if rate > 0.0 else axle.damping_rebound) * rate - joint * rate
            if travel > axle.bump_clearance:
                wanted += axle.stop_rate * (travel - axle.bump_clearance) ** 2
            if travel < -axle.rebound_clearance:
                wanted -= axle.stop_rate * (travel + axle.rebound_clearance) ** 2
            assert strut(suspension(v), wheel, travel, rate) == pytest.approx(wanted, rel=EXACT)
    assert axle.damping_rebound > axle.damping_compression  # the asymmetry is there
    assert axle.spring_progression > 0.0


def test_payload_compresses_the_springs_by_their_own_rate():
    """Travel under a load over the rear axle, against k x + k3 x^3. The car rolls: standing tyres would hold the wheels
    from moving outward on their inclined axes, and carry a tenth of the load so."""
    v, payload = load_vehicle(), 300.0
    position = (-v.chassis.cg_to_rear_axle, 0.0, 0.0)
    empty = settled(speed=40.0 * KMH).data.qpos
    car = settled(speed=40.0 * KMH, payload=payload, payload_position=position)
    travel = car.data.qpos[car.index.travel_q[2:]] - empty[car.index.travel_q[2:]]
    start = empty[car.index.travel_q[2:]]
    axle = v.rear
    lean = 1.0 / math.sqrt(1.0 + axle.axis_lateral**2 + axle.axis_forward**2)

    def force(x):
        return axle.spring_rate * x + axle.spring_progression * x**3

    wanted = 0.5 * payload * GRAVITY * lean
    assert force(start + travel) - force(start) == pytest.approx([wanted, wanted], rel=LIFT)


def test_anti_roll_bars_push_against_a_difference_of_travel():
    """Twice the rate on the difference coordinate: the generalised force that MuJoCo has for the two travels."""
    v = load_vehicle()
    car = settled(speed=0.0)
    for axle, wheels in ((v.front, (0, 1)), (v.rear, (2, 3))):
        data = mujoco.MjData(car.model)
        data.qpos[:] = car.data.qpos
        mujoco.mj_forward(car.model, data)
        before = data.qfrc_passive[car.index.travel_v].copy()
        data.qpos[car.index.travel_q[wheels[0]]] += 0.01
        data.qpos[car.index.travel_q[wheels[1]]] -= 0.01
        mujoco.mj_forward(car.model, data)
        change = data.qfrc_passive[car.index.travel_v] - before
        assert change[list(wheels)] == pytest.approx(
            [-0.02 * axle.anti_roll_rate, 0.02 * axle.anti_roll_rate], rel=1e-6
        )


@pytest.mark.parametrize("angle", [-0.5, -0.1, 0.02, 0.4])
def test_steered_wheels_turn_about_one_point_on_the_rear_axles_line(angle):
    car = settled(speed=0.0)
    known = driver_car(car.vehicle, car.tyre, car.payload, car.nominal_radius, "front")
    left, right = axes(known, angle)
    radius = known.wheelbase / math.tan(angle)
    assert known.wheelbase / math.tan(left) + 0.5 * known.front_track == pytest.approx(radius, rel=EXACT)
    assert known.wheelbase / math.tan(right) - 0.5 * known.front_track == pytest.approx(radius, rel=EXACT)
    assert abs(left) != abs(right)


def test_brake_torque_is_split_between_the_axles_as_the_car_says():
    """Gentle braking (2 m/s^2) on a flat road, the wheels' own inertia and drag apart."""
    run = drive(road="flat", manoeuvre="stops", speed=60.0 * KMH, duration=30.0)
    slowing = np.flatnonzero((np.gradient(run["velocity"][:, 0], 1e-3) < -1.2) & (run["velocity"][:, 0] > 5.0))
    assert len(slowing) > 1000
    v, force = load_vehicle(), -run["fx"][slowing].mean(axis=0)
    drag = run["drag_moment"][slowing].mean(axis=0) / run["rolling_radius"][slowing].mean(axis=0)
    spin = np.array([a.spin_inertia + run.simulation.tyre.belt_iyy for a in v.axles])
    spin = spin * np.gradient(run["rim_speed"], 1e-3, axis=0)[slowing].mean(axis=0) / 0.36
    braked = force + spin  # what is left is the brake's, and the engine's on the driven front axle
    assert braked[2:].sum() > 300.0
    overrun = v.driveline.overrun_torque * np.mean(v.driveline.gear_ratios) / 0.36
    share = v.rear.brake_share
    total = braked.sum()
    assert braked[2:].sum() == pytest.approx(share * total, abs=share * overrun + drag.sum())


def test_payload_enters_mass_centre_and_inertia_as_a_solid_box():
    """Against the parallel axis theorem, from MuJoCo's own composite body."""
    mass, place = 350.0, np.array([-0.9, 0.3, 0.5])
    empty, loaded = (
        settled(speed=0.0, **fields) for fields in ({}, {"payload": mass, "payload_position": tuple(place)})
    )
    box = np.array(loaded.payload.size)

    def chassis(car):
        data = mujoco.MjData(car.model)
        mujoco.mj_forward(car.model, data)
        full = np.zeros((car.model.nv, car.model.nv))
        for row, unit in zip(full, np.eye(car.model.nv), strict=True):
            mujoco.mj_mulM(car.model, data, row, unit)
        return full[:6, :6]

    change = chassis(loaded) - chassis(empty)
    assert np.diag(change)[:3] == pytest.approx([mass] * 3, rel=1e-9)
    own = mass / 12.0 * np.array([box[1] ** 2 + box[2] ** 2, box[0] ** 2 + box[2] ** 2, box[0] ** 2 + box[1] ** 2])
    steiner = mass * (place @ place * np.eye(3) - np.outer(place, place))
    # the free joint turns about the body's frame, which lies at the unloaded chassis' centre of gravity
    assert change[3:, 3:] == pytest.approx(np.diag(own) + steiner, rel=1e-6, abs=1e-6)


def test_camber_and_toe_follow_travel_and_mirror_left_and_right():
    """A heavier car sinks: wheels lean in at the top, the front toes out, the rear in."""
    v = load_vehicle()
    light = settled(speed=60.0 * KMH)
    heavy = settled(speed=60.0 * KMH, payload=400.0, payload_position=(0.0, 0.0, 0.0))
    sunk = heavy.data.qpos[heavy.index.travel_q] - light.data.qpos[light.index.travel_q]
    turned = heavy.model.qpos_spring[heavy.index.steer_q] - light.model.qpos_spring[light.index.steer_q]
    assert sunk.min() > 0.01
    gains = np.array([a.toe_gain for a in v.axles])
    sides = np.array([1.0, -1.0, 1.0, -1.0])
    assert turned == pytest.approx(-sides * gains * sunk, rel=1e-2, abs=1e-6)


def test_friction_is_that_of_the_side_and_the_section():
    grid = parse_friction("0.9:100,0.8/0.2:50,0.5")
    arrays = grid.edges, grid.left, grid.right
    for x, y, wanted in ((-5, 1, 0.9), (99, -1, 0.9), (101, 1, 0.8), (149, -1, 0.2), (151, -1, 0.5), (1e4, 1, 0.5)):
        assert grip(float(x), float(y), *arrays) == wanted


@pytest.mark.parametrize(
    ("line", "wrong", "complaint"),
    [("yaw_inertia = { value = 3230.0", "yaw_inertia = { value = 2800.0", "none may exceed"),
     ("spin_inertia = { value = 0.75", "spin_inertia = { value = 1.3", "more than 22 kg within")],
)  # fmt: skip
def test_inertias_that_no_body_can_have_are_refused(tmp_path: Path, line, wrong, complaint):
    text = SUV.read_text()
    assert line in text
    (tmp_path / "car.toml").write_text(text.replace(line, wrong))
    with pytest.raises(ValueError, match=complaint):
        load_vehicle(tmp_path / "car.toml")
    assert dataclasses.astuple(load_vehicle(SUV))
