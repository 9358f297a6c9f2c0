"""What the car looks like: massless shapes on its bodies, for recordings only.

A plain SUV of boxes, true in wheelbase, track, height and clearance. Positions from the chassis' centre of gravity.
"""

from __future__ import annotations

import numpy as np
from dm_control import mjcf

from models.tyre_properties import TyreProperties
from models.vehicle import Vehicle

PAINT = (0.12, 0.34, 0.58, 1.0)
TRIM = (0.14, 0.15, 0.17, 1.0)
HEADLAMP = (1.0, 0.96, 0.75, 1.0)
TAIL_LAMP = (0.8, 0.1, 0.1, 1.0)
GLASS = (0.55, 0.68, 0.78, 1.0)


def draw_wheel(rim: mjcf.Element, tyre: TyreProperties) -> None:
    """Tread, disc, and five spokes on either side, so that one sees it turn. All on the rim, whose pose is recorded:
    the belt is within millimetres of it."""
    half = 0.5 * tyre.width
    for name, radius, width, colour in (
        ("tread", tyre.r0, 0.75 * half, (0.09, 0.09, 0.1, 1.0)),
        ("disc", 0.97 * tyre.rim_radius, 0.8 * half, (0.72, 0.74, 0.78, 1.0)),
    ):
        line = [0, -width, 0, 0, width, 0]
        rim.add("geom", name=name, type="cylinder", fromto=line, size=[radius], rgba=colour, mass=0)
    for i in range(5):
        angle = 0.4 * np.pi * i
        x, z = 0.92 * tyre.rim_radius * np.array([np.cos(angle), np.sin(angle)])
        for side in (-1, 1):
            y = 0.85 * side * half
            name = f"spoke{i}_{'left' if side > 0 else 'right'}"
            rim.add("geom", name=name, type="capsule", fromto=[0, y, 0, x, y, z], size=[0.018], rgba=TRIM, mass=0)


def draw_body(chassis: mjcf.Element, vehicle: Vehicle) -> None:
    """Body, cabin and lamps."""
    front, rear = vehicle.chassis.cg_to_front_axle, -vehicle.chassis.cg_to_rear_axle
    width = 0.5 * vehicle.front.track + 0.1
    middle, nose, tail = 0.5 * (front + rear), front + 0.85, rear - 0.85
    between = 0.5 * (front - rear) - 0.43  # half length of the doors between the wheels
    # name, from and to along x, half width, from and to along z, colour
    boxes = (
        ("underbody", tail + 0.1, nose - 0.1, 0.66, -0.34, 0.20, TRIM),
        ("doors", middle - between, middle + between, width, -0.32, 0.24, PAINT),
        ("front_bumper", front + 0.43, nose, width - 0.03, -0.30, 0.24, PAINT),
        ("rear_bumper", tail, rear - 0.43, width - 0.03, -0.30, 0.24, PAINT),
        ("shoulders", tail + 0.03, nose - 0.05, width - 0.01, 0.22, 0.36, PAINT),
        ("glass", tail + 0.12, front - 0.35, width - 0.14, 0.36, 0.70, GLASS),
        ("roof", tail + 0.25, front - 0.75, width - 0.18, 0.70, 0.76, PAINT),
    )
    for name, x0, x1, half, z0, z1, colour in boxes:
        size, centre = [0.5 * (x1 - x0), half, 0.5 * (z1 - z0)], [0.5 * (x0 + x1), 0, 0.5 * (z0 + z1)]
        chassis.add("geom", name=name, type="box", mass=0, rgba=colour, size=size, pos=centre)
    for side in (-1, 1):
        for name, x, colour in (("lamp", nose, HEADLAMP), ("tail_lamp", tail, TAIL_LAMP)):
            chassis.add("geom", name=f"{name}{side}", type="sphere", size=[0.08], pos=[x, side * 0.65, 0.12],
                        rgba=colour, mass=0)  # fmt: skip
