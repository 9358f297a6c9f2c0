"""Measured roads in OpenCRG files (`*.crg`), read by pyopencrg.

What is done with the file:
- height = grid + reference-line elevation (its slope) + banking * v, as the file says; modifiers are applied if it
  has some;
- the curved reference line is straightened: u becomes x, v becomes y (a strip of the road's own texture, not its
  bends);
- NaN cells are filled across the road: linearly between measured cells, by the nearest one beyond them; a cross
  section without any value is interpolated along the road, column by column;
- beyond its width the edge value is held, so a manoeuvre that turns off the strip leaves what was measured; between
  nodes the surface is bilinear, which is OpenCRG's own rule;
- beyond its length it goes on as `turning_path` says;
- the mean height of the first metre becomes z = 0.
The wanted grid is the file's increment in u, but never finer than 0.01 m nor coarser than 0.05 m.
"""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np

from testbed.roads.bilinear import bilinear_grid, held_cell_and_fraction
from testbed.roads.road import FINEST_SPACING, ISO_SPACING, Array, Road, RoadKind
from testbed.roads.turning_path import TurningPath

_HIGHEST = 1000.0  # [m] range of heights in one patch beyond which a file is taken as damaged


def fill_missing(z: Array) -> Array:
    """Heights (nu, nv) with NaN cells filled across, then along the road; ValueError if nothing was measured."""
    z = np.array(z, dtype=np.float64)
    column = np.arange(z.shape[1], dtype=np.float64)
    known = np.isfinite(z)
    for row in np.flatnonzero(known.any(axis=1) & ~known.all(axis=1)):
        z[row] = np.interp(column, column[known[row]], z[row, known[row]])
    measured = np.flatnonzero(known.any(axis=1))
    if measured.size == 0:
        raise ValueError("no cell holds a height")
    empty = np.flatnonzero(~known.any(axis=1))
    for j in range(z.shape[1] if empty.size else 0):
        z[empty, j] = np.interp(empty, measured, z[measured, j])
    return z


class CrgRoad(Road):
    """A measured patch, straightened and continued without end.

    z: heights [m], shape (nu, nv), without NaN; u_inc: spacing along the road [m]; v: lateral positions [m], ascending.
    """

    def __init__(self, name: str, z: Array, u_inc: float, v: Array, seed: int) -> None:
        self.name = name
        self.spacing = float(np.clip(u_inc, FINEST_SPACING, ISO_SPACING))
        first_metre = max(round(1.0 / u_inc), 1)
        self._z = np.ascontiguousarray((z - z[:first_metre].mean()).T)
        self._u_inc = u_inc
        self._v = v
        self._path = TurningPath(z.shape[0] - 1, seed)

    def heights(self, x: Array, y: Array) -> Array:
        cells = self._z.shape[1] - 1
        iu, tu = held_cell_and_fraction(self._path.places(np.asarray(x) / self._u_inc), cells)
        column = np.interp(y, self._v, np.arange(len(self._v), dtype=np.float64))
        iv, tv = held_cell_and_fraction(column, len(self._v) - 1)
        return bilinear_grid(self._z, iu, tu, iv, tv)


def _one_line(error: Exception, path: str) -> str:
    words = " ".join(str(error).split()).replace(f"{path}:", "").split("To open it anyway")[0].split("Use crg.read")[0]
    return f"road file '{path}': not a sound OpenCRG file: {words.strip()}"


def _check_header(path: str) -> None:
    """ValueError for a number of the [ROAD_CRG] section that is none: the reader would take it for absent."""
    section = re.search(rb"^\$ROAD_CRG[^\n]*\n(.*?)^\$", Path(path).read_bytes(), re.MULTILINE | re.DOTALL)
    for line in section.group(1).decode("latin-1").splitlines() if section else ():
        name, equals, value = (word.strip() for word in line.partition("="))
        number = re.match(r"[+-]?(nan|inf)", value, re.IGNORECASE)
        if equals and number:
            raise ValueError(f"{name.lower()} is {number.group()}, want a finite number")


def read_crg(path: str, seed: int) -> CrgRoad:
    """Reads and prepares a file; ValueError in one line that names it if it is absent, damaged or holds no road."""
    import pyopencrg  # only roads of this kind pay for its import

    if not Path(path).is_file():
        what = "it is a folder" if Path(path).is_dir() else "there is no such file"
        raise ValueError(f"road file '{path}': {what}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            _check_header(path)
            patch = pyopencrg.read(path)
            if patch.mods:
                patch = patch.apply_mods()
        z = fill_missing(patch.surface_z())
    except (ValueError, OSError, MemoryError, KeyError, IndexError, OverflowError) as error:
        raise ValueError(_one_line(error, path)) from error
    v, u_inc = np.asarray(patch.v, dtype=np.float64), float(patch.u_inc)
    sound = np.isfinite(z).all() and np.isfinite(v).all() and 1e-4 <= u_inc <= 10.0 and np.ptp(z) < _HIGHEST
    if not sound:
        raise ValueError(
            f"road file '{path}': heights range over {np.ptp(z):.3g} m at a spacing of {u_inc:.3g} m: damaged"
        )
    return CrgRoad(path, z, u_inc, v, seed)


KIND = RoadKind(
    form="FILE.crg (OpenCRG)",
    example="road.crg",
    recognises=lambda spec: spec.strip().lower().endswith(".crg"),
    build=lambda spec, seed, length: read_crg(spec.strip(), seed),
)
