"""A flat road: z = 0 everywhere."""

from __future__ import annotations

import numpy as np

from testbed.roads.road import ISO_SPACING, Array, Road, RoadKind


class FlatRoad(Road):
    """z = 0."""

    name = "flat"
    spacing = ISO_SPACING

    def heights(self, x: Array, y: Array) -> Array:
        return np.zeros((len(y), len(x)))


KIND = RoadKind(
    form="flat",
    example="flat",
    recognises=lambda spec: spec.strip().lower() == "flat",
    build=lambda spec, seed, length: FlatRoad(),
)
