"""Who is accused: what an alarm or a flag of any monitor says of sensors and tyres.

redundancy, sensor_checks     the sensor that the alarm's text begins with
steering_actuator             the motor's angle, its demand too where it does not do what is demanded; pinion and
                              steering wheel where angles contradict one another
wheel_plausibility            the wheel's speed sensor (or the wheel slips: the signals do not tell)
those of tyre pressure        `low/WHEEL`: the tyre, which is wrong if it is the sensor that is faulty
a flag `SIGNAL: ...`          the sensor of that signal
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from estimators.drive_log import WHEELS
from estimators.estimator import Alarm, Flag
from estimators.faults.targets import find_target

NAMERS = ("redundancy", "sensor_checks")
WHEEL_NAMERS = ("wheel_plausibility",)
MOTOR, DEMAND, ANGLES = "steering/motor_angle", "steering/motor_demand", ("steering/pinion_angle", "steering/angle")
# by the first two words: a motor that does not do what is demanded, or is demanded what it was not; its angle; angles
STEERING = {"motor does": (MOTOR, DEMAND), "motor angle": (MOTOR,), "angles of": ANGLES}
LOW = "low/"
BELIEVED = (" moves again", " agrees again", " is complete again")
SOURCES = {"gyro": "imu/gyro/z", "accelerometer": "imu/accel/x", "steering": "steering/angle",
           "torque": "driveline/torque"}  # fmt: skip
PAIRS = {"front": ("wheel/fl", "wheel/fr"), "rear": ("wheel/rl", "wheel/rr")}


@dataclass(frozen=True, order=True)
class Accusation:
    """time [s]; accused: a sensor as in a fault's text, or low/WHEEL; by: the monitor; flag: it is no alarm."""

    time: float
    accused: str
    by: str
    flag: bool = False


def of_alarm(monitor: str, alarm: Alarm) -> list[Accusation]:
    """What an alarm says."""
    if monitor in NAMERS:
        return [Accusation(alarm.time, alarm.text.split()[0].rstrip(":"), monitor)]
    if monitor == "steering_actuator":
        return [Accusation(alarm.time, name, monitor) for name in steering_of(alarm.text)]
    kind = "wheel/" if monitor in WHEEL_NAMERS else LOW
    return [Accusation(alarm.time, f"{kind}{wheel}", monitor) for wheel in alarm.wheels]


def of_flag(monitor: str, flag: Flag) -> list[Accusation]:
    """What a flag says; nothing of one that speaks of no signal."""
    name = sensor_of(flag.text.partition(":")[0])
    return [Accusation(flag.time, name, monitor, True)] if name else []


def withdrawn(monitor: str, alarm: Alarm) -> list[str]:
    """Sensors that the monitor accused before, maybe, and that an alarm which says more exactly who clears."""
    if monitor != "steering_actuator":
        return []
    accused = steering_of(alarm.text)
    return [name for name in (MOTOR, DEMAND, *ANGLES) if name not in accused]


def taken_back(monitor: str, flag: Flag) -> list[str]:
    """Sensors that a flag believes again."""
    if monitor == "steering_actuator":
        return [MOTOR, DEMAND, *ANGLES] if flag.text.endswith(BELIEVED) else []
    for ending in BELIEVED:
        if flag.text.endswith(ending):
            name = flag.text.removesuffix(ending).rpartition(": ")[2]
            return list(PAIRS.get(name, (SOURCES.get(name, name),)) if monitor in NAMERS else (name,))
    return []


def steering_of(text: str) -> tuple[str, ...]:
    """The sensors that an alarm of the steering's monitor accuses."""
    return STEERING[" ".join(text.split()[:2])]


def rate_of(alarm: Alarm) -> str:
    """How sure the monitor is: what its text says of its false alarms, "" if it says nothing."""
    found = re.search(r"(?:designed for|false alarms:) (one.*? in [\d.]+ h)", alarm.text)
    return f"{found[1].replace('one false alarm', 'one')}" if found else ""


def sensor_of(signal: str) -> str:
    """The sensor whose signal it is, "" if it is none."""
    name = signal.removesuffix("/edges").removesuffix("/speed") if signal.startswith("wheel/") else signal
    try:
        return find_target(name).name
    except ValueError:
        return ""


def same(accused: str, faulty: Collection[str]) -> bool:
    """Whether an accusation is right: the sensor itself, or the vector whose axis it is."""
    return any(accused == name or accused == name.rpartition("/")[0] or name == accused.rpartition("/")[0]
               for name in faulty if not accused.startswith(LOW))  # fmt: skip


def opposite(wheel: str) -> str:
    """The other wheel of the axle."""
    return WHEELS[WHEELS.index(wheel) ^ 1]
