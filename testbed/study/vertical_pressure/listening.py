"""One drive: what the car's sensors say and what estimators make of it, with the truth beside it for the scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.car import GRAVITY, Car
from estimators.drive_log import WHEELS, Signal
from estimators.registry import registered
from estimators.runner import FLUSH, Bank
from testbed.notes import known_car
from testbed.scenario import SENSOR_STEP, Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of, needed
from testbed.simulation import Simulation
from testbed.study.vertical_pressure.told import Told, right, wrong

ESTIMATORS = tuple(name for name in ("vertical_pressure", "axles") if name in registered())
ACCELERATIONS = ("body", "hub")
_EMPTY = Signal([], [])


@dataclass(frozen=True, eq=False)
class Heard:
    """On the sensors' grid of 1 ms, n samples.

    felt: measured [a_s, a_us] less gravity [m/s^2], NaN where missing, (n, 4, 2); road: height under each tyre's
    contact [m], (n, 4); pressure: true [Pa], (n, 4). told: what the estimators knew, right first; said: their words,
    for each of `told`.
    """

    scenario: Scenario
    felt: NDArray[np.float64]
    road: NDArray[np.float64]
    pressure: NDArray[np.float64]
    told: tuple[Told, ...]
    said: tuple[dict[str, Signal], ...]


def known(scenario: Scenario) -> Car:
    """The car as its maker knows it."""
    simulation = Simulation(scenario)
    return known_car(simulation.vehicle, simulation.tyre, scenario)


def drive(scenario: Scenario, wrong_seed: int | None = None) -> Heard:
    """wrong_seed: estimators that know wrongly listen too."""
    simulation = Simulation(scenario)
    car = known_car(simulation.vehicle, simulation.tyre, scenario)
    told = (right(car),) if wrong_seed is None else (right(car), wrong(car, wrong_seed))
    banks = [Bank(ESTIMATORS, t.car, {name: t.calibrations[name] for name in ESTIMATORS if name in t.calibrations})
             for t in told]  # fmt: skip
    own = {f"{place}/{wheel}/accel_z" for place in ACCELERATIONS for wheel in WHEELS}
    suite = SensorSuite(
        needed(sensor_settings(scenario.sensors), own | banks[0].reads), scenario.seed, simulation,
        car_seed=scenario.car_seed,
    )  # fmt: skip
    steps = round(scenario.duration / SENSOR_STEP)
    felt, truth = np.full((steps, len(WHEELS), 2), np.nan), []
    words: list[dict[str, list[Signal]]] = [{} for _ in told]
    for stretch in simulation.stretches():
        motion = motion_of(stretch, scenario.step)
        sensed = suite.advance(motion)
        end = float(stretch["time"][-1]) + scenario.step
        last = end > scenario.duration - 0.5 * scenario.step
        for bank, kept in zip(banks, words, strict=True):
            for name, signal in bank.update(sensed, end + (FLUSH if last else 0.0)).items():
                kept.setdefault(name, []).append(signal)
        for j, place in enumerate(ACCELERATIONS):
            for w, wheel in enumerate(WHEELS):
                signal = sensed.get(f"{place}/{wheel}/accel_z", _EMPTY)
                at = np.rint(signal.time / SENSOR_STEP).astype(np.int64)
                inside = (at >= 0) & (at < steps)
                felt[at[inside], w, j] = signal.value[inside] - GRAVITY
        truth.append([stretch["road_height"], stretch["pressure"]])
    road, pressure = (np.concatenate([part[i] for part in truth]) for i in (0, 1))
    return Heard(scenario, felt, road, pressure, told, tuple(_joined(kept) for kept in words))


def _joined(words: dict[str, list[Signal]]) -> dict[str, Signal]:
    return {
        name: Signal(
            np.concatenate([p.time for p in parts]), np.concatenate([p.value for p in parts]), parts[0].unit
        )
        for name, parts in words.items()
    }  # fmt: skip


def last_said(time: NDArray[np.float64], value: NDArray[np.float64], at: Sequence[float]) -> NDArray[np.float64]:
    """What had been said at each moment of `at` [s], NaN before the first word; time (m,) rising, value (m, ...)."""
    place = np.searchsorted(time, np.asarray(at, float) + 1e-9, side="right") - 1
    found = (
        np.array(value[np.maximum(place, 0)], dtype=float)
        if len(time)
        else np.full((len(at), *value.shape[1:]), np.nan)
    )
    found[place < 0] = np.nan
    return found
