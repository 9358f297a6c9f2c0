"""A road as it is driven: any raw road, faded in at the start, with grade, bank and obstacles laid over it.

z = w(x / 5 m) z_raw + grade * integral of w(x / 10 m) + bank * y * w(x / 10 m) + obstacles, with the smoothstep w:
for x <= 0 the road is flat and level, so a car put down there starts without a jolt. The spectrum of a road is its
raw road's.
"""

from __future__ import annotations

import numpy as np

from testbed.roads.obstacles import Obstacle
from testbed.roads.road import FINEST_SPACING, Array, Road, smoothstep

ROUGHNESS_FADE = 5.0  # [m]
PLANE_FADE = 10.0  # [m]


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
        if x[-1] <= 0.0:
            z = np.zeros((len(y), len(x)))
        else:
            z = self.raw.heights(x, y)
            if x[0] < ROUGHNESS_FADE:
                z *= smoothstep(x / ROUGHNESS_FADE)
        if self.grade:
            z += self.grade * _climb(x)
        if self.bank:
            z += self.bank * y[:, None] * smoothstep(x / PLANE_FADE)
        for obstacle in self.obstacles:
            if obstacle.touches(x):
                z += obstacle.heights(x, y, self.spacing)
        return z
