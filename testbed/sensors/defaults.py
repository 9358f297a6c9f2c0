"""The sensors of the car and their default settings, each number with its source. Units: SI.

"Declared" marks a figure that is chosen, not read from a data sheet; its reason follows. Noise of a sensor given as a
density d [unit/sqrt(Hz)] is d sqrt(rate / 2) per sample: white up to half the sampling rate.
"MEMS part" is an automotive six-axis part of the Bosch SMI130 / BMI055 family: 150e-6 g/sqrt(Hz), 1e-3 g/K;
0.014 deg/s/sqrt(Hz), 0.015 deg/s/K.
Left out: cross-axis sensitivity, misalignment, g-sensitivity of the gyro, the analogue bandwidth of the accelerometers.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, sqrt

from estimators.drive_log import WHEELS
from testbed.sensors.settings import AnalogueSettings, BusSpeedSettings, EncoderSettings, SensorSettings

G = 9.80665  # m/s^2
_HALF_RATE = sqrt(1000.0 / 2.0)  # sqrt(Hz), at 1 kHz
# Declared: the part's temperature wanders by 1 K in 10 min, so its offset walks by (offset per kelvin) / sqrt(600 s)
_WALK_PER_KELVIN = 1.0 / sqrt(600.0)
# Declared: message assembled in a 1 ms task, then 0.25 ms a frame at 500 kbit/s behind a few others
_BUS_DELAY = 0.002  # s


@dataclass(frozen=True)
class Channel:
    """Where an analogue sensor reads: a field of Motion, the wheel's column of it (None: all), and the log's unit."""

    field: str
    wheel: int | None
    unit: str
    frame: str = ""


IMU_ACCEL = AnalogueSettings(
    rate=1000.0,  # Hz: the suite's own step
    average=False,  # samples: at 1 kHz there is nothing to average
    noise=150e-6 * G * _HALF_RATE,  # 0.033 m/s^2: MEMS part
    bias_std=0.05,  # m/s^2. Declared: 5e-3 g left of the part's 60e-3 g after calibration in the car
    bias_walk=1e-3 * G * _WALK_PER_KELVIN,  # 4e-4 m/s^2/sqrt(s): MEMS part's drift, see above
    scale_std=0.003,  # Declared: a third of the usual 1 % limit of sensitivity
    quantisation=16.0 * G / 2**16,  # 16 bit over +-8 g
    low=-8.0 * G,
    high=8.0 * G,  # Declared: crash range is another sensor's
)

IMU_GYRO = AnalogueSettings(
    rate=1000.0,
    average=False,
    noise=radians(0.014) * _HALF_RATE,  # 5.5e-3 rad/s: MEMS part
    bias_std=radians(0.2),  # Declared: left of the part's 1 deg/s after zeroing at standstill
    bias_walk=radians(0.015) * _WALK_PER_KELVIN,  # 1.1e-5 rad/s/sqrt(s): MEMS part's drift, see above
    scale_std=0.003,  # Declared: a third of the usual 1 % limit
    quantisation=radians(500.0 / 2**16),  # 16 bit over +-250 deg/s
    low=-radians(250.0),
    high=radians(250.0),  # MEMS part's range that covers a spinning car
)

BODY_ACCEL = AnalogueSettings(
    rate=1000.0,
    average=False,
    noise=0.5,  # m/s^2: data sheet figure in the study of the sprung and unsprung accelerometers (seed 002)
    bias_std=0.1,  # m/s^2. Declared: 10e-3 g, usual for ride-height accelerometers after calibration
    bias_walk=1e-3 * G * _WALK_PER_KELVIN,  # as the MEMS part
    scale_std=0.005,  # Declared: half the usual 1 % limit
    quantisation=10.0 * G / 2**12,  # 0.024 m/s^2: 12 bit over +-5 g
    low=-5.0 * G,
    high=5.0 * G,  # Declared: above what a body corner feels over a pothole
)

HUB_ACCEL = AnalogueSettings(
    rate=1000.0,
    average=False,
    noise=0.5,  # m/s^2: as the body's, same source
    bias_std=0.1,  # m/s^2. Declared: as the body's
    bias_walk=1e-3 * G * _WALK_PER_KELVIN,
    scale_std=0.005,
    quantisation=100.0 * G / 2**14,  # 0.06 m/s^2: 14 bit over +-50 g
    low=-50.0 * G,
    high=50.0 * G,  # Declared: unsprung masses see tens of g over a pothole's edge
)

EDGES = EncoderSettings(
    teeth=48,  # usual anti-lock ring
    pitch_error=0.003,  # of a pitch, rms. Measured rings: 0.001 to 0.01
    timer=1e-6,  # s: 1 MHz capture timer
    hysteresis=0.05,  # of a pitch. Declared: 0.4 deg, a few per cent of the signal's swing
)

BUS_SPEED = BusSpeedSettings(
    rate=100.0,  # Hz: usual period of the message
    quantisation=0.01 / 3.6,  # m/s: 0.01 km/h, usual step of the message
    timeout=0.5,  # s. Declared: one tooth in 0.5 s is about 0.3 km/h
    delay=_BUS_DELAY,
)

STEERING_ANGLE = AnalogueSettings(
    rate=100.0,  # Hz: usual period of the message
    average=True,  # the sensor's own filter
    noise=radians(0.02),  # Declared: below the step
    bias_std=radians(0.5),  # Declared: zero left after wheel alignment; the sensor itself is good to 2.5 deg
    quantisation=radians(0.1),  # usual steering angle sensor
    low=-radians(780.0),
    high=radians(780.0),  # usual steering angle sensor
    delay=_BUS_DELAY,
)

ENGINE_TORQUE = AnalogueSettings(
    rate=100.0,
    average=True,  # the engine controller's model works on means of a combustion cycle
    noise=3.0,  # N m. Declared: 1 % of a 300 N m engine
    scale_std=0.02,  # Declared: the torque model's spread between engines
    quantisation=1.0,  # N m: usual step of the message
    low=-1000.0,
    high=1000.0,
    delay=_BUS_DELAY,
)

DRIVELINE_TORQUE = AnalogueSettings(
    rate=100.0,
    average=True,
    noise=10.0,  # N m at the axle. Declared: 1 % of a brisk start's 1 kN m
    scale_std=0.02,  # Declared: as the engine's, from which it is computed
    quantisation=2.0,  # N m. Declared: a 14 bit message over its range
    low=-16384.0,
    high=16382.0,
    delay=_BUS_DELAY,
)

TYRE_PRESSURE = AnalogueSettings(
    rate=1.0,  # Hz. Declared: far above a real sensor's 1/60 Hz, as a reference in short drives
    average=False,  # a radio sensor wakes up, samples and sends
    noise=500.0,  # Pa. Declared: a third of the step
    bias_std=2300.0,  # Pa: a third of the usual +-7 kPa tolerance
    quantisation=1373.0,  # Pa: usual 8 bit step; others have 2500 Pa
    low=0.0,
    high=1373.0 * 255,  # Pa: 8 bit
    delay=0.1,  # s. Declared: radio telegram and receiver
)

TYRE_TEMPERATURE = AnalogueSettings(
    rate=1.0,
    average=False,
    bias_std=1.0,  # K: a third of the usual +-3 K
    quantisation=1.0,  # K: usual 8 bit step
    low=223.0,
    high=478.0,  # K: 8 bit from -50 degC
    delay=0.1,  # s: same telegram
)

MOTOR_ANGLE = AnalogueSettings(
    rate=1000.0,  # Hz: the control unit's own task, in which its monitor runs too
    noise=radians(0.25),  # Declared: below the step
    quantisation=radians(360.0 / 1024.0),  # rad. Declared: digital motor position sensor of 10 bit a turn
)

MOTOR_DEMAND = AnalogueSettings(
    rate=1000.0,
    quantisation=radians(360.0 / 1024.0 / 16.0),  # rad. Declared: a number within the unit, finer than the sensor's
)

PINION_ANGLE = AnalogueSettings(
    rate=100.0,  # Hz: a message, as the steering-wheel angle's
    average=True,
    noise=radians(0.05),  # Declared: half a step
    bias_std=radians(0.3),  # Declared: left after adjustment; 12 deg of the motor
    quantisation=radians(0.1),  # usual steering angle sensor
    low=-radians(780.0),
    high=radians(780.0),
    delay=_BUS_DELAY,
)

_CAR: dict[str, tuple[AnalogueSettings, Channel]] = {
    "imu/accel": (IMU_ACCEL, Channel("accel_cg", None, "m/s^2", "imu")),
    "imu/gyro": (IMU_GYRO, Channel("gyro", None, "rad/s", "imu")),
    "steering/angle": (STEERING_ANGLE, Channel("steering_wheel_angle", None, "rad")),
    "engine/torque": (ENGINE_TORQUE, Channel("engine_torque", None, "N m")),
    "driveline/torque": (DRIVELINE_TORQUE, Channel("driveline_torque", None, "N m")),
}
_ACTIVE_STEERING: dict[str, tuple[AnalogueSettings, Channel]] = {
    "steering/motor_angle": (MOTOR_ANGLE, Channel("motor_angle", None, "rad")),
    "steering/motor_demand": (MOTOR_DEMAND, Channel("motor_demand", None, "rad")),
    "steering/pinion_angle": (PINION_ANGLE, Channel("pinion_angle", None, "rad")),
}
_CORNER: dict[str, tuple[AnalogueSettings, str, str]] = {
    "body/{}/accel_z": (BODY_ACCEL, "body_accel_z", "m/s^2"),
    "hub/{}/accel_z": (HUB_ACCEL, "hub_accel_z", "m/s^2"),
    "tyre/{}/pressure": (TYRE_PRESSURE, "tyre_pressure", "Pa"),
    "tyre/{}/temperature": (TYRE_TEMPERATURE, "tyre_temperature", "K"),
}

CHANNELS: dict[str, Channel] = {name: channel for name, (_, channel) in (_CAR | _ACTIVE_STEERING).items()} | {
    pattern.format(wheel): Channel(field, w, unit)
    for pattern, (_, field, unit) in _CORNER.items()
    for w, wheel in enumerate(WHEELS)
}
EDGE_NAMES = {wheel: f"wheel/{wheel}/edges" for wheel in WHEELS}
SPEED_NAMES = {wheel: f"wheel/{wheel}/speed" for wheel in WHEELS}


def default_settings(active_steering: bool = False) -> dict[str, SensorSettings]:
    """Every sensor of the car by signal name; those of its active steering if it has one."""
    settings: dict[str, SensorSettings] = {name: figures for name, (figures, _) in _CAR.items()}
    for pattern, (figures, _, _) in _CORNER.items():
        settings |= {pattern.format(wheel): figures for wheel in WHEELS}
    settings |= dict.fromkeys(EDGE_NAMES.values(), EDGES)
    settings |= dict.fromkeys(SPEED_NAMES.values(), BUS_SPEED)
    if active_steering:
        settings |= {name: figures for name, (figures, _) in _ACTIVE_STEERING.items()}
    return settings
