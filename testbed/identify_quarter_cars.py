"""python -m testbed.identify_quarter_cars [--out FILE]: the quarter cars that `vertical_pressure` starts from.

Drives 40, 60, 80 km/h by 130, 180, 230 kPa, as the paper has them (Brancati & Tufano, Machines 2022, 10, 1221, 5.2), on
classes A to D, on roads of their own; fits one quarter car an axle (`estimators.vertical_pressure.identify`) and writes
the estimator's calibration, by default the file in `models/` that every drive of this car starts from. Stiffness at a
known pressure is the tyre's law, as for a real car, not the simulator's truth. Some five minutes.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from estimators.car import AXLES, GRAVITY, Car
from estimators.drive_log import WHEELS
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.vertical_pressure.corner import Corner, maker_corner, to_document
from estimators.vertical_pressure.identify import KnownDrive, identify
from estimators.vertical_pressure.intake import BLOCK, HubIntake
from estimators.whole_file import check_writable, write_json
from models.identified import QUARTER_CARS
from testbed.arguments import Parser
from testbed.notes import known_car
from testbed.scenario import Scenario
from testbed.sensors import SensorSuite, sensor_settings
from testbed.session import motion_of
from testbed.simulation import Simulation

CLASSES, SPEEDS, PRESSURES = "ABCD", (40.0, 60.0, 80.0), (130e3, 180e3, 230e3)  # km/h, Pa
DURATION, FIRST_SEED = 41.0, 9000  # s; seeds of their own, far from any study's
# what is left of k_t: scatter of the minute's estimates beyond their own std on the drives that were fitted
LEFT = 0.015


def decimated(hub: NDArray[np.float64]) -> NDArray[np.float64]:
    """As the estimator hears it: hub accelerations at 1 kHz, (n,) -> (n // 16,)."""
    intake = HubIntake()
    blocks = (intake.block(hub[k : k + BLOCK]) for k in range(0, len(hub) - BLOCK + 1, BLOCK))
    return np.concatenate([block for block in blocks if block is not None])


def known_drives(classes: str = CLASSES, duration: float = DURATION) -> Iterator[tuple[str, KnownDrive]]:
    """(axle, drive of one wheel) of every case."""
    for seed, (road, kmh, pressure) in enumerate(itertools.product(classes, SPEEDS, PRESSURES), FIRST_SEED):
        scenario = Scenario(
            road=road, speed=kmh / 3.6, duration=duration, seed=seed, pressures=dict.fromkeys(WHEELS, pressure)
        )
        simulation = Simulation(scenario)
        suite = SensorSuite(sensor_settings(scenario.sensors), seed, simulation)
        heard = [suite.advance(motion_of(stretch, scenario.step)) for stretch in simulation.stretches()]
        car = known_car(simulation.vehicle, simulation.tyre, scenario)
        for i, wheel in enumerate(WHEELS):
            hub = np.concatenate([signals[f"hub/{wheel}/accel_z"].value for signals in heard])
            load = sum(quarter_masses(car, wheel)) * GRAVITY
            stiffness = float(TyreLaw.of(car).stiffness_at(pressure, scenario.speed, load))
            yield AXLES[i // 2], KnownDrive(decimated(np.asarray(hub, float)), stiffness, scenario.speed)


def corners(car: Car, drives: Sequence[tuple[str, KnownDrive]]) -> dict[str, Corner]:
    """One an axle."""
    found = {}
    for axle in AXLES:
        own = [drive for name, drive in drives if name == axle]
        found[axle] = Corner(identify(maker_corner(car, axle).quarter, own).quarter, LEFT)
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0, or 2 when the file cannot be written."""
    layout = argparse.RawDescriptionHelpFormatter
    parser = Parser(prog="testbed.identify_quarter_cars", description=__doc__, formatter_class=layout)
    parser.add_argument("--out", type=Path, default=QUARTER_CARS, metavar="FILE", help="the calibration (JSON)")
    options = parser.parse_args(arguments)
    try:
        check_writable(options.out)
        simulation = Simulation(Scenario(duration=1.0))
        car = known_car(simulation.vehicle, simulation.tyre, simulation.scenario)
        document = to_document(corners(car, list(known_drives())))
        write_json(options.out, document)
    except OSError as error:
        print(f"testbed.identify_quarter_cars: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 2
    print(json.dumps(document, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
