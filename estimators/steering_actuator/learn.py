"""A calibration from sound drives of one kind of car: ratios, and both watches at a false-alarm rate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from estimators.steering_actuator.calibration import Calibration
from estimators.steering_actuator.pinion import ratios, without_offset
from estimators.steering_actuator.servo_model import CAUSES, ServoModel, simulated
from estimators.steering_actuator.watch import fitted

TARGET, PINION_TARGET = np.radians(10.0), np.radians(30.0)  # rad of motor, that the sums are the quickest for

Array = NDArray[np.float64]
Drive = tuple[Array, Array, Array, Array]  # demand, motor, pinion, steering wheel [rad], (n,), NaN where missing


def learnt(servo: ServoModel, few: Sequence[Drive], many: Sequence[Drive], rate: float) -> Calibration:
    """few: drives that the ratios are identified on; many: those that the watches are. rate: false alarms an hour, of
    both together. ValueError where they do not tell enough."""
    models = [simulated(servo, demand) for demand, *_ in many]
    errors = [angle - model[:, 0] for (_, angle, *_), model in zip(many, models, strict=True)]
    watch = fitted(errors, [model[:, CAUSES] for model in models], TARGET, 0.5 * rate)
    gap = np.full(1, np.nan)
    pinion, wheel, motor = (np.concatenate([np.concatenate([drive[i], gap]) for drive in few]) for i in (2, 3, 1))
    found = ratios(pinion, wheel, motor)
    sides = [without_offset(found, pinion, wheel, angle) for _, angle, pinion, wheel in many]
    pinion_watch = fitted([error for error, _ in sides], [causes for _, causes in sides], PINION_TARGET, 0.5 * rate)
    return Calibration(servo, watch, found, pinion_watch)
