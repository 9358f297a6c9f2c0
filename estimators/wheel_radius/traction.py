"""What the tyres transmit along the car: force, normalised traction of driven against free wheels, pull of each axle.

Normalised traction mu of the driven wheel less that of the free one, for axle torque T, wheel inertias J, acceleration
a:
    mu = (T / (2 R) - J_d a / R^2) / F_d + (J_n a / R^2) / F_n,   F: wheel loads with load transfer m a h / (2 L)
Without a torque signal the force is taken from the accelerometer, F = m f_x + drag (f_x: specific force, so a grade
does not matter), only while the car is not slowing down. With all wheels driven there is no free one and the shares of
the axles are not known: mu is what the front wheels would have if they alone drove.

Pull is what each axle's tyres transmit, a/g on both while braking: with it left and right wheels of unlike slip
stiffness are told from unlike radii. Left out: rolling resistance, brake balance, the mass of a payload.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.car import AIR_DENSITY, GRAVITY, Car

MAX_TRACTION = 0.3  # linear part of the slip curve
BRAKING = 0.4  # [m/s^2] that the car is slower than its torque explains, plus a quarter of what the torque gives
FRONT_SHARE = {"front": 1.0, "rear": 0.0, "all": 0.5}  # of the driving force, as far as it is known


def drive_force(car: Car, speed: float, acceleration: float, accel_x: float, torque: float | None) -> float:
    """What drives the car at the wheels [N], NaN while braking or unknown. torque [N m]: None, there is no such signal;
    accel_x: specific force along the car [m/s^2]."""
    drag = air_drag(car, speed)
    if torque is None:
        return car.mass * accel_x + drag if accel_x > -BRAKING else float("nan")
    force = torque / car.rolling_radius
    expected = (force - drag) / car.mass
    felt = acceleration if np.isnan(accel_x) else accel_x
    return force if felt > expected - BRAKING - 0.25 * abs(expected) else float("nan")


def air_drag(car: Car, speed: float) -> float:
    """[N], no wind."""
    return 0.5 * AIR_DENSITY * car.drag_area * speed**2


def net_force(car: Car, force: float, speed: float, acceleration: float) -> float:
    """The driving force less drag and what spins up the wheels [N]."""
    inertia = 2.0 * (car.front_wheel_inertia + car.rear_wheel_inertia) / car.rolling_radius**2
    return force - air_drag(car, speed) - inertia * acceleration


def traction(car: Car, force: float, acceleration: float) -> float:
    """Normalised traction of the driven wheel less that of the free one [-]; NaN while braking or unknown."""
    front, rear = _on_the_ground(car, force, acceleration, 0.0 if car.driven_axle == "rear" else 1.0)
    mu = rear - front if car.driven_axle == "rear" else front - rear
    return mu if abs(mu) < MAX_TRACTION else float("nan")


def axle_pull(car: Car, force: float, speed: float, acceleration: float, accel_x: float) -> NDArray[np.float64]:
    """Force over load of the front and rear axle's tyres (2,) [-], 0 where nothing tells it."""
    if not np.isnan(force) and not np.isnan(acceleration):
        return np.array(_on_the_ground(car, force, acceleration, FRONT_SHARE[car.driven_axle]))
    felt = acceleration if np.isnan(accel_x) else accel_x
    if np.isnan(felt):
        return np.zeros(2)
    return np.full(2, (car.mass * felt + air_drag(car, speed)) / (car.mass * GRAVITY))


def _on_the_ground(car: Car, force: float, acceleration: float, front_share: float) -> tuple[float, float]:
    """Ground force over load of front and rear wheels [-]."""
    front_load, rear_load = axle_loads(car, acceleration)
    spin_up = 2.0 * acceleration / car.rolling_radius**2
    front = front_share * force - spin_up * car.front_wheel_inertia
    rear = (1.0 - front_share) * force - spin_up * car.rear_wheel_inertia
    return front / front_load, rear / rear_load


def axle_loads(car: Car, acceleration: float) -> tuple[float, float]:
    """Front and rear axle load [N] at a longitudinal acceleration [m/s^2]."""
    front_sprung = car.chassis_mass * car.cg_to_rear_axle / car.wheelbase
    front = (front_sprung + 2.0 * car.front_wheel_mass) * GRAVITY
    rear = (car.chassis_mass - front_sprung + 2.0 * car.rear_wheel_mass) * GRAVITY
    shift = car.mass * acceleration * car.cg_height / car.wheelbase
    return front - shift, rear + shift
