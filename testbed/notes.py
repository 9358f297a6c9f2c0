"""What a recording says of itself: the scenario, the car as its maker would describe it, the versions it was made
with."""

from __future__ import annotations

import dataclasses
from importlib.metadata import version
from typing import Any

from estimators.car import Car
from testbed.simulation import Simulation

PACKAGES = ("vehicle-testbed", "mujoco", "numpy", "numba", "rerun-sdk")


def car_notes(simulation: Simulation) -> dict[str, Any]:
    """What an estimator may know of the car beforehand; SI, fields of `estimators.car.Car`."""
    v, tyre = simulation.vehicle, simulation.tyre
    body = v.chassis
    car = Car(
        cg_to_front_axle=body.cg_to_front_axle,
        cg_to_rear_axle=body.cg_to_rear_axle,
        cg_height=body.cg_height,
        front_track=v.front.track,
        rear_track=v.rear.track,
        chassis_mass=body.mass,
        front_wheel_mass=v.front.wheel_assembly_mass,
        rear_wheel_mass=v.rear.wheel_assembly_mass,
        rolling_radius=simulation.nominal_radius,
        front_wheel_inertia=v.front.spin_inertia + tyre.belt_iyy,
        rear_wheel_inertia=v.rear.spin_inertia + tyre.belt_iyy,
        steering_ratio=v.driveline.steering_ratio,
        driven_axle=simulation.scenario.driven,
        drag_area=body.drag_coefficient * body.frontal_area,
        pressure=tyre.p0,
    )
    return dataclasses.asdict(car)


def drive_notes(simulation: Simulation) -> dict[str, Any]:
    """JSON values."""
    return {
        "scenario": simulation.scenario.as_notes(),
        "car": car_notes(simulation),
        "versions": {name: version(name) for name in PACKAGES},
    }
