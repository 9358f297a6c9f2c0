"""Claims about cornering: the steady circle against the single-track closed form, roll, load transfer, symmetry, order
of the integration."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from models.tyre_properties import load_tyre
from models.vehicle import GRAVITY, Payload, load_vehicle
from testbed.manoeuvres.manoeuvre import PATH_STEP, curvature_path, driven, speed_plan
from testbed.single_track import SingleTrack, single_track
from testbed.trace import column
from testbed.tyre.magic_formula import slip_forces
from tests.drives import Driven, drive, settled

KMH = 1.0 / 3.6
CLOSED_FORM_TOLERANCE = 0.10  # the linear closed form at up to 3 m/s^2, where the tyre's curve has bent by 5 %
ROLL_TOLERANCE = 0.05
TRANSFER_TOLERANCE = 0.05
PATH_TOLERANCE = 0.10  # m
MIRROR_TOLERANCE = 1e-6
ORDER_TOLERANCE = 0.15  # forces are held over a step, so the loop is of order 1

CIRCLES = [(10.0, 1.5), (80 * KMH, 0.5), (80 * KMH, 1.5), (80 * KMH, 3.0), (35.0, 1.5)]  # m/s, m/s^2


@cache
def circle(speed: float, lateral: float, side: float = 1.0, driven_axle: str = "front") -> Driven:
    """A steady circle of the radius speed^2/lateral, entered over 3 s; side +1 to the left."""
    duration = 11.0
    car = settled(speed=speed, duration=duration, driven=driven_axle)
    along = np.arange(0.0, speed * (duration + 5.0) + 100.0, PATH_STEP)
    curvature = side * lateral / speed**2 * np.clip((along - 15.0) / (3.0 * speed), 0.0, 1.0)
    plan = driven(*speed_plan([0.0], [speed], duration), curvature_path(curvature))
    car.constants = car.constants._replace(plan=plan)
    return Driven(car)


def model() -> SingleTrack:
    return single_track(load_vehicle(), load_tyre(), Payload())


def end(run: Driven, name: str) -> np.ndarray:
    """Mean over the last second."""
    return run[name][-1000:].mean(axis=0)


def rear_slip_angle(run: Driven) -> float:
    """Angle from the body's x axis to the velocity over the rear axle at the end [rad]."""
    w, _, _, z = run["quaternion"][-1]
    heading = 2.0 * np.arctan2(z, w)
    vx, vy = run["velocity"][-1, :2]
    forward = vx * np.cos(heading) + vy * np.sin(heading)
    left = vy * np.cos(heading) - vx * np.sin(heading)
    return float(np.arctan2(left - load_vehicle().chassis.cg_to_rear_axle * run["gyro"][-1, 2], forward))


@pytest.mark.parametrize(("speed", "lateral"), CIRCLES)
def test_circle_is_driven_as_planned(speed, lateral):
    """Yaw rate v/R, lateral acceleration v^2/R, on the path."""
    run = circle(speed, lateral)
    v = np.hypot(*run["velocity"][-1, :2])
    assert v == pytest.approx(speed, rel=0.005)
    assert end(run, "gyro")[2] == pytest.approx(lateral / speed, rel=0.02)
    assert v * end(run, "gyro")[2] == pytest.approx(lateral, rel=0.02)
    assert abs(run["path_error"][-1]) < PATH_TOLERANCE


@pytest.mark.parametrize(("speed", "lateral"), CIRCLES)
def test_steering_angle_is_wheelbase_over_radius_plus_understeer(speed, lateral, claim):
    run = circle(speed, lateral)
    angle = end(run, "steering_wheel") / load_vehicle().driveline.steering_ratio
    curvature = end(run, "gyro")[2] / speed
    error = abs(angle / model().steering_angle(speed, curvature) - 1.0)
    claim("steady circle: steering angle, single-track model", 100.0 * error, 100.0 * CLOSED_FORM_TOLERANCE, "%")


@pytest.mark.parametrize(("speed", "lateral"), CIRCLES)
def test_body_side_slip_is_that_of_the_rear_axle(speed, lateral, claim):
    run = circle(speed, lateral)
    curvature = end(run, "gyro")[2] / speed
    expected = model().rear_slip_angle(speed, curvature)
    error = abs(rear_slip_angle(run) / expected - 1.0)
    claim("steady circle: side slip, single-track model", 100.0 * error, 100.0 * CLOSED_FORM_TOLERANCE, "%")


def test_understeer_gradient_is_that_of_the_tyres_and_the_suspension():
    """Without drive forces to speak of (10 m/s) the small difference of two large angles still agrees within 15 %."""
    run = circle(10.0, 1.5)
    angle = end(run, "steering_wheel") / load_vehicle().driveline.steering_ratio
    curvature, lateral = end(run, "gyro")[2] / 10.0, end(run, "gyro")[2] * 10.0
    assert (angle - model().wheelbase * curvature) / lateral == pytest.approx(model().understeer, rel=0.15)


def test_axle_cornering_stiffness_is_the_slope_of_the_tyres_side_force():
    """The closed form's front gradient without bushes, toe and camber, by a finite difference of the Magic Formula."""
    tyre, car = load_tyre(), load_vehicle()
    q, small = tyre.slip_array(), 1e-5
    load = car.static_wheel_load()[0]

    def side_force(angle: float) -> float:
        return sum(slip_forces(q, 0.0, angle, 0.0, load, tyre.p0, tyre.v0, 1.0, side)[1] for side in (1.0, -1.0))

    slope = -(side_force(small) - side_force(-small)) / (2.0 * small)
    run = circle(80 * KMH, 0.5)
    force = end(run, "fy")[:2].sum()
    angle = -end(run, "slip_angle")[:2].mean()
    assert force / angle == pytest.approx(slope, rel=0.08)  # camber thrust of the leaning wheels takes 5 %


@pytest.mark.parametrize(("speed", "lateral"), CIRCLES[1:4])
def test_body_roll_is_overturning_moment_over_roll_stiffness(speed, lateral, claim):
    run = circle(speed, lateral)
    w, x, y, z = run["quaternion"][-1]
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    error = abs(roll / (model().roll_gradient * lateral) - 1.0)
    claim("body roll in a circle", 100.0 * error, 100.0 * ROLL_TOLERANCE, "%")


@pytest.mark.parametrize(("speed", "lateral"), CIRCLES[1:4])
def test_cornering_moves_load_outward_as_statics_and_roll_stiffness_say(speed, lateral):
    """Per axle, times the track: body through the roll centre, body through the springs (split by roll stiffness in
    series with the tyres), wheels."""
    run, car, track = circle(speed, lateral), load_vehicle(), model()
    lever = car.chassis.cg_to_rear_axle / car.wheelbase, car.chassis.cg_to_front_axle / car.wheelbase
    axles = car.front, car.rear
    centres = [0.5 * axle.track * axle.axis_lateral for axle in axles]
    arm = car.chassis.cg_height - sum(s * h for s, h in zip(lever, centres, strict=True))
    series = [1.0 / (1.0 / a + 1.0 / b) for a, b in zip(track.suspension_roll, track.tyre_roll, strict=True)]
    loads = end(run, "load")
    roll = track.roll_gradient * lateral
    rolling = car.chassis.mass * arm * (lateral + GRAVITY * roll)
    for i, axle in enumerate(axles):
        moment = car.chassis.mass * lever[i] * lateral * centres[i] + rolling * series[i] / sum(series)
        moment += 2.0 * axle.wheel_assembly_mass * lateral * (load_tyre().r0 - 0.02)
        transfer = 0.5 * (loads[2 * i + 1] - loads[2 * i])
        assert transfer == pytest.approx(moment / axle.track, rel=TRANSFER_TOLERANCE)


def test_circle_to_the_right_mirrors_the_circle_to_the_left():
    left, right = circle(80 * KMH, 3.0), circle(80 * KMH, 3.0, side=-1.0)
    assert np.abs(left["position"] - right["position"] * [1, -1, 1]).max() < MIRROR_TOLERANCE
    assert np.abs(left["load"] - right["load"][:, [1, 0, 3, 2]]).max() < 1e3 * MIRROR_TOLERANCE
    assert np.abs(left["steering_wheel"] + right["steering_wheel"]).max() < MIRROR_TOLERANCE


def test_driven_rear_axle_understeers_less():
    """Drive force takes side force: on the rear axle it turns the car in."""
    front, rear = circle(35.0, 1.5), circle(35.0, 1.5, driven_axle="rear")
    assert end(rear, "steering_wheel") < end(front, "steering_wheel")
    assert end(rear, "fx")[2:].sum() > 500.0 > end(rear, "fx")[:2].sum()


def test_payload_behind_shifts_the_gradients():
    """Closed form: mass behind the middle takes understeer away; the drive agrees in sign."""
    loaded = single_track(load_vehicle(), load_tyre(), Payload(400.0, (-1.2, 0.0, 0.0)))
    assert loaded.mass == pytest.approx(model().mass + 400.0)
    assert loaded.to_rear < model().to_rear
    assert loaded.understeer < model().understeer


def test_halving_the_step_halves_the_error(claim):
    """Lane change on a flat road: successive differences between steps of 1, 0.5, 0.25 ms shrink by 2^order."""

    def at(step: float) -> np.ndarray:
        run = drive(road="flat", manoeuvre="double-lane-change", speed=80 * KMH, duration=4.0, step=step)
        return run.rows[:: round(1e-3 / step)]

    rows = [at(step) for step in (1e-3, 5e-4, 2.5e-4)]
    for name in ("position", "gyro", "load", "slip_angle", "rim_speed"):
        a, b, c = (column(r, name) for r in rows)
        order = np.log2(np.sqrt(np.mean((a - b) ** 2) / np.mean((b - c) ** 2)))
        claim("order of convergence with the step is 1", abs(order - 1.0), ORDER_TOLERANCE, "")
