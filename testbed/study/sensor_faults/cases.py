"""Faults that the study makes, and one trial: a copy of the estimator, as it is on a sound drive, hears one begin.

A trial watches WATCH seconds. Delay: from the fault's beginning to the time of the first alarm, which is when the
driver would be told (the estimator waits for late samples). Isolated: that alarm names the faulty sensor."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimators.drive_log import WHEELS
from estimators.faults import Injector
from estimators.redundancy.redundancy import Redundancy
from testbed.study.sensor_faults.drives import Stretch

WATCH = 3  # s
WHEEL = "wheel/{}"
ACCELEROMETER, GYRO = "imu/accel/x", "imu/gyro/z"


@dataclass(frozen=True)
class Case:
    """name: of the row; sensor: as an alarm names it, {} for a wheel that is drawn; what: kind and numbers, {sign} for
    one that is drawn; size: in the unit of the sensor, for a curve over it, None for none."""

    name: str
    sensor: str
    what: str
    size: float | None = None


BAR = (
    Case("accelerometer_bias_0p3", ACCELEROMETER, "bias:{sign}0.3", 0.3),
    Case("gyro_bias_1", GYRO, "bias:{sign}1", 1.0),
    Case("wheel_stuck", WHEEL, "stuck"),
)
OTHERS = (
    *(Case(f"accelerometer_bias_{b:g}".replace(".", "p"), ACCELEROMETER, f"bias:{{sign}}{b:g}", b)
      for b in (0.1, 0.2, 0.5, 0.8)),
    *(Case(f"gyro_bias_{b:g}".replace(".", "p"), GYRO, f"bias:{{sign}}{b:g}", b) for b in (0.25, 0.5, 2.0, 4.0)),
    *(Case(f"wheel_bias_{b:g}".replace(".", "p"), WHEEL, f"bias:{{sign}}{b:g}", b) for b in (0.25, 0.5, 1.0, 3.0)),
    Case("accelerometer_scale_0p5", ACCELEROMETER, "scale:0.5"),
    Case("accelerometer_zero", ACCELEROMETER, "zero"),
    Case("accelerometer_noise_1", ACCELEROMETER, "noise:1"),
    Case("gyro_scale_0p5", GYRO, "scale:0.5"),
    Case("gyro_zero", GYRO, "zero"),
    Case("gyro_drift_1", GYRO, "drift:{sign}1"),
    Case("wheel_scale_1p05", WHEEL, "scale:1.05"),
    Case("wheel_zero", WHEEL, "zero"),
    Case("wheel_noise_3", WHEEL, "noise:3"),
    Case("wheel_teeth_44", WHEEL, "teeth:44"),
    Case("wheel_spike_10", WHEEL, "spike:10,0.1"),
    Case("wheel_intermittent", WHEEL, "intermittent:0.2,0.7"),
)  # fmt: skip


def trial(
    estimator: Redundancy, stretches: Sequence[Stretch], first: int, start: float, case: Case,
    random: np.random.Generator, seed: int,
) -> dict[str, Any]:  # fmt: skip
    """The case's row. estimator: after stretch first - 1; start [s] lies in stretch `first`, of a second each.

    delay [s] and named: of the first alarm, null and "" without one; error: the largest that the faulty signal makes
    while nothing is told, in the signal's unit (of the accelerometer, else 0).
    """
    wheel, sign = WHEELS[int(random.integers(4))], "-" if random.random() < 0.5 else ""
    sensor = case.sensor.format(wheel)
    injector = Injector([f"{sensor}={case.what.format(sign=sign)}@{start:.4f}"], seed)
    heard, error = copy.deepcopy(estimator), 0.0
    injector.update(stretches[first - 1], float(first))
    for number in range(first, min(first + WATCH + 1, len(stretches))):
        faulty = injector.update(stretches[number], number + 1.0)
        said = heard.update(faulty, number + 1.0)
        if case.sensor == ACCELEROMETER:
            off = np.abs(faulty["imu/accel"].value[:, 0] - stretches[number]["imu/accel"].value[:, 0])
            error = max(error, float(off.max()))
        told = [alarm for alarm in said.alarms if alarm.time >= start]
        if told:
            alarm = min(told)
            named = alarm.text.split()[0]
            return {
                "case": case.name,
                "delay": alarm.time - start,
                "named": named,
                "right": named == sensor,
                "error": 0.0,
            }
    return {"case": case.name, "delay": None, "named": "", "right": False, "error": error}
