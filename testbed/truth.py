"""Truth signals of a stretch: what only a simulator knows, for plots and scores. No estimator may read them.

At 100 Hz, but for the changes that methods estimate (`testbed.course`): one mean a stretch.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS, Signal
from testbed.course import CourseTaker, truth_of
from testbed.simulation import Stretch
from testbed.trace import UNITS

RATE = 100.0  # Hz
# signal name, trace column
PER_WHEEL = (
    ("pressure", "pressure"),
    ("stiffness", "stiffness"),
    ("rolling_radius", "rolling_radius"),
    ("load", "load"),
    ("slip_ratio", "slip_ratio"),
    ("slip_angle", "slip_angle"),
    ("road_height", "road_height"),
)
# of the active steering: signal name, trace column
STEERING = (
    ("wheel_angle", "steering_wheel"),
    ("motor_angle", "motor_angle"),
    ("motor_speed", "motor_speed"),
    ("motor_torque", "motor_torque"),
    ("motor_demand", "motor_demand"),
    ("pinion_angle", "pinion_angle"),
    ("road_wheel_angle", "road_wheel_angle"),
    ("motor_locked", "motor_locked"),
)
CHANGES = (("relative_pressure_change", "Pa"), ("relative_radius_change", ""))


def attitude(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    """Roll, pitch, yaw [rad] (ISO 8855, z-y-x), shape (n, 3), of quaternions wxyz, shape (n, 4)."""
    w, x, y, z = quaternion.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.stack([roll, pitch, yaw], axis=1)


def truth_signals(stretch: Stretch, step: float, active_steering: bool = False) -> dict[str, Signal]:
    """`truth/...` of a stretch, of the active steering too if the car has it; every k-th row of the drive's clock, so
    that stretches join without a seam."""
    time = stretch["time"]
    every = max(round(1.0 / (RATE * step)), 1)
    keep = np.flatnonzero(np.rint(time / step).astype(np.int64) % every == 0)
    at = time[keep]
    signals = {
        f"truth/{wheel}/{name}": Signal(at, stretch[column][keep, i], UNITS[column])
        for name, column in PER_WHEEL
        for i, wheel in enumerate(WHEELS)
    }
    signals["truth/chassis/position"] = Signal(at, stretch["position"][keep], "m", "world")
    signals["truth/chassis/velocity"] = Signal(at, stretch["velocity"][keep], "m/s", "world")
    speed = np.linalg.norm(stretch["velocity"][keep], axis=1)
    signals["truth/chassis/speed"] = Signal(at, speed, "m/s")
    signals["truth/chassis/attitude"] = Signal(at, attitude(stretch["quaternion"][keep]), "rad", "world")
    signals["truth/chassis/path_error"] = Signal(at, stretch["path_error"][keep], "m")
    if active_steering:
        signals |= {f"truth/steering/{n}": Signal(at, stretch[c][keep], UNITS[c]) for n, c in STEERING}
    return signals


def change_signals(stretch: Stretch, nominal_pressure: float, nominal_radius: float) -> dict[str, Signal]:
    """`truth/WHEEL/relative_pressure_change` [Pa], `relative_radius_change` [-]: against nominal, less the mean of the
    four, which is what a comparison of wheels estimates. One value, the stretch's mean, at its end."""
    taker = CourseTaker()
    taker.add(stretch)
    course, reference = taker.course(), np.full(4, nominal_radius)
    found = {}
    for name, unit in CHANGES:
        for wheel in WHEELS:
            truth = truth_of(f"{wheel}/{name}", course, nominal_pressure, reference)
            if truth is not None:
                found[f"truth/{wheel}/{name}"] = Signal(course.time, truth, unit)
    return found
