"""Monitors of the steering actuator: residuals, servo model and its identification, accusations, in a fixture's car."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from estimators.car import Car
from estimators.drive_log import DriveLog, Signal
from estimators.runner import Bank, run_bank
from estimators.steering_actuator.calibration import Calibration
from estimators.steering_actuator.identify import identified, linear_servo
from estimators.steering_actuator.learn import learnt
from estimators.steering_actuator.pinion import ratios
from estimators.steering_actuator.residuals import STEP, TIME_CONSTANT, derive, residuals
from estimators.steering_actuator.servo_model import (
    PUSH,
    RECOVERS,
    SAID,
    STRAIN,
    ServoModel,
    checked,
    new_state,
    simulate,
    simulated,
)
from estimators.steering_actuator.steering_actuator import SteeringActuator
from tests.steering_servo import TRUE, cells, log, servo, wheel_angle

RATE = 0.01
HELD = 3.0  # deg rms, 0.15 % of what demand and angle part by at the limits
DEG = np.pi / 180.0


@cache
def calibration() -> Calibration:
    drives = [cells(log(5.0, seed)) for seed in range(50)]
    servo = linear_servo([demand for demand, *_ in drives[:4]], [angle for _, angle, *_ in drives[:4]])
    return learnt(servo, drives[:4], drives, RATE)


def said(of: DriveLog, stretch: float = 1.0, calibrated: bool = True) -> dict[str, Signal]:
    bank = Bank(["steering_actuator"], Car(), {"steering_actuator": calibration().as_json()} if calibrated else {})
    return run_bank(bank, of, stretch)


def alarms(of: DriveLog) -> list[str]:
    found = said(of).get("alarm/steering_actuator")
    return [] if found is None else found.value.tolist()


def test_derivatives_of_a_ramp_follow_the_filter_s_step_response() -> None:
    """Backward Euler: 1 - q^k for the first, its own response for the second, q = T / (T + dt)."""
    k, slope, q = np.arange(60), 70.0, TIME_CONSTANT / (TIME_CONSTANT + STEP)
    found = residuals(slope * STEP * k)
    assert found[:, 1] == pytest.approx(slope * (1.0 - q**k), abs=1e-9)
    expected = slope / (TIME_CONSTANT + STEP) * k * q ** np.maximum(k - 1, 0) * (1.0 - q)
    assert found[:, 2] == pytest.approx(expected, abs=1e-7)


def test_a_constant_residual_has_no_derivative_and_holes_change_no_slope() -> None:
    assert np.abs(residuals(np.full(30, 5.0))[:, 1:]).max() == 0.0
    ramp = 3.0 * STEP * np.arange(400)
    ramp[200:210] = np.nan
    found = residuals(ramp)
    assert found[399, 1] == pytest.approx(3.0, rel=1e-6)
    assert found[210, 1] == pytest.approx(3.0, rel=1e-6)
    assert np.isnan(found[205]).all()
    ramp[220:260] = np.nan  # a silence: begins anew at rest
    assert residuals(ramp)[260, 1] == 0.0


def test_compiled_parts_are_their_plain_twins() -> None:
    error = 50.0 * np.random.default_rng(1).standard_normal(200)
    error[50:80] = np.nan
    fast, plain = np.empty((200, 3)), np.empty((200, 3))
    derive(error, fast)
    derive.py_func(error, plain)
    assert np.array_equal(fast, plain, equal_nan=True)
    demand = np.radians(20.0 * error)
    states = new_state(), new_state()
    fast, plain = np.empty((200, SAID)), np.empty((200, SAID))
    simulate(TRUE, states[0], demand, fast)
    simulate.py_func(TRUE, states[1], demand, plain)
    assert fast == pytest.approx(plain, rel=1e-9, abs=1e-9, nan_ok=True)
    assert states[0] == pytest.approx(states[1], rel=1e-9)


def test_the_model_is_a_second_order_system_while_no_limit_is_reached() -> None:
    """Step response of q p / (s^2 + q s + p q), overdamped, to the order of the substep."""
    p, q = 20.0, 100.0
    free = ServoModel(p, q, 0.0, 0.0, 1e6, 1e9)
    demand = np.ones(100)
    state = new_state()
    out = np.empty((1, SAID))
    simulate(free, state, np.zeros(1), out)
    found = np.empty((100, SAID))
    simulate(free, state, demand, found)
    time = STEP * (np.arange(100) + 0.5)  # the demand is a ramp over the first cell: as a step in its middle
    root = np.sqrt(q * q - 4.0 * p * q + 0j)
    s1, s2 = (-q + root) / 2.0, (-q - root) / 2.0
    exact = 1.0 - ((s2 * np.exp(s1 * time) - s1 * np.exp(s2 * time)) / (s2 - s1)).real
    assert found[RECOVERS:, 0] == pytest.approx(exact[RECOVERS:], abs=0.01)
    assert found[-1, 0] == pytest.approx(1.0, abs=1e-6)


def test_the_model_keeps_its_limits_and_its_delay() -> None:
    demand = np.concatenate([np.zeros(50), np.full(150, 60.0)])
    found = simulated(TRUE, demand)
    assert np.abs(found[:, 1]).max() == pytest.approx(TRUE.speed_limit, rel=1e-6)
    assert found[:, PUSH].max() <= TRUE.acceleration_limit
    assert found[:50, STRAIN].max() == 0.0
    assert found[55:60, STRAIN].min() > 0.5
    assert found[-1, STRAIN] < 1e-6
    late = simulated(TRUE._replace(delay=3.0 * STEP), demand)
    assert late[53:, 0] == pytest.approx(simulated(TRUE._replace(delay=0.0), demand)[50:-3, 0], abs=1e-9)


@pytest.mark.parametrize(
    "change", [{"delay": 1.0}, {"position_gain": 0.0}, {"speed_limit": -1.0}, {"speed_gain": float("nan")}]
)
def test_a_servo_that_makes_no_sense_is_refused(change: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="valid"):
        checked(TRUE._replace(**change))


def test_identification_recovers_a_known_servo() -> None:
    """1 % on the limits and 5 % on the lag (1 - f) / p + delay; gain, zero and delay by themselves lie in a valley."""
    drives = [cells(log(10.0, seed, 2.0)) for seed in (51, 54, 57)]
    found = linear_servo([d for d, *_ in drives], [a for _, a, *_ in drives])
    assert found.speed_limit == pytest.approx(TRUE.speed_limit, rel=0.01)
    assert found.acceleration_limit == pytest.approx(TRUE.acceleration_limit, rel=0.05)
    assert (1.0 - found.feedforward) / found.position_gain + found.delay == pytest.approx(1.0 / 80.0, rel=0.05)
    for demand, angle, *_ in (cells(log(10.0, seed, 2.0)) for seed in (60, 61)):
        off = angle - simulated(found, demand)[:, 0]
        assert np.degrees(np.sqrt(np.nanmean(off**2))) < HELD  # where demand and angle part by up to 2000 deg
    assert np.degrees(np.abs(drives[0][1] - drives[0][0]).max()) > 100.0


def test_drives_in_which_nothing_moves_tell_no_servo() -> None:
    with pytest.raises(ValueError, match="does not move"):
        identified([np.zeros(100)], [np.zeros(100)])


def test_ratios_come_back() -> None:
    """Within 1 %: mean of a cell against its middle."""
    drives = [cells(log(10.0, seed)) for seed in (70, 71, 72)]
    found = ratios(*(np.concatenate([drive[i] for drive in drives]) for i in (2, 3, 1)))
    assert found.wheel == pytest.approx(1.0, rel=0.01)
    assert found.motor == pytest.approx(1.0 / 40.0, rel=0.01)
    with pytest.raises(ValueError, match="only together"):
        ratios(np.arange(50.0), np.arange(50.0), 2.0 * np.arange(50.0))


def test_a_sound_drive_raises_nothing() -> None:
    for seed in (80, 81):
        for active in (0.02, 0.6):
            assert alarms(log(20.0, seed, active)) == []


@pytest.mark.parametrize("seed", [80, 81])
def test_an_error_of_the_motor_s_sensor_is_named_sized_and_dated(seed: int) -> None:
    error = np.where(np.arange(20000) > 10000, 20.0 * DEG, 0.0)
    first, *rest = alarms(log(20.0, seed, sensed=error))
    last = rest[-1] if rest else first
    assert last.startswith("motor angle sensor errs, by +")
    size, since = (float(last.split(key)[1].split()[0]) for key in ("by ", "since "))
    assert size == pytest.approx(20.0, abs=6.0)
    assert since == pytest.approx(10.0, abs=0.1)
    assert "one in 100 h" in last


def test_a_motor_that_stands_is_the_motor_s_fault_and_not_the_sensor_s() -> None:
    whole = log(20.0, 82)
    stuck = whole["steering/motor_angle"].value.copy()
    held = stuck[10000]
    pinion = whole["steering/pinion_angle"]
    off = np.where(np.arange(20000) > 10000, held - stuck, 0.0).reshape(-1, 10).mean(axis=1)
    stuck[10001:] = held
    changed = {
        "steering/motor_angle": Signal(whole["steering/motor_angle"].time, stuck, "rad"),
        "steering/pinion_angle": Signal(pinion.time, pinion.value + off / 40.0, "rad"),
    }
    found = alarms(DriveLog({**whole.signals, **changed}))
    assert len(found) == 1
    assert found[0].startswith("motor does not do what is demanded, ")


def test_an_error_inside_the_loop_is_seen_by_the_pinion_alone() -> None:
    found = alarms(log(30.0, 83, loop=60.0 * DEG))
    assert found
    assert found[-1].startswith("angles of pinion, steering wheel and motor contradict")


def test_an_accusation_is_taken_back() -> None:
    error = np.where((np.arange(30000) > 10000) & (np.arange(30000) < 12000), 50.0 * DEG, 0.0)
    of = log(30.0, 84, sensed=error)
    flags = said(of)["est/steering_actuator/flags"]
    assert flags.value.tolist() == ["steering actuator agrees again"]
    assert 16.9 < flags.time[-1] < 18.0


def test_how_the_log_is_cut_changes_nothing() -> None:
    error = np.where(np.arange(12000) > 6000, 40.0 * DEG, 0.0)
    of = log(12.0, 85, sensed=error)
    whole = said(of, 4.0)
    assert "alarm/steering_actuator" in whole
    for stretch in (0.037, 1.0):
        assert said(of, stretch) == whole


def test_without_a_calibration_it_tells_the_residual_only_and_without_active_steering_nothing() -> None:
    of = log(6.0, 86)
    found = said(of, calibrated=False)
    assert set(found) == {"est/steering_actuator/position_residual", "est/steering_actuator/position_residual/std"}
    residual = found["est/steering_actuator/position_residual"]
    demand, angle, *_ = cells(of)
    assert residual.value[5] == pytest.approx((angle - demand)[58], abs=0.02)
    assert said(DriveLog({"steering/angle": of["steering/angle"]})) == {}


def test_missing_and_broken_samples_are_told_and_raise_no_alarm() -> None:
    whole = log(20.0, 87)
    time = whole["steering/motor_demand"].time
    for name in ("motor_demand", "motor_angle", "pinion_angle", "angle"):
        signal = whole[f"steering/{name}"]
        kept = (signal.time < 8.0) | (signal.time > 9.5)
        cut = Signal(signal.time[kept], signal.value[kept], "rad")
        found = said(DriveLog({**whole.signals, f"steering/{name}": cut}))
        assert f"steering/{name}: no usable sample" in " ".join(found["est/steering_actuator/flags"].value)
        assert "alarm/steering_actuator" not in found, name
    broken = whole["steering/motor_angle"].value.copy()
    broken[5000:5100] = np.nan
    found = said(DriveLog({**whole.signals, "steering/motor_angle": Signal(time, broken, "rad")}))
    assert "not a finite number" in " ".join(found["est/steering_actuator/flags"].value)
    assert "alarm/steering_actuator" not in found


def test_a_calibration_survives_and_a_broken_one_is_refused() -> None:
    document = calibration().as_json()
    assert Calibration.from_json(document) == calibration()
    for key, value in (
        ("servo", {"position_gain": 1.0}),
        ("servo_watch", {}),
        ("ratios", {"wheel": 1.0}),
        ("servo", 3),
    ):
        with pytest.raises(ValueError, match=r"^(?!.*\n)"):
            SteeringActuator(Car()).use_calibration({**document, key: value})
    with pytest.raises(ValueError, match="spread"):
        replace(calibration().servo_watch.spread, floor=0.0)


def test_the_fixture_s_servo_lags_a_ramp_by_its_speed_over_its_gain() -> None:
    demand = 10.0 * 1e-3 * np.arange(2000)
    assert demand[-1] - servo(demand)[-1] == pytest.approx(
        10.0 / 80.0 - 10.0 * 1e-3, rel=1e-3
    )  # x moves in the step itself
    assert wheel_angle(1.0, 3).shape == (1000,)
