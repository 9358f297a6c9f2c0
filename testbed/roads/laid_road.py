"""A road as it is driven: any raw road, faded in at the start, with grade, bank and obstacles laid over it.

z = r z_raw + grade * integral of w(x / 10 m) + bank * y * w(x / 10 m) + obstacles, with the smoothstep w and

    r = max(w(x / 5 m), w((|y| - 3 m) / 5 m))

So a lane 6 m wide that leads to the start is flat, and a car put down there starts without a jolt; beside it, and
wherever else a circle may come back behind the start, the road is rough. For x <= 0 it is level. The spectrum of a road
is its raw road's. Places of sections, friction and obstacles are along x, the direction in which a drive begins.
"""

from __future__ import annotations

import numpy as np

from testbed.roads.obstacles import Obstacle
from testbed.roads.road import FINEST_SPACING, Array, Road, smoothstep

ROUGHNESS_FADE = 5.0  # [m]
PLANE_FADE = 10.0  # [m]
LANE = 3.0  # [m] to either side of y = 0 that is flat before the start
LANE_FADE = 5.0  # [m]


def _climb(x: Array) -> Array:
    """Integral of smoothstep(x / PLANE_FADE) [m]."""
    t = np.clip(x / PLANE_FADE, 0.0, 1.0)
    return PLANE_FADE * (t**3 - 0.5 * t**4) + np.maximum(x - PLANE_FADE, 0.0)


class LaidRoad(Road):
    """raw: the road below; grade: rise over run along x [-]; bank: rise towards the left [-]; obstacles on top."""

    def __init__(self, raw: Road, grade: float = 0.0, bank: float = 0.0, obstacles: tuple[Obstacle, ...] = ()) -> None:
        self.raw = raw
        self.name = raw.name
        self.spacing = min(raw.spacing, FINEST_SPACING) if obstacles else raw.spacing
        self.grade = grade
        self.bank = bank
        self.obstacles = obstacles

    def heights(self, x: Array, y: Array) -> Array:
        x, y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
        beside = smoothstep((np.abs(y) - LANE) / LANE_FADE)
        if x[-1] <= 0.0 and not beside.any():
            z = np.zeros((len(y), len(x)))
        else:
            z = self.raw.heights(x, y)
            if x[0] < ROUGHNESS_FADE:
                z *= np.maximum(smoothstep(x / ROUGHNESS_FADE), beside[:, None])
        if self.grade:
            z += self.grade * _climb(x)
        if self.bank:
            z += self.bank * y[:, None] * smoothstep(x / PLANE_FADE)
        for obstacle in self.obstacles:
            if obstacle.touches(x):
                z += obstacle.heights(x, y, self.spacing)
        return z
