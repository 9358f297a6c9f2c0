"""Claims about what a recording draws: bodies where MuJoCo has them, the road where it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pyarrow as pa
import pytest
from rerun.chunk import RrdReader
from scipy.spatial.transform import Rotation

from testbed.recording import RecordingWriter
from testbed.recording.road import road_piece
from testbed.recording.scene import Scene

SINGLE = 2e-6  # [m], [-]: Rerun keeps places and turns in single precision
MJCF = """
<mujoco>
  <asset>
    <hfield name="road" nrow="3" ncol="3" size="5 5 1 0.1"/>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
    <material name="paint" rgba="0.2 0.4 0.6 1"/>
  </asset>
  <worldbody>
    <geom type="hfield" hfield="road"/>
    <geom type="plane" size="0 0 1"/>
    <body name="suv/chassis" pos="1 2 3" euler="10 20 30">
      <freejoint/>
      <geom name="box" type="box" size="2 0.9 0.4" pos="0.1 0.2 0.3" euler="5 -30 70" material="paint"/>
      <geom name="tube" type="cylinder" size="0.3 0.1" pos="1 0 0" euler="90 0 15"/>
      <geom name="bar" type="capsule" size="0.05 0.6" pos="-1 0.5 0" euler="40 60 0"/>
      <geom name="ball" type="sphere" size="0.2" pos="0 0 1"/>
      <geom name="egg" type="ellipsoid" size="0.2 0.3 0.4" pos="0 1 1" euler="0 45 10"/>
      <geom name="wedge" type="mesh" mesh="wedge" pos="0 -1 0.5" euler="20 0 45"/>
      <geom name="hull" type="box" size="9 9 9" group="3"/>
      <geom name="ghost" type="box" size="9 9 9" rgba="1 1 1 0"/>
      <body name="suv/wheel_fl" pos="1.4 0.8 -0.3">
        <joint axis="0 1 0"/>
        <geom type="cylinder" size="0.35 0.1" euler="90 0 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[mujoco.MjModel, mujoco.MjData, dict[str, dict[str, Any]]]:
    """The model, its state, and every component that the recording has of it, by entity."""
    model = mujoco.MjModel.from_xml_string(MJCF)
    data = mujoco.MjData(model)
    data.qpos[-1] = 0.7
    mujoco.mj_forward(model, data)
    path = tmp_path_factory.mktemp("scene") / "scene.rrd"
    with RecordingWriter(path, {}) as writer:
        scene = Scene(writer, model)
        scene.poses([0.5], data.xpos[None], data.xquat[None])
    return model, data, components(path)


def components(path: Path) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for chunk in RrdReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        for field in batch.schema:
            if ":" in field.name:
                array = batch.column(field.name).flatten()
                width = array.type.list_size if pa.types.is_fixed_size_list(array.type) else 0
                values = np.asarray(array.flatten() if width else array)
                found.setdefault(chunk.entity_path, {})[field.name] = values.reshape(-1, width) if width else values
    return found


def body_pose(parts: dict[str, Any]) -> tuple[Rotation, np.ndarray]:
    """The pose that the viewer gives a body; scipy reads quaternions as x, y, z, w as Rerun does."""
    return Rotation.from_quat(parts["Transform3D:quaternion"][0]), parts["Transform3D:translation"][0]


def test_bodies_stand_where_mujoco_has_them(drawn: tuple[mujoco.MjModel, mujoco.MjData, dict[str, Any]]) -> None:
    _, data, entities = drawn
    for name in ("chassis", "wheel_fl"):
        turn, place = body_pose(entities[f"/world/car/suv.{name}"])
        body = data.body(f"suv/{name}")
        assert place == pytest.approx(body.xpos, abs=SINGLE)
        assert turn.as_matrix().ravel() == pytest.approx(body.xmat, abs=SINGLE)


@pytest.mark.parametrize(
    ("geom", "archetype", "place"),
    [("box", "Boxes3D", "centers"), ("tube", "Cylinders3D", "centers"), ("egg", "Ellipsoids3D", "centers")],
)
def test_shapes_lie_where_mujoco_has_them(
    drawn: tuple[mujoco.MjModel, mujoco.MjData, dict[str, Any]], geom: str, archetype: str, place: str
) -> None:
    _, data, entities = drawn
    turn, origin = body_pose(entities["/world/car/suv.chassis"])
    found = [p for e, p in entities.items() if "suv.chassis" in e and f"{archetype}:{place}" in p]
    parts = found[0]  # the larger comes first: the egg before the sphere, an ellipsoid too
    here = Rotation.from_quat(parts[f"{archetype}:quaternions"][0])
    assert turn.apply(parts[f"{archetype}:{place}"][0]) + origin == pytest.approx(data.geom(geom).xpos, abs=SINGLE)
    assert (turn * here).as_matrix().ravel() == pytest.approx(data.geom(geom).xmat, abs=SINGLE)


def test_a_capsule_starts_at_its_lower_end_and_reaches_the_upper(
    drawn: tuple[mujoco.MjModel, mujoco.MjData, dict[str, Any]],
) -> None:
    _, data, entities = drawn
    turn, origin = body_pose(entities["/world/car/suv.chassis"])
    parts = next(p for p in entities.values() if "Capsules3D:lengths" in p)
    start = parts["Capsules3D:translations"][0]
    end = start + Rotation.from_quat(parts["Capsules3D:quaternions"][0]).apply([0, 0, parts["Capsules3D:lengths"][0]])
    bar = data.geom("bar")
    half = bar.xmat.reshape(3, 3) @ [0.0, 0.0, 0.6]
    assert turn.apply(start) + origin == pytest.approx(bar.xpos - half, abs=SINGLE)
    assert turn.apply(end) + origin == pytest.approx(bar.xpos + half, abs=SINGLE)


def test_a_mesh_has_the_vertices_of_its_file(drawn: tuple[mujoco.MjModel, mujoco.MjData, dict[str, Any]]) -> None:
    _, _, entities = drawn
    parts = next(p for p in entities.values() if "Mesh3D:vertex_positions" in p)
    wedge = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    turned = Rotation.from_euler("XYZ", [20, 0, 45], degrees=True).apply(wedge)
    placed = turned + np.array([0.0, -1.0, 0.5])  # in the body's frame
    got = parts["Mesh3D:vertex_positions"]
    distance = np.linalg.norm(placed[:, None] - got[None], axis=-1).min(axis=1)
    assert distance == pytest.approx(np.zeros(4), abs=SINGLE)


def test_only_what_is_visible_is_drawn(drawn: tuple[mujoco.MjModel, mujoco.MjData, dict[str, Any]]) -> None:
    _, _, entities = drawn
    sizes = [size for parts in entities.values() for size in parts.get("Boxes3D:half_sizes", [])]
    assert [size.tolist() for size in sizes] == [pytest.approx([2.0, 0.9, 0.4])]
    assert {e for e in entities if e.startswith("/world")} == {
        "/world/car/suv.chassis",
        *(f"/world/car/suv.chassis/shape_{i}" for i in range(1, 6)),
        "/world/car/suv.wheel_fl",
    }
    assert "Boxes3D:half_sizes" in entities["/world/car/suv.chassis"]  # the camera centres on the largest shape
    colour = int(next(p for p in entities.values() if "Boxes3D:colors" in p)["Boxes3D:colors"][0])
    assert [(colour >> shift) & 255 for shift in (24, 16, 8, 0)] == [51, 102, 153, 255]  # of the material


def test_a_road_piece_keeps_to_its_budget_and_its_heights(tmp_path: Path) -> None:
    x, y = np.arange(0.0, 60.0, 0.05), np.arange(-5.0, 5.001, 0.05)
    z = 0.03 * np.sin(x / 3.0)[None, :] + 0.01 * np.cos(y)[:, None]
    with RecordingWriter(tmp_path / "empty.rrd", {}):
        pass
    with RecordingWriter(tmp_path / "road.rrd", {}) as writer:
        road_piece(writer, 7, x, y, z)
    assert (tmp_path / "road.rrd").stat().st_size - (tmp_path / "empty.rrd").stat().st_size < 200_000
    vertices = components(tmp_path / "road.rrd")["/world/road/0007"]["Mesh3D:vertex_positions"]
    assert len(vertices) > 2000
    assert vertices[:, 2] == pytest.approx(
        0.03 * np.sin(vertices[:, 0] / 3.0) + 0.01 * np.cos(vertices[:, 1]), abs=1e-5
    )
    assert (vertices.min(axis=0)[:2], vertices.max(axis=0)[:2]) == (pytest.approx([0, -5]), pytest.approx([x[-1], 5]))


def test_a_hole_in_the_road_is_a_hole(tmp_path: Path) -> None:
    x, y = np.arange(5.0), np.arange(4.0)
    z = np.zeros((4, 5))
    z[1, 2] = np.nan
    with RecordingWriter(tmp_path / "road.rrd", {}) as writer:
        road_piece(writer, 0, x, y, z)
    mesh = components(tmp_path / "road.rrd")["/world/road/0000"]
    corners = mesh["Mesh3D:vertex_positions"][mesh["Mesh3D:triangle_indices"]]
    assert not ((corners[..., 0] == 2.0) & (corners[..., 1] == 1.0)).any()
    assert len(corners) == 2 * 3 * 4 - 6
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert (up > 0).all()  # all faces look up


def test_relief_shows_in_the_colours(tmp_path: Path) -> None:
    x, y = np.arange(0.0, 20.0, 0.1), np.arange(-2.0, 2.0, 0.1)
    with RecordingWriter(tmp_path / "road.rrd", {}) as writer:
        road_piece(writer, 0, x, y, np.zeros((len(y), len(x))))
        road_piece(writer, 1, x, y, np.tile(0.005 * np.sin(2 * np.pi * x), (len(y), 1)))  # 5 mm, 1 m long
    found = components(tmp_path / "road.rrd")
    flat, rough = (found[f"/world/road/{i:04d}"]["Mesh3D:vertex_colors"].astype(np.uint32) >> 24 for i in (0, 1))
    assert np.ptp(flat) == 0
    assert rough.std() > 10  # of 255


def test_a_road_piece_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    writer = RecordingWriter(tmp_path / "road.rrd", {})
    with pytest.raises(ValueError, match=r"road piece 3: z has shape \(5, 4\), want \(4, 5\)"):
        road_piece(writer, 3, np.arange(5.0), np.arange(4.0), np.zeros((5, 4)))
    writer.close()
