"""The multibody car as one MuJoCo model, composed with PyMJCF from a chassis, four corners and a road.

34 degrees of freedom: chassis 6 (free joint); per corner 7:
    travel    knuckle along the inclined suspension axis          spring, damper, stops: force elements of the loop
    recession knuckle fore and aft against its bushes             joint spring
    steer     knuckle about the kingpin                           joint spring about the commanded angle
    spin      rim about the hub
    belt_x, belt_z, belt_spin   tyre belt, a rigid ring, against the knuckle and (torsion tendon) the rim
Anti-roll bars are tendons between left and right travel. Camber and toe gain stand for the double wishbone and the
multi-link; camber acts in the tyre model only. Left out: belt motion sideways, steering-column inertia, engine mounts.

There are no contacts and no constraints: the tyre is a force element which reads the height field and writes
`xfrc_applied`. Sidewall stiffnesses are joint and tendon stiffnesses, so a change of pressure is a model edit.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from dm_control import mjcf

from models.drawing import draw_body, draw_wheel
from models.tyre_properties import TyreProperties
from models.vehicle import GRAVITY, Axle, Payload, Vehicle, joint_damping

WHEELS = ("fl", "fr", "rl", "rr")


@dataclass(frozen=True)
class RoadGrid:
    """The road window's hfield: nodes along x and y, spacing [m]."""

    columns: int
    rows: int
    spacing: float


def wheel_positions(vehicle: Vehicle) -> np.ndarray:
    """Wheel centres at the design load, from the chassis' centre of gravity, without height [m], shape (4, 2)."""
    front, rear = vehicle.chassis.cg_to_front_axle, -vehicle.chassis.cg_to_rear_axle
    half = 0.5 * vehicle.front.track, 0.5 * vehicle.rear.track
    return np.array([[front, half[0]], [front, -half[0]], [rear, half[1]], [rear, -half[1]]])


def travel_axis(axle: Axle, side: float) -> np.ndarray:
    """Unit vector along which a knuckle moves up, shape (3,); side +1 left, -1 right."""
    axis = np.array([axle.axis_forward, side * axle.axis_lateral, 1.0])
    return axis / np.linalg.norm(axis)


def design_radius(tyre: TyreProperties, load: float) -> float:
    """Loaded radius at rest, nominal pressure and the given load [N], from the quadratic load-deflection law [m]."""
    linear = np.sqrt((tyre.cz0 * tyre.r0 / tyre.fz0) ** 2 - 4.0 * tyre.q_fz2)
    share = load / tyre.fz0
    deflection = 2.0 * share * tyre.r0 / (linear + np.sqrt(linear**2 + 4.0 * tyre.q_fz2 * share))
    return float(tyre.r0 * tyre.q_re0 - deflection)


def _corner(name: str, axle: Axle, tyre: TyreProperties, side: float) -> mjcf.RootElement:
    """Knuckle, rim and belt of one wheel; its origin is the wheel centre."""
    corner = mjcf.RootElement(model=name)
    knuckle_mass = axle.wheel_assembly_mass - axle.rotating_mass - tyre.belt_mass
    if knuckle_mass <= 0.0:
        raise ValueError(f"belt mass {tyre.belt_mass} kg and rotating mass {axle.rotating_mass} kg leave no knuckle")
    hub_damping = 2.0 * axle.hub_damping_ratio * np.sqrt(axle.hub_stiffness * axle.wheel_assembly_mass)
    diametral = 0.6 * (axle.spin_inertia + tyre.belt_iyy)
    steer_inertia = diametral + 0.01 * knuckle_mass
    steer_damping = 2.0 * axle.steer_damping_ratio * np.sqrt(axle.steer_stiffness * steer_inertia)
    knuckle = corner.worldbody.add("body", name="knuckle")
    knuckle.add("inertial", mass=knuckle_mass, pos=[0, 0, 0], diaginertia=[0.01 * knuckle_mass] * 3)
    knuckle.add("joint", name="travel", type="slide", axis=travel_axis(axle, side), damping=joint_damping(axle))
    knuckle.add(
        "joint", name="recession", type="slide", axis=[1, 0, 0], stiffness=axle.hub_stiffness, damping=hub_damping
    )
    knuckle.add(
        "joint", name="steer", type="hinge", axis=[0, 0, 1], stiffness=axle.steer_stiffness, damping=steer_damping
    )
    knuckle.add("site", name="hub", pos=[0, 0, 0], size=[0.01])
    rim = knuckle.add("body", name="rim")
    spin = axle.spin_inertia
    rim.add("inertial", mass=axle.rotating_mass, pos=[0, 0, 0], diaginertia=[0.6 * spin, spin, 0.6 * spin])
    rim.add("joint", name="spin", type="hinge", axis=[0, 1, 0])
    draw_wheel(rim, tyre)
    belt = knuckle.add("body", name="belt")
    belt.add("inertial", mass=tyre.belt_mass, pos=[0, 0, 0], diaginertia=[tyre.belt_ixx, tyre.belt_iyy, tyre.belt_ixx])
    sidewall = {"stiffness": tyre.sidewall_stiffness, "damping": tyre.sidewall_damping}
    belt.add("joint", name="belt_x", type="slide", axis=[1, 0, 0], **sidewall)
    belt.add("joint", name="belt_z", type="slide", axis=[0, 0, 1], **sidewall)
    belt.add("joint", name="belt_spin", type="hinge", axis=[0, 1, 0])
    torsion = corner.tendon.add(
        "fixed",
        name="torsion",
        stiffness=tyre.torsional_stiffness,
        damping=tyre.torsional_damping,
        springlength=0.0,
    )
    torsion.add("joint", joint="belt_spin", coef=1.0)
    torsion.add("joint", joint="spin", coef=-1.0)
    corner.sensor.add("accelerometer", name="accel", site="hub")
    return corner


def compose(vehicle: Vehicle, tyre: TyreProperties, payload: Payload, grid: RoadGrid, step: float) -> mjcf.RootElement:
    """The car over its road window as a PyMJCF tree. step: integration step [s]."""
    root = mjcf.RootElement(model="car")
    root.compiler.angle = "radian"
    root.option.timestep, root.option.gravity, root.option.integrator = step, [0, 0, -GRAVITY], "implicitfast"
    for flag in ("contact", "constraint", "autoreset"):
        setattr(root.option.flag, flag, "disable")
    root.statistic.extent = 20
    root.default.geom.contype = root.default.geom.conaffinity = 0
    root.visual.map.zfar = 200
    half = [0.5 * grid.spacing * (grid.columns - 1), 0.5 * grid.spacing * (grid.rows - 1)]
    root.asset.add("hfield", name="road", ncol=grid.columns, nrow=grid.rows, size=[*half, 1.0, 1.0])
    ground = root.worldbody.add("body", name="road")  # of its own, since the road window moves it after the car
    ground.add("geom", name="road", type="hfield", hfield="road", rgba=[0.45, 0.45, 0.47, 1])
    root.worldbody.add("light", pos=[0, 0, 30], dir=[0.2, 0.2, -1], directional=True)
    body = vehicle.chassis
    chassis = root.worldbody.add("body", name="chassis", pos=[0, 0, body.cg_height])
    chassis.add("freejoint", name="chassis")
    inertia = [body.roll_inertia, body.pitch_inertia, body.yaw_inertia]
    chassis.add("inertial", mass=body.mass, pos=[0, 0, 0], diaginertia=inertia)
    chassis.add("site", name="imu", size=[0.01])
    draw_body(chassis, vehicle)
    root.sensor.add("accelerometer", name="imu_accel", site="imu")
    root.sensor.add("gyro", name="imu_gyro", site="imu")
    if payload.mass > 0.0:
        load = chassis.add("body", name="payload", pos=payload.position)
        edges = np.square(payload.size)
        load.add("inertial", mass=payload.mass, pos=[0, 0, 0], diaginertia=payload.mass / 12.0 * (edges.sum() - edges))
        load.add("geom", name="payload", type="box", size=0.5 * np.array(payload.size), rgba=[0.7, 0.5, 0.3, 1], mass=0)
    _attach_corners(root, chassis, vehicle, tyre)
    return root


def _attach_corners(root: mjcf.RootElement, chassis: mjcf.Element, vehicle: Vehicle, tyre: TyreProperties) -> None:
    corners = {}
    places = wheel_positions(vehicle)
    hub_height = [design_radius(tyre, load) for load in vehicle.static_wheel_load()]
    for i, (wheel, axle) in enumerate(zip(WHEELS, vehicle.axles, strict=True)):
        side = 1.0 if wheel.endswith("l") else -1.0
        height = hub_height[i // 2] - vehicle.chassis.cg_height
        place = chassis.add("site", name=f"wheel_{wheel}", pos=[*places[i], height], size=[0.01])
        chassis.add("site", name=f"body_{wheel}", pos=[*places[i], 0.0], size=[0.01])
        root.sensor.add("accelerometer", name=f"body_{wheel}", site=f"body_{wheel}")
        corners[wheel] = _corner(wheel, axle, tyre, side)
        place.attach(corners[wheel])
    for name, left, right in (("front", "fl", "fr"), ("rear", "rl", "rr")):
        rate = vehicle.front.anti_roll_rate if name == "front" else vehicle.rear.anti_roll_rate
        bar = root.tendon.add("fixed", name=f"anti_roll_{name}", stiffness=rate, springlength=0.0)
        bar.add("joint", joint=corners[left].find("joint", "travel"), coef=1.0)
        bar.add("joint", joint=corners[right].find("joint", "travel"), coef=-1.0)


def compile_model(root: mjcf.RootElement) -> mujoco.MjModel:
    """MuJoCo's own compiler on the composed tree (dm_control's Physics is tied to one MuJoCo version; this is not)."""
    return mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())
