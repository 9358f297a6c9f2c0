"""What a recording says of itself: the scenario, the car as its maker would describe it, the versions it was made
with."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from estimators.car import Car
from models.identified import identified
from models.tyre_properties import TyreProperties
from models.vehicle import Vehicle
from testbed.scenario import Scenario
from testbed.sensors import sensor_settings
from testbed.sensors.defaults import EDGE_NAMES
from testbed.sensors.settings import EncoderSettings
from testbed.simulation import Simulation, nominal_radius, radius_sensitivity, tyre_footprint, tyre_law

PACKAGES = ("vehicle-testbed", "mujoco", "numpy", "numba", "rerun-sdk")


def ring_teeth(scenario: Scenario) -> dict[str, float]:
    """Teeth of each wheel's ring."""
    settings = sensor_settings(scenario.sensors, scenario.active_steering)
    rings = {wheel: settings[name] for wheel, name in EDGE_NAMES.items()}
    return {wheel: float(ring.teeth) for wheel, ring in rings.items() if isinstance(ring, EncoderSettings)}


def known_car(vehicle: Vehicle, tyre: TyreProperties, scenario: Scenario) -> Car:
    """What an estimator may know beforehand of a car on such tyres, driven and equipped as the scenario says."""
    v, body, active = vehicle, vehicle.chassis, vehicle.active_steering
    geared: dict[str, float] = {"steering_ratio": v.driveline.steering_ratio}
    if scenario.active_steering:  # the gear's own, with the motor at rest
        geared = {
            "steering_ratio": active.wheel_ratio * active.rack_ratio,
            "wheel_gear_ratio": active.wheel_ratio,
            "motor_gear_ratio": active.motor_ratio,
        }
    return Car(
        cg_to_front_axle=body.cg_to_front_axle,
        cg_to_rear_axle=body.cg_to_rear_axle,
        cg_height=body.cg_height,
        front_track=v.front.track,
        rear_track=v.rear.track,
        chassis_mass=body.mass,
        front_wheel_mass=v.front.wheel_assembly_mass,
        rear_wheel_mass=v.rear.wheel_assembly_mass,
        rolling_radius=nominal_radius(vehicle, tyre),
        front_wheel_inertia=v.front.spin_inertia + tyre.belt_iyy,
        rear_wheel_inertia=v.rear.spin_inertia + tyre.belt_iyy,
        driven_axle=scenario.driven,
        ring_teeth=ring_teeth(scenario)["fl"],
        drag_area=body.drag_coefficient * body.frontal_area,
        pressure=tyre.p0,
        radius_sensitivity=radius_sensitivity(tyre),
        front_spring_rate=v.front.spring_rate,
        rear_spring_rate=v.rear.spring_rate,
        front_damping=0.5 * (v.front.damping_compression + v.front.damping_rebound),
        rear_damping=0.5 * (v.rear.damping_compression + v.rear.damping_rebound),
        tyre_belt_mass=tyre.belt_mass,
        tyre_footprint=tyre_footprint(vehicle, tyre),
        **geared,
        **tyre_law(vehicle, tyre),
    )


def drive_notes(
    simulation: Simulation, car: Car | None = None, calibrations: Mapping[str, Mapping[str, Any]] | None = None
) -> dict[str, Any]:
    """JSON values. car: what the estimators are told, None for the car that drives; calibrations: what they start from,
    over what `models/` holds of the car."""
    car = car or known_car(simulation.vehicle, simulation.tyre, simulation.scenario)
    return {
        "scenario": simulation.scenario.as_notes(),
        "car": dataclasses.asdict(car),
        "calibrations": {**identified(), **(calibrations or {})},
        "versions": {name: version(name) for name in PACKAGES},
    }
