"""Claims about the moving window over MuJoCo's height field."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from testbed.roads import make_road
from testbed.roads.road import Road
from testbed.roads.window import REACH, RoadWindow, height_at, window_nodes

FLOAT32 = 5e-6  # [m] heights below 64 m in float32 (half a unit in the last place: 1.9e-6 m) plus rounding
ROUTE = [(0.0, 0.0), (9.0, 0.4), (30.0, 5.0), (24.0, -3.0), (3000.0, 800.0), (2995.0, 790.0), (-20.0, -4.0)]


def model_for(window: RoadWindow, body: str = "<body>{}</body>") -> mujoco.MjModel:
    size = " ".join(repr(value) for value in window.hfield_size)
    geom = body.format('<geom name="road" type="hfield" hfield="road"/>')
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><asset><hfield name="road" nrow="{window.ny}" ncol="{window.nx}" size="{size}"/></asset>'
        f"<worldbody>{geom}</worldbody></mujoco>"
    )


def attached(road: Road) -> tuple[RoadWindow, mujoco.MjModel, mujoco.MjData]:
    window = RoadWindow(road)
    model = model_for(window)
    window.attach(model, "road")
    return window, model, mujoco.MjData(model)


def ray_height(model: mujoco.MjModel, data: mujoco.MjData, x: float, y: float, top: float) -> float:
    start, down = np.array([x, y, top]), np.array([0.0, 0.0, -1.0])
    distance = mujoco.mj_ray(model, data, start, down, None, 1, -1, None)
    assert distance > 0.0
    return top - distance


@pytest.mark.parametrize("spec", ["C", "H"])
def test_mujoco_rays_window_and_road_agree_wherever_it_scrolls(spec: str) -> None:
    road = make_road(spec, 7, 20.0, 60.0, grade=0.08, bank=0.03)
    window, model, data = attached(road)
    rng = np.random.default_rng(1)
    for x, y in ROUTE:
        window.follow(x, y)
        mujoco.mj_forward(model, data)
        top = window.origin[2] + 90.0
        for _ in range(20):
            i, j = int(rng.integers(1, window.nx - 1)), int(rng.integers(1, window.ny - 1))
            node_x, node_y = window.origin[0] + i * window.spacing, window.origin[1] + j * window.spacing
            z = height_at(window.heights, window.origin, node_x, node_y)
            true = road.heights(np.array([node_x]), np.array([node_y]))[0, 0]
            assert z == pytest.approx(true, abs=FLOAT32)
            assert ray_height(model, data, node_x, node_y, top) == pytest.approx(z, abs=1e-9)
            # inside a cell MuJoCo has two triangles; they leave the bilinear surface by a quarter of the cell's twist
            corners = window.heights[j : j + 2, i : i + 2].astype(float)
            twist = abs(corners[0, 0] + corners[1, 1] - corners[0, 1] - corners[1, 0])
            a, b = node_x + 0.3 * window.spacing, node_y + 0.6 * window.spacing
            between = height_at(window.heights, window.origin, a, b)
            if i < window.nx - 2 and j < window.ny - 2:
                assert ray_height(model, data, a, b, top) == pytest.approx(between, abs=0.25 * twist + 1e-9)


def test_scrolled_window_is_the_freshly_filled_one() -> None:
    road = make_road("A:30,E", 3, 20.0, 60.0, obstacles=["cleat@12:height=20,length=30,side=left"])
    window, model, _ = attached(road)
    x, y = 0.0, 0.0
    for step in range(60):
        x, y = x + 0.45 * np.cos(0.1 * step), y + 0.45 * np.sin(0.1 * step)
        window.follow(x, y)
    grid_x = window.origin[0] + window.spacing * np.arange(window.nx)
    grid_y = window.origin[1] + window.spacing * np.arange(window.ny)
    exact = road.heights(grid_x, grid_y)
    np.testing.assert_allclose(window.heights + window.origin[2], exact, atol=FLOAT32)
    assert np.shares_memory(window.heights, model.hfield_data)


def test_window_always_covers_the_car_and_the_room_it_promises() -> None:
    window, _, _ = attached(make_road("C", 3, 20.0, 60.0))
    x, y = 0.0, 0.0
    rng = np.random.default_rng(2)
    for _ in range(300):
        window.follow(x, y)
        assert min(window.room) > 0.5
        heading = rng.uniform(0.0, 2.0 * np.pi)
        x, y = x + min(window.room) * np.cos(heading), y + min(window.room) * np.sin(heading)
        low, high = window.origin[:2], window.origin[:2] + 2.0 * np.array(window.half_size)
        assert (low <= np.array([x, y]) - REACH + 1e-9).all()
        assert (high >= np.array([x, y]) + REACH - 1e-9).all()


@pytest.mark.parametrize("grade", [0.2, -0.2])
def test_long_climb_keeps_data_positive_small_and_precise(grade: float) -> None:
    road = make_road("flat", 1, 20.0, 60.0, grade=grade)
    window, _, _ = attached(road)
    offsets = set()
    for x in np.arange(0.0, 4000.0, 3.0):
        window.follow(x, 0.0)
        offsets.add(window.origin[2])
        assert window.heights.min() >= 0.0
        assert window.heights.max() <= 64.0
        true = road.heights(np.array([round(x / 0.05) * 0.05]), np.zeros(1))[0, 0]
        assert height_at(window.heights, window.origin, round(x / 0.05) * 0.05, 0.0) == pytest.approx(true, abs=FLOAT32)
    assert 10 < len(offsets) < 80  # 800 m of height, re-based every 16 to 44 m


def test_height_is_bilinear_and_held_at_the_edges() -> None:
    heights = np.array([[0.0, 1.0], [2.0, 5.0]], dtype=np.float32)
    origin = np.array([10.0, -1.0, 100.0, 0.5])
    assert height_at(heights, origin, 10.25, -0.75) == pytest.approx(102.0)
    assert height_at(heights, origin, 10.5, -0.5) == pytest.approx(105.0)
    assert height_at(heights, origin, 99.0, -99.0) == pytest.approx(101.0)


@pytest.mark.parametrize("spacing", [0.01, 0.02, 0.05])
def test_default_window_covers_the_reach(spacing: float) -> None:
    nx, ny = window_nodes(spacing)
    assert 0.5 * (nx - 1) * spacing > REACH[0]
    assert 0.5 * (ny - 1) * spacing > REACH[1]


def test_window_refuses_what_would_not_be_true() -> None:
    road = make_road("flat", 1, 20.0, 60.0)
    with pytest.raises(ValueError, match="multiple"):
        RoadWindow(road, 0.03)
    with pytest.raises(ValueError, match="covers less"):
        RoadWindow(road, 0.05, 64, 64)
    window = RoadWindow(road)
    with pytest.raises(ValueError, match="not a height field"):
        window.attach(model_for(window), "raod")
    for body in ("{}", '<body pos="0 0 1" euler="0 0 9">{}</body>', "<body><freejoint/><inertial mass='1' pos='0 0 0' "
                 "diaginertia='1 1 1'/>{}</body>"):  # fmt: skip
        with pytest.raises(ValueError, match="alone, at the origin"):
            window.attach(model_for(window, body), "road")
    with pytest.raises(ValueError, match="nodes"):
        window.attach(model_for(RoadWindow(road, 0.05, 400, 256)), "road")
    window.attach(model_for(window), "road")
    with pytest.raises(ValueError, match="not finite"):
        window.follow(float("nan"), 0.0)
