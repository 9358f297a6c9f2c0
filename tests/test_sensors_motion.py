"""Motion, the sensors' input: what it refuses. Also `motion`, from which the other tests of the sensors make theirs."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from testbed.sensors.motion import WIDTHS, Motion


def motion(steps: int, first: int = 0, **fields) -> Motion:
    """A car at rest, all quantities zero, but for the fields given; each broadcasts to its shape."""
    arrays = {}
    for name, width in WIDTHS.items():
        shape = (steps, width) if width else (steps,)
        value = np.asarray(fields.get(name, 0.0), dtype=float)
        if width and value.ndim == 1 and len(value) == steps:
            value = value[:, None]
        arrays[name] = np.broadcast_to(value, shape).copy()
    return Motion(**(arrays | {"time": np.arange(first, first + steps) / 1000.0}))


def rolling(steps: int, speed: float, first: int = 0, angle: float = 0.0) -> Motion:
    """All four rims turn at a constant speed [rad/s], from `angle` [rad] at time 0."""
    time = np.arange(first, first + steps) / 1000.0
    return motion(steps, first, rim_angle=angle + speed * time, rim_speed=speed)


def pieces(whole: Motion, cuts) -> list[Motion]:
    """The same motion cut before the given rows."""
    ends = [0, *cuts, len(whole.time)]
    return [Motion(**{name: getattr(whole, name)[a:b] for name in WIDTHS}) for a, b in pairwise(ends)]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"gyro": np.zeros((9, 3))}, r"gyro has shape \(9, 3\), want \(10, 3\)"),
        ({"rim_angle": np.full((10, 4), np.nan)}, "rim_angle is nan in row 0"),
        ({"time": np.arange(10) / 500.0}, "off the sensors' grid of 1 ms"),
        ({"time": np.arange(10) / 1000.0 + 0.0004}, "off the sensors' grid of 1 ms"),
    ],
)
def test_a_motion_of_wrong_shape_value_or_time_is_refused_by_name(change, message):
    arrays = {name: getattr(motion(10), name) for name in WIDTHS} | change
    with pytest.raises(ValueError, match=message):
        Motion(**arrays)


def test_a_motion_without_rows_is_refused():
    with pytest.raises(ValueError, match="no rows"):
        motion(0)
