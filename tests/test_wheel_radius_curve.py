"""Claims about wheel radii in curves and when wheels spin: moved load, a lighter inner wheel, a wrong track, ice."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from estimators.car import GRAVITY, Car
from estimators.wheel_radius.curve import BODY_ROLL, INNER_SLIP, RADIUS_LOAD, curve_shift
from estimators.wheel_radius.lateral import FRONT, REAR, Lateral
from estimators.wheel_radius.motion import MotionTracker
from estimators.wheel_radius.payload import SIDE_MOMENT, TRACK, WIND_MOMENT, side_shift
from estimators.wheel_radius.residuals import Methods
from estimators.wheel_radius.sliding import GRIP_MEMORY, RECOVERY, Sliding
from tests.synthetic_drive import Noise, drive, varied_speed
from tests.test_wheel_radius_conditions import fed

CAR = Car()


def test_curve_shift_is_that_of_two_wheels_whose_loads_differ() -> None:
    """Radius and slip of each wheel worked out on its own, at the same force; 3 %: the first order."""
    lateral, pull = 0.8, np.array([0.1, -0.05])
    loads = [CAR.chassis_mass * CAR.cg_to_rear_axle / CAR.wheelbase / 2.0 + CAR.front_wheel_mass]
    loads.append(CAR.mass / 2.0 - loads[0])
    moved = CAR.mass * BODY_ROLL * lateral * CAR.cg_height / (CAR.front_track + CAR.rear_track)
    for axle in (0, 1):
        load = loads[axle] * GRAVITY
        speeds = []
        for of in (load - moved, load + moved):  # left, right: a left turn
            radius = np.exp(RADIUS_LOAD * (of - load))
            speeds.append((1.0 + INNER_SLIP * pull[axle] * load / of) / radius)
        assert curve_shift(CAR, lateral, pull)[axle] == pytest.approx(speeds[1] / speeds[0] - 1.0, rel=0.03)


def test_a_driven_axle_that_pulls_hard_reads_a_curve_the_other_way_round() -> None:
    rolls, pulls = curve_shift(CAR, 0.5, np.array([0.0, 0.2]))
    assert rolls > 3e-4
    assert pulls < -3e-4


def winding(told: Car) -> Lateral:
    """Deltas of equal radii after a winding road; told: the car that the filter is told."""
    speed = varied_speed(180.0, 12.0, 3.0)
    curvature = 0.6 * np.sin(np.arange(len(speed)) / 100.0 / 3.0) / np.maximum(speed, 5.0) ** 2
    return fed(Methods(told), drive(speed, curvature=curvature, noise=Noise(), seed=3), told).lateral


def test_moved_load_is_no_change_of_radius() -> None:
    """It moves the deltas by 4e-4 to and fro."""
    lateral = winding(CAR)
    for state in (FRONT, REAR):
        value, std = lateral.delta(state)
        assert abs(value) < 3.0 * std < 9e-4
    assert np.abs(lateral.track_errors()).max() < 0.03


def test_a_track_told_wrong_by_a_tenth_is_found_and_is_no_change_of_radius() -> None:
    """Found to two thirds: the deltas' own walk explains the rest."""
    told = dataclasses.replace(CAR, front_track=1.1 * CAR.front_track, rear_track=0.9 * CAR.rear_track)
    lateral = winding(told)
    for state in (FRONT, REAR):
        value, std = lateral.delta(state)
        assert abs(value) < 3.0 * std < 9e-4
    rear, front = lateral.track_errors()
    assert 0.05 < rear < 0.13
    assert -0.13 < front < -0.04


def cells(tracker: MotionTracker, speeds: list[list[float]], first: int = 0) -> list[bool]:
    """Whether cells of wheel speeds over ground [m/s] are read."""
    rest = [0.0, 0.0, 0.0, 0.0, 0.0]
    return [
        tracker.motion(first + i, 0.1 * (first + i), np.array([*np.array(v) / CAR.rolling_radius, *rest])).readable
        for i, v in enumerate(speeds)
    ]


def test_driven_wheels_that_spin_are_not_read_and_the_others_are_not_dead() -> None:
    """Setting off on ice, as a simulated drive had it: both front wheels spin, the rear ones barely roll."""
    tracker = MotionTracker(CAR, 0.1)
    assert not any(cells(tracker, [[10.02, 16.29, 0.74, 0.73], [8.0, 18.3, 1.11, 1.12], [3.7, 22.8, 1.92, 1.94]]))
    assert not tracker.dead.any()
    rolls = cells(tracker, [[13.0, 13.1, 13.0, 13.0]] * (RECOVERY + 2), 3)
    assert rolls == [False] * (RECOVERY - 1) + [True] * 3


def test_a_car_that_slides_past_its_steering_is_not_read() -> None:
    """Full lock at a yaw rate of 0.06 rad/s, as a simulated drive on ice had it; 1 m/s^2 of understeer is read."""
    for angle, read in ((0.6, False), (CAR.wheelbase * 0.06 / 13.36 + 0.015, True)):
        tracker = MotionTracker(CAR, 0.1)
        omega = np.array([13.25, 13.35, 13.42, 13.38]) / CAR.rolling_radius
        cell = np.array([*omega, 0.06, 0.0, 0.8, 0.0, angle * CAR.steering_ratio])
        assert tracker.motion(0, 0.0, cell).readable is read


def test_a_dead_wheel_is_told_from_one_that_stands_beside_spinning_ones() -> None:
    tracker = MotionTracker(CAR, 0.1)
    assert all(cells(tracker, [[20.0, 20.0, 0.0, 20.0]] * 3))
    assert tracker.dead.tolist() == [False, False, True, False]


def test_a_load_on_one_side_shifts_both_axles_as_its_moment_says() -> None:
    """SIDE_MOMENT: half of g M y / track moves from wheel to wheel of each axle, up on one side, down on the other."""
    each = SIDE_MOMENT * GRAVITY / TRACK / 2.0
    assert side_shift(True) ** 2 - side_shift(False) ** 2 == pytest.approx((2.0 * RADIUS_LOAD * each) ** 2)
    assert side_shift(False) == pytest.approx(side_shift(True) * WIND_MOMENT / np.hypot(SIDE_MOMENT, WIND_MOMENT))


def test_grip_that_a_spin_has_shown_is_used_by_half_for_five_minutes() -> None:
    """Left front spins at a pull of 0.24; once it rolls again 0.05 is read and 0.15 not, after GRIP_MEMORY both."""
    sliding, roll = Sliding(), np.full(4, 40.0)
    assert not sliding.grips(0.0, roll * [1.5, 1.0, 1.0, 1.0], 0.0, 0.24, True)
    after = [sliding.grips(0.1 * i, roll, 0.0, 0.05, True) for i in range(1, RECOVERY + 2)]
    assert after == [False] * (RECOVERY - 1) + [True] * 2
    assert not sliding.grips(10.0, roll, 0.0, 0.15, True)
    assert sliding.grips(GRIP_MEMORY + 1.0, roll, 0.0, 0.15, True)
    assert not sliding.grips(GRIP_MEMORY + 2.0, roll * [0.95, 0.99, 1.0, 1.0], 0.0, 0.15, True)  # one locks sooner
