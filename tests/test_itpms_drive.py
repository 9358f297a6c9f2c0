"""Claims about `itpms` on the bus of the simulated car: a loss found; logs edited as sensors fail: said, not hidden."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

from estimators.car import Car
from estimators.drive_log import WHEELS, DriveLog, Signal
from estimators.itpms.itpms import Itpms
from estimators.itpms.summary import PRIOR
from estimators.runner import Bank, run_bank
from testbed.notes import known_car
from testbed.scenario import Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of, needed
from testbed.simulation import Simulation
from testbed.tyre.inflation import PressureSet

KMH = 1.0 / 3.6
NAME = "itpms"
LEARNING, DURATION, ONSET = 150.0, 110.0, 70.0  # s
SOON = 15.0  # s from the loss to the alarm of a car that drives 75 to 90 km/h
CAR: dict[str, Any] = {"road": "B", "manoeuvre": "motorway", "speed": 85 * KMH, "car_seed": 7}
Change = Callable[[str, Signal], Signal | None]


def bus(scenario: Scenario) -> DriveLog:
    """What the car's bus carried, as far as the estimator may read it."""
    simulation = Simulation(scenario)
    settings = needed(sensor_settings(scenario.sensors), Itpms.reads)
    suite, parts = SensorSuite(settings, scenario.seed, simulation, car_seed=scenario.car_seed), {}
    for stretch in simulation.stretches():
        for name, signal in suite.advance(motion_of(stretch, scenario.step)).items():
            parts.setdefault(name, []).append(signal)
    signals = {
        name: Signal(*(np.concatenate([getattr(p, what) for p in given]) for what in ("time", "value")), given[0].unit)
        for name, given in parts.items()
    }
    return DriveLog(signals)


def car() -> Car:
    simulation = Simulation(Scenario(duration=0.01))
    return known_car(simulation.vehicle, simulation.tyre, simulation.scenario)


@cache
def learnt() -> dict[str, Any]:
    """The calibration of a drive before, on another road."""
    bank = Bank([NAME], car())
    run_bank(bank, bus(Scenario(**CAR, duration=LEARNING, seed=1)))
    return bank.calibrations()


@cache
def lossy() -> DriveLog:
    """Front left loses 18 % at ONSET."""
    loss = {"fl": PressureSet(205e3, ONSET, 1.0)}
    return bus(Scenario(**CAR, duration=DURATION, seed=2, pressure_sets=loss))


@dataclass(frozen=True)
class Said:
    """Last estimates by name (value, std), alarms, and all flags as one text."""

    last: Mapping[str, tuple[float, float]]
    alarms: list[tuple[float, tuple[str, ...]]]
    flags: str

    def std(self, wheel: str) -> float:
        return self.last[f"{wheel}/pressure_change"][1]


def monitored(log: Mapping[str, Signal], change: Change = lambda name, signal: signal) -> Said:
    """What the calibrated estimator says of a log with every signal passed through `change` (None removes it)."""
    edited = {name: change(name, signal) for name, signal in log.items()}
    bank = Bank([NAME], car(), learnt())
    said = run_bank(bank, DriveLog({name: signal for name, signal in edited.items() if signal is not None}))
    last = {
        name.removeprefix(f"est/{NAME}/"): (float(signal.value[-1]), float(said[f"{name}/std"].value[-1]))
        for name, signal in said.items()
        if f"{name}/std" in said
    }
    flags = " | ".join(f.text for f in bank.flags[NAME])
    return Said(last, [(a.time, a.wheels) for a in bank.alarms[NAME]], flags)


def before_loss(log: Mapping[str, Signal]) -> dict[str, Signal]:
    return {name: signal.between(0.0, ONSET) for name, signal in log.items()}


@cache
def clean() -> Said:
    return monitored(before_loss(lossy()))


def test_a_loss_is_found_soon_in_the_right_wheel_and_measured() -> None:
    said = monitored(lossy())
    assert len(said.alarms) == 1
    time, wheels = said.alarms[0]
    assert ONSET < time < ONSET + SOON
    assert wheels == ("fl",)
    change, std = said.last["fl/pressure_change"]
    assert change == pytest.approx(-0.18, abs=3.0 * std)
    assert std < 0.06
    assert said.last["fl/low_probability"][0] > 0.99
    assert max(said.last[f"{wheel}/low_probability"][0] for wheel in WHEELS[1:]) < 0.05


def test_sound_driving_says_that_nothing_is_low_and_how_well_it_knows() -> None:
    said = clean()
    assert said.alarms == []
    assert max(said.last[f"{wheel}/low_probability"][0] for wheel in WHEELS) < 0.01
    assert all(said.std(wheel) < 0.4 * PRIOR for wheel in WHEELS)


def test_without_calibration_it_learns_and_neither_alarms_nor_claims() -> None:
    bank = Bank([NAME], car())
    said = run_bank(bank, lossy())
    assert bank.alarms[NAME] == []
    assert said[f"est/{NAME}/fl/pressure_change/std"].value == pytest.approx(PRIOR)


def test_without_a_gyro_the_loss_is_still_found() -> None:
    """Lateral acceleration stands in; vibration does not care."""
    said = monitored(lossy(), lambda name, s: None if name == "imu/gyro" else s)
    assert "imu/gyro" in said.flags
    assert [wheels for _, wheels in said.alarms] == [("fl",)]
    sound = monitored(before_loss(lossy()), lambda name, s: None if name == "imu/gyro" else s)
    assert sound.alarms == []


def test_an_encoder_dead_from_the_start_leaves_its_wheel_unknown_and_the_others_watched() -> None:
    def dead(name: str, signal: Signal) -> Signal | None:
        return None if name.startswith("wheel/rr/") else signal

    said, sound = monitored(lossy(), dead), monitored(before_loss(lossy()), dead)
    assert [wheels for _, wheels in said.alarms] == [("fl",)]
    assert sound.std("rr") == pytest.approx(PRIOR, rel=1e-3)
    for wheel in ("fl", "fr", "rl"):
        assert clean().std(wheel) <= sound.std(wheel) < 0.5 * PRIOR
    assert "wheel/rr/edges" in sound.flags
    assert sound.alarms == []


def test_edges_out_of_order_are_refused_aloud_and_the_loss_is_found() -> None:
    def shuffled(name: str, signal: Signal) -> Signal:
        if not name.endswith("edges"):
            return signal
        time = signal.time.copy()
        swapped = np.arange(100, len(time) - 1, 997)
        time[swapped], time[swapped + 1] = signal.time[swapped + 1], signal.time[swapped]
        return Signal(time, signal.value)

    said = monitored(lossy(), shuffled)
    assert "late time stamps" in said.flags
    assert [wheels for _, wheels in said.alarms] == [("fl",)]
    assert monitored(before_loss(lossy()), shuffled).alarms == []


def _parked(log: Mapping[str, Signal], seconds: float) -> dict[str, Signal]:
    """The log, and then the car stands: no edges, speeds and torque 0, a gyro with noise."""
    end = max(float(signal.time[-1]) for signal in log.values())
    time = end + np.arange(0.1, seconds, 0.1)
    rng, found = np.random.default_rng(0), {}
    for name, signal in log.items():
        more = np.zeros((len(time), *signal.value.shape[1:]))
        if name.startswith("imu"):
            more += 1e-3 * rng.standard_normal(more.shape)
        if name.endswith("edges"):
            found[name] = signal
        else:
            value = np.concatenate([signal.value, more])
            found[name] = Signal(np.concatenate([signal.time, time]), value, signal.unit)
    return found


def test_ten_minutes_of_standstill_cost_confidence_and_raise_nothing() -> None:
    said = monitored(_parked(before_loss(lossy()), 600.0))
    assert said.alarms == []
    for wheel in WHEELS:
        assert said.std(wheel) > clean().std(wheel) + 0.01


@pytest.mark.parametrize("signed", [True, False], ids=["signed speeds", "unsigned speeds"])
def test_reversing_is_not_read(signed: bool) -> None:
    """After a stop two minutes backwards at 12 km/h in a curve: edges, unsigned speeds look like driving forwards."""
    end, omega, yaw = ONSET + 5.0, 9.0, 0.15
    time = end + np.arange(0.01, 120.0, 0.01)
    edges = end + np.arange(1.0, 120.0 * omega * 48 / (2.0 * np.pi)) * 2.0 * np.pi / (48 * omega)
    log = before_loss(lossy())
    for name, signal in log.items():
        if name.endswith("edges"):
            log[name] = Signal(np.concatenate([signal.time, edges]), np.ones(len(signal) + len(edges)))
            continue
        shape = (len(time), *signal.value.shape[1:])
        more = np.full(shape, -omega if signed else omega) if name.startswith("wheel") else np.zeros(shape)
        if name == "imu/gyro":
            more[:, 2] = yaw
        log[name] = Signal(np.concatenate([signal.time, time]), np.concatenate([signal.value, more]), signal.unit)
    said = monitored(log)
    assert said.alarms == []
    for wheel in WHEELS:
        assert clean().std(wheel) <= said.std(wheel) <= PRIOR


def test_result_does_not_depend_on_how_the_stream_is_cut() -> None:
    results = []
    for stretch in (0.7, 5.0):
        bank = Bank([NAME], car(), learnt())
        results.append(run_bank(bank, lossy(), stretch))
    assert results[0] == results[1]


def test_calibration_carries_rings_and_levels_and_refuses_nonsense() -> None:
    document = learnt()[NAME]
    again = Itpms(car())
    again.use_calibration(document)
    assert again.calibration() == document
    assert set(document["teeth"]) == set(WHEELS)
    for bad in ({"teeth": 3}, document | {"teeth": {"xx": {}}}, document | {"slip": "wet"}):
        with pytest.raises(ValueError, match=r"teeth|wheel|slip"):
            Itpms(car()).use_calibration(bad)


def test_relearning_forgets() -> None:
    estimator = Itpms(car())
    estimator.use_calibration(learnt()[NAME])
    estimator.relearn()
    assert estimator.calibration() is None
