"""The steering angle that turns the wheels, in a car whose motor superposes an angle on the driver's.

There the driver's steering wheel no longer tells the road wheels' angle; the pinion does, behind the gear. An estimator
that reads `steering/angle` and knows nothing of the pinion gets, under that name, the steering-wheel angle that would
turn the wheels as far without the motor:

    steering_ratio asin(delta_G / rack_ratio),   rack_ratio = steering_ratio / wheel_gear_ratio

with the rack's law of `testbed/steering/gear.py`, which the car's maker knows. Without the pinion's message there is
none: better no steering angle than a wrong one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from estimators.car import Car
from estimators.drive_log import Signal

ANGLE, PINION = "steering/angle", "steering/pinion_angle"


def misled(reads: Collection[str], car: Car) -> bool:
    """Whether an estimator with these inputs would take the driver's angle for that of the wheels."""
    return car.motor_gear_ratio > 0.0 and ANGLE in reads and PINION not in reads


def inputs(reads: Collection[str], car: Car) -> frozenset[str]:
    """The signals that an estimator with these inputs is given, under whatever name."""
    return frozenset(reads) | ({PINION} if misled(reads, car) else frozenset())


def given(samples: Mapping[str, Signal], reads: Collection[str], car: Car) -> dict[str, Signal]:
    """What of a stretch's samples an estimator with these inputs gets."""
    heard = effective_steering(samples, car) if misled(reads, car) else samples
    return {name: heard[name] for name in reads if name in heard}


def effective_steering(samples: Mapping[str, Signal], car: Car) -> dict[str, Signal]:
    """The samples with the pinion's angle under the name of the steering wheel's."""
    found = {name: signal for name, signal in samples.items() if name not in (ANGLE, PINION)}
    pinion = samples.get(PINION)
    if pinion is not None and pinion.value.dtype.kind == "f":
        sine = np.clip(pinion.value * car.wheel_gear_ratio / car.steering_ratio, -1.0, 1.0)
        found[ANGLE] = Signal(pinion.time, car.steering_ratio * np.arcsin(sine), pinion.unit)
    return found
