"""Estimator `axles` on four plain quarter cars: it follows, it alarms, and in a curve it says that it knows less."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from estimators.axles.calibration import Identified, to_document
from estimators.axles.response import Axles
from estimators.car import Car
from estimators.drive_log import WHEELS, DriveLog, Signal
from estimators.quarter_car.quarter_car import QuarterCar, ride
from estimators.quarter_car.road_shape import class_spectrum, synthesised
from estimators.runner import Bank, run_bank
from estimators.vertical_pressure.chain import Quarter

SPEED, SECONDS, LOSS_AT, LEFT = 20.0, 34.0, 24.0, 0.896  # m/s, s, s, of the stiffness
CAR = Car()
POINT = Quarter(420.0, 58.0, 1e-3, 38e3, 3e3, 1e-4, 0.6, 0.005)
DOCUMENT = to_document(
    Identified(
        Axles(POINT, POINT, 0.0, CAR.wheelbase), np.zeros((7, 24)), np.zeros((7, 24), complex), 0.01, 0.005, 0.0, 0.0
    )
)


@cache
def driven(lossy: str, yaw_rate: float) -> DriveLog:
    """A drive in which one wheel loses stiffness at LOSS_AT, "" for none."""
    rng = np.random.default_rng(4)
    lag, steps = round(2000.0 * CAR.wheelbase / SPEED), round(2000.0 * SECONDS) | 1
    time = np.arange((steps + 1) // 2) * 1e-3
    signals = {}
    for side in range(2):
        road = synthesised(class_spectrum("B"), SPEED, 5e-4, steps + lag, rng)
        for w, z in ((side, road[lag:]), (2 + side, road[:steps])):
            k = np.where((time > LOSS_AT) & (WHEELS[w] == lossy), LEFT, 1.0) * 250e3
            _, felt = ride(QuarterCar(420.0, 58.001, 38e3, 0.0, 3e3, 0.0), z - z[0], k, 1e-3)
            noise = 0.5 * rng.standard_normal(len(felt))
            signals[f"hub/{WHEELS[w]}/accel_z"] = Signal(time, felt[:, 1] + 9.81 + noise, "m/s^2")
            turn = np.full(len(time[::10]), SPEED / CAR.rolling_radius)
            signals[f"wheel/{WHEELS[w]}/speed"] = Signal(time[::10], turn, "rad/s")
    signals["imu/gyro"] = Signal(time[::10], np.tile([0.0, 0.0, yaw_rate], (len(time[::10]), 1)), "rad/s")
    return DriveLog(signals)


@cache
def said(
    lossy: str, yaw_rate: float = 0.0, expected: tuple[float, float] | None = None
) -> tuple[dict[str, Signal], tuple[tuple[float, tuple[str, ...]], ...]]:
    """What it says, expecting that mean and std of its tyres' pressure [Pa]; its alarms."""
    tyres = {} if expected is None else {"tyres": dict(zip(("pressure", "pressure_std"), expected, strict=True))}
    bank = Bank(["axles"], CAR, {"axles": DOCUMENT | tyres})
    words = run_bank(bank, driven(lossy, yaw_rate))
    return words, tuple((a.time, a.wheels) for a in bank.alarms["axles"])


def test_a_lost_tyre_is_named_within_seconds_and_its_stiffness_followed() -> None:
    for wheel in ("fr", "rl"):
        words, alarms = said(wheel)
        assert [wheels for _, wheels in alarms] == [(wheel,)]
        assert LOSS_AT < alarms[0][0] < LOSS_AT + 6.0
        side, sign = ("right", 1.0) if wheel == "fr" else ("left", -1.0)
        difference, std = (words[f"est/axles/{side}/difference{end}"].value[-1] for end in ("", "/std"))
        assert abs(difference - sign * np.log(LEFT)) < 4.0 * std
        assert std < 0.02


def test_a_sound_car_raises_no_alarm_and_measures_that_its_road_is_shared() -> None:
    words, alarms = said("")
    assert alarms == ()
    for side in ("left", "right"):
        difference, std = (words[f"est/axles/{side}/difference{end}"].value[-1] for end in ("", "/std"))
        assert abs(difference) < 4.0 * std
        assert words[f"est/axles/{side}/coherence"].value[-1] > 0.98


def test_in_a_curve_the_shared_road_is_withdrawn_and_the_std_says_so() -> None:
    straight, curve = (said("", rate)[0]["est/axles/left/difference/std"].value[-1] for rate in (0.0, 0.3))
    assert curve > 3.0 * straight


def test_what_is_expected_of_the_tyres_counts_by_its_precision() -> None:
    """What the drive itself says of a side's mean pressure, the prior taken out again, is the same for two priors."""
    told = []
    for at, std in ((CAR.pressure, 0.25 * CAR.pressure), (150e3, 30e3)):
        words = said("", 0.0, (at, std))[0]
        value, spread = (
            np.mean([words[f"est/axles/{w}/pressure{end}"].value[[0, -1]] for w in ("fl", "rl")], axis=0)
            for end in ("", "/std")
        )
        assert value[0] == pytest.approx(at, rel=1e-3)
        assert spread[0] == pytest.approx(std, rel=0.01)
        information, prior = spread[1] ** -2.0, 2.0 * std**-2.0  # of the mean of two tyres
        told.append((information * value[1] - prior * at) / (information - prior))
    assert told[0] == pytest.approx(told[1], abs=10e3)
    assert abs(told[0] - 250e3) > 40e3  # the drive says something else than the first prior


def test_an_expectation_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="calibration of tyres: pressure_std is -1"):
        Bank(["axles"], CAR, {"axles": DOCUMENT | {"tyres": {"pressure": 180e3, "pressure_std": -1.0}}})
