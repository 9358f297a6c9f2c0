"""Pressure estimators with a faulty sensor: they go on as if it were not there, or say that they do not know."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from estimators.car import Car
from estimators.drive_log import DriveLog, Signal
from estimators.faults import inject
from estimators.quarter_car.gravity import GravityCheck
from estimators.runner import Bank, run, run_bank
from tests.synthetic_drive import Noise, drive, varied_speed

FROM = 16.0  # s
UNSURE = 30e3  # Pa: no tyre of normal use is told from another by a std of this
NEAR = 3.0  # std by which an estimate may be off what it is without the fault
GONE = ("bias:3", "scale:0.75", "zero", "stuck", "noise:3", "drift:2", "intermittent:0.4,1", "spike:60,0.1")
STAYS = ("delay:0.3", "swap")


@cache
def log() -> DriveLog:
    return drive(varied_speed(30.0, 15.0, 1.0), noise=Noise(), seed=5, hubs=True)


def flags(said: dict[str, Signal], name: str) -> str:
    found = said.get(f"est/{name}/flags")
    return " | ".join(found.value) if found else ""


def last(said: dict[str, Signal], name: str) -> tuple[float, float]:
    return float(said[name].value[-1]), float(said[f"{name}/std"].value[-1])


@cache
def sound(name: str) -> dict[str, Signal]:
    return run(log(), [name])


@pytest.mark.parametrize("name", ["vertical_pressure", "axles"])
@pytest.mark.parametrize("kind", GONE)
def test_a_hub_that_tells_no_gravity_tells_no_pressure(name: str, kind: str) -> None:
    said = run(inject(log(), [f"hub/fl/accel_z={kind}@{FROM}"]), [name])
    assert "hub/fl/accel_z: its mean of" in flags(said, name)
    assert last(said, f"est/{name}/fl/pressure")[1] > UNSURE
    assert f"alarm/{name}" not in said
    value, std = last(said, f"est/{name}/fr/pressure")
    assert abs(value - last(sound(name), f"est/{name}/fr/pressure")[0]) < NEAR * std


@pytest.mark.parametrize("name", ["vertical_pressure", "axles"])
@pytest.mark.parametrize("kind", STAYS)
def test_late_or_exchanged_hubs_move_nothing_beyond_what_is_reported(name: str, kind: str) -> None:
    said = run(inject(log(), [f"hub/fl/accel_z={kind}@{FROM}"]), [name])
    for wheel in ("fl", "fr", "rl", "rr"):
        value, std = last(said, f"est/{name}/{wheel}/pressure")
        assert abs(value - last(sound(name), f"est/{name}/{wheel}/pressure")[0]) < NEAR * std


@pytest.mark.parametrize("name", ["vertical_pressure", "axles"])
def test_one_faulty_wheel_speed_changes_no_stiffness(name: str) -> None:
    for kind in ("zero", "stuck", "scale:1.3"):
        said = run(inject(log(), [f"wheel/fl/speed={kind}@{FROM}"]), [name])
        value, std = last(said, f"est/{name}/fl/pressure")
        assert abs(value - last(sound(name), f"est/{name}/fl/pressure")[0]) < NEAR * std


def test_rough_roads_are_no_fault_and_a_sensor_that_is_sound_again_is_believed() -> None:
    rng, check = np.random.default_rng(0), GravityCheck(0.256)
    assert all(check.block(9.81 + 8.0 * rng.standard_normal(256)) for _ in range(400))
    assert not [check.block(np.full(256, 7.0)) for _ in range(20)][-1]
    assert [check.block(9.81 + 0.5 * rng.standard_normal(256)) for _ in range(20)][-1]


@pytest.mark.parametrize("kind", ["bias:20", "drift:2", "noise:10", "zero", "dropout"])
def test_a_faulty_temperature_is_no_leak(kind: str) -> None:
    said = run(inject(log(), [f"tyre/fl/temperature={kind}@{FROM}"]), ["direct_pressure"])
    assert "alarm/direct_pressure" not in said
    assert "tyre/fl/temperature: " in flags(said, "direct_pressure")
    value, std = last(said, "est/direct_pressure/fl/pressure")
    assert abs(value - Car().pressure) < NEAR * std


def test_a_silent_pressure_sensor_is_told_and_its_wheel_alone_is_lost() -> None:
    said = run(inject(log(), [f"tyre/fl/pressure=dropout@{FROM}"]), ["direct_pressure"])
    assert "fl is not watched" in flags(said, "direct_pressure")
    assert said["est/direct_pressure/fl/pressure"].time[-1] < FROM + 2.0
    assert said["est/direct_pressure/fr/pressure"].time[-1] > 28.0


@cache
def learnt() -> dict[str, dict]:
    bank = Bank(["wheel_radius"], Car())
    run_bank(bank, drive(varied_speed(200.0), noise=Noise(), seed=1))
    return bank.calibrations()


@pytest.mark.parametrize("kind", ["scale:1.05", "scale:0.95", "teeth:50", "bias:3"])
def test_a_radius_that_no_pressure_makes_tells_no_pressure(kind: str) -> None:
    bank = Bank(["wheel_radius"], Car(), learnt())
    faulty = inject(drive(varied_speed(60.0), noise=Noise(), seed=2), [f"wheel/fl={kind}@{FROM}"])
    said = run_bank(bank, faulty)
    assert "it slips, is another wheel, or its sensor errs" in flags(said, "wheel_radius")
    assert last(said, "est/wheel_radius/fl/relative_pressure_change")[1] == Car().pressure
