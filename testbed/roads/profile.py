"""Measured profiles as text (`*.txt`): two columns `x z` in metres, one point a line; both tracks are alike.

Columns are parted by blanks, tabs, commas or semicolons; `#` starts a comment. x must ascend, by any steps up to 10
m. The profile is resampled to 0.05 m by a monotone cubic (PCHIP), which passes through every point and does not
overshoot; it starts at x = 0 and z = 0, and beyond its end it goes on as `turning_path` says. What the points did not
sample (waves shorter than twice their spacing) stays absent. It lies along x and is the same for all y: a manoeuvre
that turns off drives along its contours, on the level.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from testbed.roads.bilinear import bilinear_grid, held_cell_and_fraction
from testbed.roads.road import ISO_SPACING, Array, Road, RoadKind
from testbed.roads.turning_path import TurningPath

_FEWEST_POINTS = 10
_WIDEST_GAP = 10.0  # [m]
_HIGHEST = 1e5  # [m]


def read_profile(path: str) -> tuple[Array, Array]:
    """x and z [m], shape (n,), of a profile file; ValueError with the line number where it is malformed."""
    try:
        lines = Path(path).read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not text"
        raise ValueError(f"road file '{path}': cannot be read: {reason}") from error
    points: list[tuple[float, float]] = []
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        x, z = _point(path, number, words)
        if points and not 0.0 < x - points[-1][0] <= _WIDEST_GAP:
            valid = f"above {points[-1][0]:g} m by at most {_WIDEST_GAP:g} m"
            raise ValueError(f"road file '{path}', line {number}: x = {x:g} m must lie {valid}")
        points.append((x, z))
    if len(points) < _FEWEST_POINTS:
        raise ValueError(f"road file '{path}': {len(points)} points, at least {_FEWEST_POINTS} are needed")
    table = np.array(points)
    return table[:, 0], table[:, 1]


def _point(path: str, number: int, words: list[str]) -> tuple[float, float]:
    try:
        x, z = (float(word) for word in words)
    except ValueError as error:
        raise ValueError(
            f"road file '{path}', line {number}: '{' '.join(words)[:60]}' is not 'x z' in metres"
        ) from error
    if not (abs(x) < 1e9 and abs(z) < _HIGHEST):
        raise ValueError(
            f"road file '{path}', line {number}: x = {x:g}, z = {z:g} is not finite or beyond {_HIGHEST:g} m"
        )
    return x, z


class ProfileRoad(Road):
    """A profile z(x), the same for all y. x, z: points [m], shape (n,), x ascending."""

    spacing = ISO_SPACING

    def __init__(self, name: str, x: Array, z: Array, seed: int) -> None:
        self.name = name
        cells = int(np.floor((x[-1] - x[0]) / ISO_SPACING + 1e-6))
        if cells < 1:
            raise ValueError(
                f"road '{name}': the profile is {x[-1] - x[0]:g} m long, at least {ISO_SPACING} m is needed"
            )
        nodes = np.minimum(x[0] + ISO_SPACING * np.arange(cells + 1), x[-1])
        self._z = np.ascontiguousarray(PchipInterpolator(x, z)(nodes) - z[0])[None, :]
        self._path = TurningPath(cells, seed)

    def heights(self, x: Array, y: Array) -> Array:
        ix, tx = held_cell_and_fraction(self._path.places(np.asarray(x) / ISO_SPACING), self._z.shape[1] - 1)
        line = bilinear_grid(self._z, ix, tx, np.zeros(1, dtype=np.int64), np.zeros(1))
        return np.repeat(line, len(y), axis=0)


KIND = RoadKind(
    form="FILE.txt (lines 'x z' in m)",
    example="profile.txt",
    recognises=lambda spec: spec.strip().lower().endswith(".txt"),
    build=lambda spec, seed, length: ProfileRoad(spec.strip(), *read_profile(spec.strip()), seed),
)
