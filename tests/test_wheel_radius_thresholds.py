"""Claims about the threshold of the wheel-radius alarm, and that an hour without excitation raises none."""

from __future__ import annotations

import numpy as np
import pytest

from estimators.car import Car
from estimators.detectors import Ewma, samples_between
from estimators.wheel_radius.longitudinal import COMPLIANCE_STD, DELTA_STD, Longitudinal
from estimators.wheel_radius.low_pressure import LowPressureAlarm
from estimators.wheel_radius.motion import Motion
from estimators.wheel_radius.thresholds import FALSE_PER_HOUR, FORGETTING, RATE, designed, designed_by_tail
from estimators.wheel_radius.wheel_change import wheel_change

KNOWN_TO, CAUTIOUS = 1.6, 10.0  # factors of the run length: what 20 alarms leave open, and what a log-linear tail adds
TAIL = 0.15  # of one that 300 blocks above u extrapolate by a factor of 1e4 in the rate


def test_designed_threshold_of_white_gaussian_significances_has_the_run_length_that_was_asked_for_or_more() -> None:
    """A record of 2 d for one alarm in 4 d. A Gaussian tail falls faster than the log-linear one that is taken."""
    record = np.random.default_rng(1).standard_normal(200_000)
    exact = Ewma(FORGETTING, designed(record).threshold, "upper").average_run_length().mean
    asked = samples_between(FALSE_PER_HOUR, RATE)
    assert asked / KNOWN_TO < exact < asked * CAUTIOUS


def test_designed_by_tail_extrapolates_an_exponential_tail_to_the_designed_rate() -> None:
    """Seconds of an exponential distribution exceed h at 3600 exp(-h) an hour."""
    drives = [np.random.default_rng(k).exponential(size=3600) for k in range(18)]
    found, exact = designed_by_tail(drives), np.log(3600.0 / FALSE_PER_HOUR)
    assert exact in found
    assert found.value == pytest.approx(exact, rel=TAIL)


def motion(index: int, slip: float, traction: float) -> Motion:
    """A cell straight on: the front wheels turn faster by `slip`."""
    omega = np.array([1.0 + slip, 1.0 + slip, 1.0, 1.0]) * 70.0
    return Motion(
        index=index, time=0.1 * index + 0.05, omega=omega, speed=25.0, roll=np.ones(4), cos_steer=1.0, gyro=0.0,
        gyro_gain=1.0, stand_in=False, traction=traction, pull=np.array([traction, 0.0]), force=600.0, specific=0.0,
        readable=True, standing=False,
    )  # fmt: skip


def test_an_hour_at_constant_speed_winds_nothing_up_and_raises_no_alarm() -> None:
    """Two minutes of changing torque, then an hour at 4 % of traction with noise, while the slope 1/k wanders by two
    of its std: the slope becomes as unknown as at the start and no more, delta by what that leaves open, and the error
    that the wandering makes stays within it."""
    rng, cells = np.random.default_rng(2), 10 * (120 + 3600)
    index = np.arange(cells)
    pull = np.where(index < 1200, 0.06 + 0.05 * np.sin(2.0 * np.pi * index / 200.0), 0.04)
    slope = 0.04 + 2.0 * COMPLIANCE_STD * np.maximum(index - 1200, 0) / cells
    slip = slope * pull + 3e-4 * rng.standard_normal(cells)
    felt = pull + 1e-3 * rng.standard_normal(cells)
    sides = Longitudinal(0, "front"), Longitudinal(1, "front")
    alarm, alarms, learnt = LowPressureAlarm(Car()), [], 0.0
    used = np.array([False, False, False, True, True])
    for i in range(cells):
        for side in sides:
            side.step(motion(i, float(slip[i]), float(felt[i])))
        if i % 10 == 9:
            (left, left_std), (right, right_std) = (side.delta() for side in sides)
            change = np.array([0.0, 0.0, 0.0, left, right])
            covariance = np.diag(np.square([1.0, 1.0, 1.0, left_std, right_std]))
            assert sides[0].compliance()[1] <= COMPLIANCE_STD * (1.0 + 1e-9)
            assert left_std <= DELTA_STD * (1.0 + 1e-9)
            learnt = left_std if i == 1199 else learnt
            if i >= 1200:
                said = alarm.step(0.1 * i, *wheel_change(change, covariance, used))
                alarms += [] if said is None else [said]
    delta, std = sides[0].delta()
    assert sides[0].compliance()[1] > 0.99 * COMPLIANCE_STD
    assert std > 1.5 * learnt
    assert std > 0.9 * 0.04 * COMPLIANCE_STD
    assert abs(delta) < 3.0 * std
    assert alarms == []
