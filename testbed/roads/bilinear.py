"""Bilinear interpolation, on a grid of points and at one point (compiled).

A height field is a bilinear surface over its nodes; so are the measured patches (OpenCRG's own rule) and the
synthetic road between its 0.05 m nodes. An index `i` and a fraction `t` in [0, 1] stand for the point i + t in cells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from testbed.roads.road import Array

_ON_NODE = 1e-6  # [cells] a point this near a node is on it; grid points carry rounding of about 1e-11


def cell_and_fraction(position: Array) -> tuple[NDArray[np.int64], Array]:
    """Index and fraction in [0, 1) of positions given in cells."""
    position = np.asarray(position, dtype=np.float64)
    nearest = np.rint(position)
    position = np.where(np.abs(position - nearest) < _ON_NODE, nearest, position)
    index = np.floor(position)
    return index.astype(np.int64), position - index


def held_cell_and_fraction(position: Array, cells: int) -> tuple[NDArray[np.int64], Array]:
    """The same on a grid of `cells` cells, positions beyond it held at its ends; the index is 0..cells."""
    return cell_and_fraction(np.clip(position, 0.0, float(cells)))


@compiled
def bilinear_grid(values, ix, tx, iy, ty):
    """Values on the grid of points (iy + ty, ix + tx) of `values` (rows along y), shape (len(iy), len(ix))."""
    ny, nx = len(iy), len(ix)
    out = np.empty((ny, nx))
    for j in range(ny):
        low, high = values[iy[j]], values[min(iy[j] + 1, values.shape[0] - 1)]
        for i in range(nx):
            a, b = ix[i], min(ix[i] + 1, values.shape[1] - 1)
            right = (1.0 - tx[i]) * low[a] + tx[i] * low[b]
            left = (1.0 - tx[i]) * high[a] + tx[i] * high[b]
            out[j, i] = (1.0 - ty[j]) * right + ty[j] * left
    return out


@compiled
def height_at(heights, origin, x, y):
    """World height z [m] of a window at the point (x, y) [m]; beyond the window its edge is held.

    heights: (ny, nx) float32, m above z_offset; origin: [x_min, y_min, z_offset, spacing] (m).
    """
    u = min(max((x - origin[0]) / origin[3], 0.0), heights.shape[1] - 1.0)
    v = min(max((y - origin[1]) / origin[3], 0.0), heights.shape[0] - 1.0)
    i, j = min(int(u), heights.shape[1] - 2), min(int(v), heights.shape[0] - 2)
    u -= i
    v -= j
    right = (1.0 - u) * heights[j, i] + u * heights[j, i + 1]
    left = (1.0 - u) * heights[j + 1, i] + u * heights[j + 1, i + 1]
    return origin[2] + (1.0 - v) * right + v * left
