"""The moving window: the part of a road around the car, held in MuJoCo's own height-field array.

The array is the road's single home: the tyres read it (`height_at`, or the same four numbers of `origin`), MuJoCo
casts rays on it and draws it. Following the car scrolls it by whole cells: what stays is moved, only what is new is
asked of the road.

MuJoCo's height field: row-major, rows along y, node (0, 0) at (-rx, -ry) of the geom, nodes on both ends, so the
spacing is 2 rx / (columns - 1). Its elevation scale must be 1, so that data are metres above `z_offset`, the geom's
height. Data stay >= 0 and below 60 m, where float32 resolves 2e-6 m; when a climb leaves that range, the offset moves
and the window is filled afresh.

The geom sits in a fixed body of its own, which is moved: MuJoCo takes the world's own geoms as placed once and for all
(their bounding volumes are compiled), and its rays would miss a moved one. Its rays bound the field by the elevation,
so slanted ones may miss data above 1 m; vertical ones do not.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from testbed.roads.bilinear import height_at
from testbed.roads.road import ISO_SPACING, Array, Road

__all__ = ["REACH", "RoadWindow", "height_at", "window_nodes"]

REACH = (4.0, 3.0)  # [m] along x and y around the car's position that the window always covers
_SPARE = (6.0, 1.0)  # [m] beyond it, at least
_ISO_NODES = (512, 256)
_BASE = 1.0  # [m] thickness of the field's base, for drawing
_HEADROOM = 16.0  # [m] of data below the lowest node when the offset is set
_HIGHEST = 60.0  # [m] of data


@compiled
def move_cells(cells, by):
    """cells[k] = cells[k + by] for every k where that exists, in place."""
    if by >= 0:
        for k in range(len(cells) - by):
            cells[k] = cells[k + by]
    else:
        for k in range(len(cells) - 1, -by - 1, -1):
            cells[k] = cells[k + by]


def window_nodes(spacing: float) -> tuple[int, int]:
    """Nodes (nx, ny) of a window: 512 x 256 at 0.05 m, and never less than REACH and something to spare."""
    nx, ny = (math.ceil(2.0 * (REACH[k] + _SPARE[k]) / spacing) + 1 for k in range(2))
    return (max(nx, _ISO_NODES[0]), max(ny, _ISO_NODES[1])) if spacing >= ISO_SPACING else (nx, ny)


class RoadWindow:
    """The window of a road in a model's height field.

    road: the surface; spacing: of the field [m], a multiple of road.spacing (default: that); nx, ny: nodes.
    heights: (ny, nx) float32 view of MuJoCo's array, metres above origin[2]; valid after `attach`.
    origin: [x_min, y_min, z_offset, spacing] (m), float64, updated in place.
    room: how far the car may move along x and y [m] before the next `follow`.
    """

    heights: NDArray[np.float32]

    def __init__(self, road: Road, spacing: float | None = None, nx: int | None = None, ny: int | None = None) -> None:
        self.road = road
        self.spacing = road.spacing if spacing is None else float(spacing)
        ratio = self.spacing / road.spacing
        if not (ratio >= 1.0 - 1e-9 and abs(ratio - round(ratio)) < 1e-6):
            raise ValueError(f"window spacing {self.spacing} m must be a multiple of the road's {road.spacing} m")
        default = window_nodes(self.spacing)
        self.nx, self.ny = nx or default[0], ny or default[1]
        self._spare = (self.half_size[0] - REACH[0], self.half_size[1] - REACH[1])
        self._centre = (0.0, 0.0)
        if min(self._spare) <= 0.0:
            raise ValueError(f"window of {self.nx} x {self.ny} nodes at {self.spacing} m covers less than +-{REACH} m")
        self.origin: Array = np.array([0.0, 0.0, 0.0, self.spacing])
        self.room = (0.0, 0.0)
        self._corner = (0, 0)  # node indices of the corner in the world, in units of spacing
        self._position: Array = np.zeros(3)  # of the height field's body, once attached a view of the model's

    @property
    def half_size(self) -> tuple[float, float]:
        """rx, ry [m] of the height field."""
        return 0.5 * (self.nx - 1) * self.spacing, 0.5 * (self.ny - 1) * self.spacing

    @property
    def hfield_size(self) -> tuple[float, float, float, float]:
        """MJCF `size` of the height field: rx, ry, elevation, base [m]; nrow is ny, ncol is nx."""
        return (*self.half_size, 1.0, _BASE)

    def attach(self, model: mujoco.MjModel, geom_name: str) -> None:
        """Takes over the height field of a geom and fills it around (0, 0).

        The geom must lie, not turned, at the origin of a fixed body of its own in the world, which the window moves.
        ValueError if the geom is absent, lies elsewhere, or its field has another size.
        """
        geom = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, geom_name)
        if geom < 0 or model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_HFIELD:
            raise ValueError(f"geom '{geom_name}' is not a height field of this model")
        body = int(model.geom_bodyid[geom])
        fixed = body > 0 and model.body_parentid[body] == 0 and model.body_dofnum[body] == 0
        turned = any(
            not np.array_equal(q, (1.0, 0.0, 0.0, 0.0)) for q in (model.geom_quat[geom], model.body_quat[body])
        )
        if not fixed or turned or model.body_geomnum[body] != 1 or model.geom_pos[geom].any():
            raise ValueError(f"geom '{geom_name}' must be alone, at the origin of a fixed, unturned body in the world")
        field = int(model.geom_dataid[geom])
        nodes = (int(model.hfield_ncol[field]), int(model.hfield_nrow[field]))
        if nodes != (self.nx, self.ny) or not np.allclose(
            model.hfield_size[field][:3], self.hfield_size[:3], rtol=1e-9
        ):
            raise ValueError(
                f"height field of '{geom_name}' has {nodes[0]} x {nodes[1]} nodes of size {model.hfield_size[field]}; "
                f"the window needs {self.nx} x {self.ny} of size {self.hfield_size}"
            )
        start = int(model.hfield_adr[field])
        self.heights = model.hfield_data[start : start + self.nx * self.ny].reshape(self.ny, self.nx)
        self._position = model.body_pos[body]
        self._corner = self._corner_around(0.0, 0.0)
        self._fill_all()
        self._publish(0.0, 0.0)

    def follow(self, x: float, y: float) -> None:
        """Makes the window cover the car at (x, y) [m]; cheap when it still does with half of its room left."""
        if not (math.isfinite(x) and math.isfinite(y)):
            raise ValueError(f"the car's position ({x}, {y}) m is not finite")
        self.room = self._room_at(x, y)
        if all(room >= 0.5 * spare for room, spare in zip(self.room, self._spare, strict=True)):
            return
        corner = self._corner_around(x, y)
        di, dj = corner[0] - self._corner[0], corner[1] - self._corner[1]
        self._corner = corner
        if abs(di) >= self.nx or abs(dj) >= self.ny or not self._scroll(di, dj):
            self._fill_all()
        self._publish(x, y)

    def _corner_around(self, x: float, y: float) -> tuple[int, int]:
        return round(x / self.spacing) - (self.nx - 1) // 2, round(y / self.spacing) - (self.ny - 1) // 2

    def _room_at(self, x: float, y: float) -> tuple[float, float]:
        along, across = (max(self._spare[i] - abs(at - self._centre[i]), 0.0) for i, at in enumerate((x, y)))
        return along, across

    def _scroll(self, di: int, dj: int) -> bool:
        """Moves what stays and fills what is new; False if the new data do not fit the present offset."""
        move_cells(self.heights.reshape(-1), dj * self.nx + di)  # what runs over a row's end is filled anew below
        rows = (self.ny - dj, self.ny) if dj > 0 else (0, -dj)
        other_rows = (0, self.ny - dj) if dj > 0 else (-dj, self.ny)
        columns = (self.nx - di, self.nx) if di > 0 else (0, -di)
        return self._fill(rows, (0, self.nx)) and self._fill(other_rows, columns)

    def _road_heights(self, rows: tuple[int, int], columns: tuple[int, int]) -> Array:
        x = self.spacing * (self._corner[0] + np.arange(*columns, dtype=np.float64))
        y = self.spacing * (self._corner[1] + np.arange(*rows, dtype=np.float64))
        return self.road.heights(x, y)

    def _fill(self, rows: tuple[int, int], columns: tuple[int, int]) -> bool:
        if rows[0] == rows[1] or columns[0] == columns[1]:
            return True
        data = self._road_heights(rows, columns) - self.origin[2]
        if data.min() < 0.0 or data.max() > _HIGHEST:
            return False
        self.heights[rows[0] : rows[1], columns[0] : columns[1]] = data
        return True

    def _fill_all(self) -> None:
        z = self._road_heights((0, self.ny), (0, self.nx))
        if not np.ptp(z) < _HIGHEST - _HEADROOM - 1.0:
            raise ValueError(
                f"road '{self.road.name}' ranges over {np.ptp(z):.3g} m in one window of {2 * self.half_size[0]:.3g} m"
            )
        self.origin[2] = math.floor(z.min()) - _HEADROOM
        self.heights[:] = z - self.origin[2]

    def _publish(self, x: float, y: float) -> None:
        self.origin[0], self.origin[1] = self._corner[0] * self.spacing, self._corner[1] * self.spacing
        self._centre = (self.origin[0] + self.half_size[0], self.origin[1] + self.half_size[1])
        self._position[:] = (*self._centre, self.origin[2])
        self.room = self._room_at(x, y)
