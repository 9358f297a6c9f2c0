"""The car's shapes and their motion in a recording, from a MuJoCo model.

Each body with visible geoms is an entity `world/car/NAME`; its geoms are drawn once, in the body's frame, grouped by
shape, and only its pose changes. MuJoCo's quaternions (w, x, y, z) become Rerun's (x, y, z, w); a MuJoCo capsule is
centred and its half-length excludes the caps, a Rerun capsule starts at the centre of its lower cap. Left out: height
fields (the road comes piece by piece, `road.py`), planes, geoms in groups 3 and up (MuJoCo hides those too), wholly
transparent geoms.
"""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np
import rerun as rr
from numpy.typing import ArrayLike, NDArray

from testbed.recording.writer import RecordingWriter

ROOT = "world/car"
_SHOWN_GROUPS = 3  # MuJoCo's viewer shows groups 0, 1, 2
_SOLID = rr.components.FillMode.Solid


class Scene:
    """Draws a model's bodies once, and then their poses."""

    def __init__(self, writer: RecordingWriter, model: mujoco.MjModel) -> None:
        self._writer = writer
        self.entities = {body: body_entity(model, body) for body in _drawn_bodies(model)}  # body id -> entity
        for body, entity in self.entities.items():
            for index, shape in enumerate(_shapes(model, _geoms(model, body))):
                writer.show(entity if index == 0 else f"{entity}/shape_{index}", shape)

    def poses(self, time: ArrayLike, position: ArrayLike, quaternion_wxyz: ArrayLike) -> None:
        """All bodies' poses: time [s] (n,), position (n, nbody, 3) [m] as `xpos`, turn (n, nbody, 4) as `xquat`."""
        places, turns = np.asarray(position), np.asarray(quaternion_wxyz)
        for body, entity in self.entities.items():
            self._writer.pose(entity, time, places[:, body], turns[:, body])


def body_entity(model: mujoco.MjModel, body: int) -> str:
    """The entity of a body; slashes in its name (PyMJCF's scopes) become dots."""
    name = model.body(body).name or f"body_{body}"
    return f"{ROOT}/{name.strip('/').replace('/', '.')}"


def _geoms(model: mujoco.MjModel, body: int) -> list[int]:
    """Ids of a body's visible geoms."""
    start, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    left_out = (int(mujoco.mjtGeom.mjGEOM_HFIELD), int(mujoco.mjtGeom.mjGEOM_PLANE))  # numpy's int32 equals no enum
    return [
        geom
        for geom in range(start, start + count)
        if int(model.geom_type[geom]) not in left_out
        and model.geom_group[geom] < _SHOWN_GROUPS
        and _colour(model, geom)[3] > 0
    ]


def _drawn_bodies(model: mujoco.MjModel) -> list[int]:
    return [body for body in range(model.nbody) if _geoms(model, body)]


def _colour(model: mujoco.MjModel, geom: int) -> tuple[int, int, int, int]:
    material = int(model.geom_matid[geom])
    rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
    red, green, blue, alpha = (round(255 * float(c)) for c in rgba)
    return red, green, blue, alpha


def _xyzw(quaternions: NDArray[np.float64]) -> NDArray[np.float64]:
    return quaternions[:, [1, 2, 3, 0]]


def rotation(quaternion_wxyz: ArrayLike) -> NDArray[np.float64]:
    """The 3 x 3 matrix that turns vectors as a MuJoCo quaternion does."""
    flat = np.empty(9)
    mujoco.mju_quat2Mat(flat, np.asarray(quaternion_wxyz, dtype=np.float64))
    return flat.reshape(3, 3)


def _shapes(model: mujoco.MjModel, geoms: list[int]) -> Iterator[rr.AsComponents]:
    """One archetype for all geoms of a kind, in the body's frame; the largest first, for the camera follows that."""
    kinds = mujoco.mjtGeom
    largest = {int(model.geom_type[geom]): geom for geom in sorted(geoms, key=lambda geom: model.geom_rbound[geom])}
    for kind in sorted(largest, key=lambda kind: -model.geom_rbound[largest[kind]]):
        ids = [geom for geom in geoms if model.geom_type[geom] == kind]
        size, position, turn = model.geom_size[ids], model.geom_pos[ids], model.geom_quat[ids]
        colours = [_colour(model, geom) for geom in ids]
        look = {"quaternions": _xyzw(turn), "colors": colours, "fill_mode": _SOLID}
        if kind == kinds.mjGEOM_BOX:
            yield rr.Boxes3D(half_sizes=size, centers=position, **look)
        elif kind == kinds.mjGEOM_CYLINDER:
            yield rr.Cylinders3D(lengths=2.0 * size[:, 1], radii=size[:, 0], centers=position, **look)
        elif kind == kinds.mjGEOM_CAPSULE:
            starts = [p - rotation(q) @ (0.0, 0.0, s[1]) for p, q, s in zip(position, turn, size, strict=True)]
            yield rr.Capsules3D(lengths=2.0 * size[:, 1], radii=size[:, 0], translations=starts, **look)
        elif kind in (kinds.mjGEOM_SPHERE, kinds.mjGEOM_ELLIPSOID):
            half = size[:, [0, 0, 0]] if kind == kinds.mjGEOM_SPHERE else size
            yield rr.Ellipsoids3D(half_sizes=half, centers=position, **look)
        elif kind == kinds.mjGEOM_MESH:
            yield from (_mesh(model, geom) for geom in ids)


def _mesh(model: mujoco.MjModel, geom: int) -> rr.Mesh3D:
    """A mesh geom with its vertices in the body's frame."""
    mesh = model.mesh(int(model.geom_dataid[geom]))
    vertices = model.mesh_vert[int(mesh.vertadr[0]) :][: int(mesh.vertnum[0])]
    faces = model.mesh_face[int(mesh.faceadr[0]) :][: int(mesh.facenum[0])]
    placed = vertices @ rotation(model.geom_quat[geom]).T + model.geom_pos[geom]
    return rr.Mesh3D(
        vertex_positions=placed.astype(np.float32),
        triangle_indices=faces.astype(np.uint32),
        vertex_normals=_normals(placed, faces),
        albedo_factor=_colour(model, geom),
    )


def _normals(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> NDArray[np.float32]:
    """Vertex normals, each the mean of its faces' weighted by area; shape (n, 3)."""
    corners = vertices[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(total, faces[:, corner], across)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return (total / np.where(length > 0.0, length, 1.0)).astype(np.float32)
