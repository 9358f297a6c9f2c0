"""The road in a recording: one static mesh a piece, `world/road/0007`, thinned to its budget and shaded by its relief.

A centimetre of unevenness on metres of road is invisible by itself, so the colours carry it: light from ahead and left
on slopes made `_STEEPER` times steeper, and a tint from the height above the piece's own plane, brown low and pale
high. Heights themselves are drawn true to scale. Left out: everything finer than the thinned grid.
"""

from __future__ import annotations

from functools import lru_cache, partial

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike, NDArray

from testbed.recording.writer import RecordingWriter

ROOT = "world/road"
_BYTES_A_VERTEX = 40  # position 12, colour 4, two triangles 24
_BUDGET = 120_000  # bytes a piece
_STEEPER = 6.0
_LIGHT = (0.5, 0.4, 0.77)
_LOW, _HIGH = (92.0, 84.0, 78.0), (176.0, 170.0, 158.0)  # red, green, blue of 255
_FULL_TINT = 0.02  # [m] of height for the whole way from low to high, at least


def road_piece(writer: RecordingWriter, index: int, x: ArrayLike, y: ArrayLike, z: ArrayLike) -> None:
    """Draw a piece of road: x (nx,) and y (ny,) ascending [m], z (ny, nx) [m] with NaN where there is none.

    Raises ValueError if the shapes do not fit.
    """
    xs, ys, heights = (np.asarray(a, dtype=np.float64) for a in (x, y, z))
    if heights.shape != (len(ys), len(xs)) or min(heights.shape) < 2:
        raise ValueError(
            f"road piece {index}: z has shape {heights.shape}, want ({len(ys)}, {len(xs)}), 2 or more each way"
        )
    columns, rows = _thinned(xs, ys)
    thinned = xs[columns], ys[rows], heights[np.ix_(rows, columns)]  # copies: the caller may go on
    writer.show(f"{ROOT}/{index:04d}", partial(_mesh, *thinned))


def _mesh(xs: NDArray[np.float64], ys: NDArray[np.float64], heights: NDArray[np.float64]) -> rr.Mesh3D:
    """Runs in the writer's thread."""
    positions = np.empty((*heights.shape, 3), dtype=np.float32)
    positions[..., 0], positions[..., 1], positions[..., 2] = xs, ys[:, None], heights
    triangles = _triangles(*heights.shape)
    colours = _shaded(xs, ys, heights)
    if not (there := np.isfinite(heights)).all():
        triangles = triangles[there.ravel()[triangles].all(axis=1)]
        positions[~there] = 0.0
    return rr.Mesh3D(
        vertex_positions=positions.reshape(-1, 3), triangle_indices=triangles, vertex_colors=colours.ravel()
    )


@lru_cache(maxsize=8)
def _triangles(rows: int, columns: int) -> NDArray[np.uint32]:
    """Two triangles a cell, seen from above counter-clockwise; shape (n, 3)."""
    number = np.arange(rows * columns, dtype=np.uint32).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def _thinned(xs: NDArray[np.float64], ys: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which columns and rows to keep: about square cells, ends included, within the budget."""
    most = _BUDGET // _BYTES_A_VERTEX
    length, width = xs[-1] - xs[0], ys[-1] - ys[0]
    cell = np.sqrt(length * width / most)
    rows = int(np.clip(round(width / cell) + 1, 2, min(len(ys), most // 2)))
    columns = min(len(xs), max(2, most // rows))
    return (
        np.unique(np.linspace(0, len(xs) - 1, columns).round().astype(int)),
        np.unique(np.linspace(0, len(ys) - 1, rows).round().astype(int)),
    )


def _shaded(xs: NDArray[np.float64], ys: NDArray[np.float64], heights: NDArray[np.float64]) -> NDArray[np.uint32]:
    """Colours from relief as 0xRRGGBBAA, shape (ny, nx)."""
    there = np.isfinite(heights)
    filled = heights if there.all() else np.where(there, heights, heights[there].mean() if there.any() else 0.0)
    slope_y, slope_x = np.gradient(filled, ys, xs)
    facing = _LIGHT[2] - _STEEPER * (slope_x * _LIGHT[0] + slope_y * _LIGHT[1])
    light = np.clip(facing / np.sqrt(1.0 + _STEEPER**2 * (slope_x**2 + slope_y**2)), 0.0, 1.0)
    x, y, above = xs - xs.mean(), ys - ys.mean(), filled - filled.mean()
    above = above - x * (above.mean(axis=0) @ x / (x @ x)) - (y * (above.mean(axis=1) @ y / (y @ y)))[:, None]
    tint = np.clip(0.5 + above / max(_FULL_TINT, 4.0 * float(above.std())), 0.0, 1.0)
    bright = 0.35 + 0.85 * light
    red, green, blue = (
        np.minimum((low + (high - low) * tint) * bright, 255.0).astype(np.uint32)
        for low, high in zip(_LOW, _HIGH, strict=True)
    )
    return (red << 24) | (green << 16) | (blue << 8) | np.uint32(255)
