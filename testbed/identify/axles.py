"""python -m testbed.identify axles: both axles over one road, as `axles` starts from them.

Drives at 30 to 120 km/h over roads of their own, classes A to D in turn, all tyres at 130, 180 or 250 kPa, or one axle
at 180 and the other at 250: fits `estimators.axles.identify` and writes the estimator's calibration, by default the
file in `models/` that every drive of this car starts from. Stiffness at a known pressure is the tyre's law, as for a
real car, not the simulator's truth. Some ten minutes.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.axles.axles import Axles
from estimators.axles.calibration import maker_axles, to_document
from estimators.axles.identify import KnownRoad, identify, mean_matrix
from estimators.car import GRAVITY, Car
from estimators.drive_log import WHEELS
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.runner import FLUSH
from estimators.vertical_pressure.intake import SAMPLES
from testbed.notes import known_car
from testbed.scenario import Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of, needed
from testbed.simulation import Simulation

SPEEDS = (30.0, 40.0, 50.0, 62.0, 77.0, 95.0, 120.0)  # km/h
PRESSURES = ((250e3, 250e3), (180e3, 180e3), (130e3, 130e3), (180e3, 250e3), (250e3, 180e3))  # Pa, front and rear
CLASSES, ROADS_EACH = "ABCD", 2
DURATION, FIRST_SEED = 41.0, 9500  # s; seeds of their own, far from any study's


class _Listener(Axles):
    """The estimator's own ears: keeps the aligned samples instead of judging them."""

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self.heard: tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]] = ([], [])

    def _take(self, s: int, window: NDArray[np.float64], *_: object) -> None:
        self.heard[s].append(window[-SAMPLES:] if self.heard[s] else window)


def known_roads(duration: float = DURATION, cases: int | None = None) -> Iterator[KnownRoad]:
    """One of each drive; cases: the first so many only."""
    every = itertools.product(range(ROADS_EACH), SPEEDS, PRESSURES)
    for number, (_, kmh, (front, rear)) in enumerate(itertools.islice(every, cases)):
        pressures = dict(zip(WHEELS, (front, front, rear, rear), strict=True))
        road = CLASSES[number % len(CLASSES)]
        scenario = Scenario(
            road=road, speed=kmh / 3.6, duration=duration, seed=FIRST_SEED + number, pressures=pressures
        )
        yield known_road(scenario)


def known_road(scenario: Scenario) -> KnownRoad:
    """One drive at constant speed, at the pressures that the scenario begins with."""
    simulation = Simulation(scenario)
    car = known_car(simulation.vehicle, simulation.tyre, scenario)
    listener = _Listener(car)
    suite = SensorSuite(needed(sensor_settings(scenario.sensors), listener.reads), scenario.seed, simulation)
    for stretch in simulation.stretches():
        listener.update(suite.advance(motion_of(stretch, scenario.step)), float(stretch["time"][-1]) + scenario.step)
    listener.update({}, scenario.duration + FLUSH)
    law = TyreLaw.of(car)
    stiffness = [
        float(law.stiffness_at(scenario.pressures[w], scenario.speed, sum(quarter_masses(car, w)) * GRAVITY))
        for w in ("fl", "rl")
    ]
    sides = [np.concatenate(parts) for parts in listener.heard]
    return KnownRoad(mean_matrix(sides), np.array(stiffness), scenario.speed)


def document() -> dict[str, Any]:
    """The calibration of `axles`, JSON values."""
    simulation = Simulation(Scenario(duration=1.0))
    car = known_car(simulation.vehicle, simulation.tyre, simulation.scenario)
    return to_document(identify(maker_axles(car), list(known_roads())))
