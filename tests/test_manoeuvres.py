"""Claims about every manoeuvre in its folder, and about drives at the edges of what the car is asked to do."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from models.tyre_properties import load_tyre
from testbed.driver import COAST, PLAN_STEP, SPEED, STOP
from testbed.manoeuvres.manoeuvre import FASTEST, find_manoeuvre, manoeuvres
from testbed.manoeuvres.motorway import LEVELS
from testbed.manoeuvres.town import RADIUS, TURN_SPEED
from tests.drives import Driven, drive, everywhere

KMH = 1.0 / 3.6
NAMES = sorted(manoeuvres())
PATH_TOLERANCE = 0.3  # m, up to 200 km/h; the driver's model of the car is linear and of first order in time
# m: at 7 m/s^2 the tyres are near their limit and the driver runs wide; with turns too quick for his hands he cuts them
LIMIT_TOLERANCE = {"evasion": 0.6, "rapid-steering": 0.6}
SLOW_PATH_TOLERANCE = 0.08  # m, at walking speed, where the model is exact but for angles taken as small
TURN_PATH_TOLERANCE = 0.05  # m, in a town turn
SPEED_TOLERANCE = 0.3  # m/s, shifts included
HEADING_TOLERANCE = 4e-3  # rad: differences over 1 m of the slalom's shortest wave, 22 m
LONGEST_LIFT = 0.05  # s that a wheel may be off a class A road
STAND_TOLERANCE = 1e-3  # m, once the car has rocked for 2 s
TOP_SPEED_TOLERANCE = 0.01  # the engine's reserve at 200 km/h is 4 %


@cache
def run(name: str, speed: float = 80 * KMH, duration: float = 20.0, road: str = "A") -> Driven:
    return drive(road=road, manoeuvre=name, speed=speed, duration=duration)


def plan_rows(driven: Driven) -> np.ndarray:
    """Row of the speed plan at each row of the trace."""
    return (driven["time"] / PLAN_STEP + 1e-6).astype(int)


def ground_speed(driven: Driven) -> np.ndarray:
    return np.hypot(driven["velocity"][:, 0], driven["velocity"][:, 1])


def speed_error(driven: Driven) -> float:
    """Largest error of the speed while it is controlled [m/s]."""
    plan, rows = driven.simulation.constants.plan, plan_rows(driven)
    return float(np.abs((ground_speed(driven) - plan.speed[rows])[plan.mode[rows] == SPEED]).max())


def heading(driven: Driven) -> np.ndarray:
    """Unbounded yaw angle [rad]."""
    return np.unwrap(2.0 * np.arctan2(driven["quaternion"][:, 3], driven["quaternion"][:, 0]))


def test_the_named_manoeuvres_are_there():
    assert {"brake", "circle", "coast", "constant", "double-lane-change", "motorway", "slalom", "stops", "town"} <= set(
        NAMES
    )


def test_unknown_manoeuvre_names_the_valid_ones():
    with pytest.raises(ValueError, match=r"unknown manoeuvre 'drift'; valid: .*circle.*town"):
        find_manoeuvre("drift")


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("speed", [5 * KMH, 80 * KMH, 200 * KMH])
def test_plan_is_whole(name, speed):
    """Name and help are filled; arrays fit one another, the duration and the distance; speeds never exceed 200 km/h."""
    kind, duration = manoeuvres()[name], 60.0
    plan = kind.plan(speed, duration)
    assert kind.name == name
    assert len(kind.about) > 10
    assert "\n" not in kind.about
    assert len(plan.speed) == len(plan.acceleration) == len(plan.mode) >= duration / PLAN_STEP
    assert plan.path.shape[1] == 4
    assert np.isfinite(plan.speed).all()
    assert np.isfinite(plan.path).all()
    assert 0.0 <= plan.speed.min() <= plan.speed.max() <= 200 * KMH + 1e-9
    assert set(np.unique(plan.mode)) <= {SPEED, COAST, STOP}
    assert plan.path[0] == pytest.approx([0.0, 0.0, 0.0, 0.0], abs=1e-12)
    straight = np.ptp(plan.path[:, 1]) == 0.0
    assert straight or plan.path_step * len(plan.path) >= plan.speed[: round(duration / PLAN_STEP)].sum() * PLAN_STEP


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("speed", [20 * KMH, 120 * KMH])
def test_path_is_consistent(name, speed):
    """Points a step apart along the path; heading is the direction of the chords, curvature heading's derivative."""
    plan = manoeuvres()[name].plan(speed, 30.0)
    path, step = plan.path[:-2], plan.path_step
    chord = np.diff(path[:, :2], axis=0)
    assert np.hypot(chord[:, 0], chord[:, 1]) == pytest.approx(step, rel=2e-3)
    direction = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    middle = 0.5 * (path[1:, 2] + path[:-1, 2])
    assert direction == pytest.approx(middle, abs=HEADING_TOLERANCE)
    turning = np.diff(middle) / step
    assert turning == pytest.approx(path[1:-1, 3], abs=0.05 * max(np.abs(path[:, 3]).max(), 1e-3))


@pytest.mark.parametrize("name", NAMES)
def test_manoeuvre_is_driven_as_planned(name):
    driven = run(name)
    assert np.isfinite(driven.rows).all()
    assert np.abs(driven["path_error"]).max() < LIMIT_TOLERANCE.get(name, PATH_TOLERANCE)
    if (driven.simulation.constants.plan.mode == SPEED).all():
        assert speed_error(driven) < SPEED_TOLERANCE
    lifted = (driven["load"] <= 0.0).sum(axis=0) * 1e-3
    assert lifted.max() < LONGEST_LIFT


@pytest.mark.parametrize("name", NAMES)
def test_manoeuvre_at_walking_speed_and_at_200_kmh(name):
    for speed in (5 * KMH, 200 * KMH):
        driven = run(name, speed, 8.0, "flat")
        assert np.isfinite(driven.rows).all()
        allowed = SLOW_PATH_TOLERANCE if speed < 2.0 else LIMIT_TOLERANCE.get(name, PATH_TOLERANCE)
        assert np.abs(driven["path_error"]).max() < allowed
        if (driven.simulation.constants.plan.mode == SPEED).all():
            assert speed_error(driven) < max(SPEED_TOLERANCE, TOP_SPEED_TOLERANCE * speed)


def test_stops_reach_standstill_and_stand():
    driven = run("stops", 20 * KMH, 38.0)
    wanted = driven.simulation.constants.plan.speed[plan_rows(driven)]
    change = np.flatnonzero(np.diff((wanted <= 0.0).astype(int), prepend=0, append=0))
    stands = list(zip(change[::2], change[1::2], strict=True))
    assert len(stands) >= 2
    for begin, end in stands[1:]:
        still = driven["position"][begin + 2000 : end, 0]
        assert len(still) > 500
        assert np.ptp(still) < STAND_TOLERANCE
    assert ground_speed(driven).max() == pytest.approx(20 * KMH, rel=0.02)


def test_town_turns_are_right_angles_left_and_right():
    """In the plan every turn, in the drive the first: between two turns the heading is a multiple of 90 degrees."""
    path = manoeuvres()["town"].plan(30 * KMH, 120.0).path
    straight = path[np.abs(path[:, 3]) < 1e-9, 2]
    levels = np.unique(np.round(np.degrees(straight), 6))
    assert len(levels) > 1
    assert np.abs(levels - 90.0 * np.round(levels / 90.0)).max() < 1.0
    assert {-1.0, 1.0} <= set(np.sign(path[:, 3]))
    assert np.abs(path[:, 3]).max() == pytest.approx(1.0 / RADIUS, rel=1e-6)
    driven = run("town", 30 * KMH, 31.0)
    turned = np.degrees(heading(driven))
    assert np.abs(driven["path_error"]).max() < TURN_PATH_TOLERANCE
    bend = np.abs(np.interp(plan_distance(driven), 0.5 * np.arange(len(path)), path[:, 3])) > 0.5 / RADIUS
    assert turned.max() == pytest.approx(90.0, abs=2.0)
    assert ground_speed(driven)[bend].mean() == pytest.approx(TURN_SPEED, rel=0.05)


def plan_distance(driven: Driven) -> np.ndarray:
    """Distance driven since the start [m]."""
    return np.cumsum(ground_speed(driven)) * 1e-3


@pytest.mark.parametrize("speed", [60 * KMH, 130 * KMH, 200 * KMH])
def test_motorway_speed_stays_within_its_range(speed):
    plan = manoeuvres()["motorway"].plan(speed, 300.0)
    assert plan.speed.min() == pytest.approx(min(LEVELS) * speed, rel=0.01)
    assert plan.speed.max() == pytest.approx(min(max(LEVELS) * speed, FASTEST), rel=0.01)


def test_town_refuses_a_speed_at_which_it_would_not_get_on():
    with pytest.raises(ValueError, match=r"speed 0 km/h is too low for the manoeuvre town; valid: 1 to 200 km/h"):
        manoeuvres()["town"].plan(0.0, 10.0)


def test_coasting_car_is_neither_driven_nor_braked():
    driven = run("coast")
    assert (np.diff(ground_speed(driven)[::1000]) < 0.0).all()
    assert np.abs(driven["driveline_torque"][1000:]).max() < 1e-3


@pytest.mark.parametrize("road", ["flat", "A", "C"])
def test_200_kmh_is_held_with_the_engine_that_the_car_has(road):
    driven = run("constant", 200 * KMH, 8.0, road)
    assert ground_speed(driven) == pytest.approx(200 * KMH, rel=TOP_SPEED_TOLERANCE)
    line = driven.simulation.vehicle.driveline
    late = slice(4000, None)
    wheels = (
        driven["driveline_torque"][late].mean() * ground_speed(driven)[late].mean() / driven.simulation.nominal_radius
    )
    assert 0.9 * line.max_engine_power < wheels / line.efficiency < line.max_engine_power


@pytest.mark.parametrize("wheels", [{"fl": 0.0}, {"rr": 0.0}, everywhere(0.0)], ids=["fl", "rr", "all"])
@pytest.mark.parametrize("road", ["flat", "C"])
def test_car_on_flat_tyres_drives_straight_on(wheels, road):
    driven = drive(road=road, speed=80 * KMH, duration=6.0, pressures=wheels)
    assert np.isfinite(driven.rows).all()
    assert np.abs(driven["path_error"]).max() < PATH_TOLERANCE
    assert speed_error(driven) < SPEED_TOLERANCE
    tyre = driven.simulation.tyre
    flat = [i for i, wheel in enumerate(("fl", "fr", "rl", "rr")) if wheel in wheels]
    height = tyre.r0 - driven["deflection"][-3000:, flat].mean()
    assert height == pytest.approx(tyre.rim_radius + tyre.bottom_offset, abs=0.01)  # on its rim


@pytest.mark.parametrize(
    "fields",
    [
        {"manoeuvre": "double-lane-change", "payload": 600.0},
        {"manoeuvre": "double-lane-change", "driven": "rear"},
        {"manoeuvre": "circle", "bank": 0.1},
        {"manoeuvre": "constant", "grade": 0.1},
        {"manoeuvre": "constant", "grade": -0.1},
        {"manoeuvre": "slalom", "tyre": load_tyre("book-205-60r15")},
    ],
    ids=["payload", "rear drive", "bank", "uphill", "downhill", "book tyre"],
)
def test_other_cars_and_slopes_follow_path_and_speed_too(fields):
    driven = drive(road="A", speed=80 * KMH, duration=10.0, **fields)
    assert np.isfinite(driven.rows).all()
    assert np.abs(driven["path_error"]).max() < PATH_TOLERANCE
    assert speed_error(driven) < 2.0 * SPEED_TOLERANCE  # the grade begins within 10 m


def test_slippery_double_lane_change_slides_but_comes_back():
    """Friction 0.45 times the tyre's 0.88 just cannot give the 4 m/s^2 asked for: the path is left, the car is caught.
    (At 0.4 it spins: the car has no stability control.)"""
    driven = drive(road="flat", manoeuvre="double-lane-change", speed=80 * KMH, duration=16.0, friction="0.45")
    assert np.isfinite(driven.rows).all()
    assert PATH_TOLERANCE < np.abs(driven["path_error"]).max() < 5.0
    assert np.abs(heading(driven)).max() < np.radians(60.0)
