"""What was identified of the car in this folder on drives at known pressures: calibrations that its drives start from.

`suv_quarter_cars.json`: the quarter car of each axle for the estimator `vertical_pressure`, written by `python -m
testbed.identify quarter-cars`; fields and units in `estimators/vertical_pressure/chain.py`. `suv_axles.json`: both
axles over one road for the estimator `axles`, written by `python -m testbed.identify axles`; fields in
`estimators/axles/calibration.py`. `suv_quarter_cars_by_class.json`: the published method's nonlinear quarter cars, by
axle and road class, written by `python -m testbed.identify published`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

QUARTER_CARS = Path(__file__).with_name("suv_quarter_cars.json")
TWO_AXLES = Path(__file__).with_name("suv_axles.json")
CLASS_QUARTER_CARS = Path(__file__).with_name("suv_quarter_cars_by_class.json")
STEERING_SERVO = Path(__file__).with_name("suv_steering_servo.json")
STEERING_MONITORS = Path(__file__).with_name("suv_steering_monitors.json")


def identified() -> dict[str, dict[str, Any]]:
    """Calibrations by estimator."""
    files = {"axles": TWO_AXLES, "steering_actuator": STEERING_SERVO, "vertical_pressure": QUARTER_CARS}
    return {name: json.loads(file.read_text(encoding="utf-8")) for name, file in files.items()}


def identified_by_class() -> dict[str, dict[str, dict[str, Any]]]:
    """c, c2, k, k3 and the errors of each case, by axle and class."""
    return dict(json.loads(CLASS_QUARTER_CARS.read_text(encoding="utf-8")))


def identified_monitors() -> dict[str, dict[str, Any]]:
    """Numbers and level of the thesis' monitors of the steering actuator, by method."""
    return dict(json.loads(STEERING_MONITORS.read_text(encoding="utf-8")))
