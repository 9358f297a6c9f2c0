"""Single cleats and potholes laid over any road: `cleat@50:height=20,length=30,side=left`,
`pothole@80:depth=60,length=400`.

A rectangular profile from x = 50 m on, `length` mm along the road and `height` mm up (a pothole's `depth` down),
across the whole left side (y > 0), right side or both. A grid cannot hold an upright edge: each node takes the
obstacle's mean over the cell around it, so volume and place are exact for every alignment and an edge is a ramp one
cell (0.01 m) wide.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from testbed.roads.road import FINEST_SPACING, Array

FORM = "cleat@X:height=MM,length=MM,side=left|right|both or pothole@X:depth=MM,length=MM,side=left|right|both (X in m)"
# what the wheel's two cams can roll over or drop into; beyond that the rim and the body would hit
_MOST = {"height": 150.0, "depth": 300.0}  # [mm]
_MOST_LENGTH = 10000.0  # [mm]
_SIDES = ("left", "right", "both")


@dataclass(frozen=True)
class Obstacle:
    """start, length: along x [m]; height: [m], negative for a pothole; side: left (y > 0), right or both."""

    start: float
    length: float
    height: float
    side: str

    def heights(self, x: Array, y: Array, spacing: float) -> Array:
        """Heights z [m], shape (ny, nx), as cell means on a grid of this spacing [m]."""
        along = _covered(x, spacing, self.start, self.start + self.length)
        low, high = {"left": (0.0, np.inf), "right": (-np.inf, 0.0), "both": (-np.inf, np.inf)}[self.side]
        return self.height * _covered(y, spacing, low, high)[:, None] * along

    def touches(self, x: Array) -> bool:
        """Whether any of it lies within the ascending places x [m], one cell around included."""
        return bool(x[0] <= self.start + self.length + FINEST_SPACING and x[-1] >= self.start - FINEST_SPACING)


def _covered(x: Array, spacing: float, low: float, high: float) -> Array:
    """Share of the cell of `spacing` around each x that lies in low..high."""
    inside = np.minimum(x + 0.5 * spacing, high) - np.maximum(x - 0.5 * spacing, low)
    return np.clip(inside / spacing, 0.0, 1.0)


def parse_obstacle(spec: str) -> Obstacle:
    """An obstacle from its text; ValueError in one line otherwise."""
    match = re.fullmatch(r"(cleat|pothole)@([^:]+):(.+)", spec.strip())
    if not match:
        raise ValueError(f"obstacle '{spec}' is not of the form {FORM}")
    kind, place, rest = match.groups()
    up = "height" if kind == "cleat" else "depth"
    options = dict(word.strip().partition("=")[::2] for word in rest.split(","))
    unknown = sorted(set(options) - {up, "length", "side"})
    if unknown or len(options) != len(rest.split(",")):
        bad = unknown[0] if unknown else "an option twice"
        raise ValueError(f"obstacle '{spec}': '{bad}'; valid: {up}=MM, length=MM, side={'|'.join(_SIDES)}")
    start = _number(spec, "place", place, 0.0, 1e6, "m")
    size = _number(spec, up, options.get(up, ""), 0.1, _MOST[up], "mm")
    length = _number(spec, "length", options.get("length", ""), 1.0, _MOST_LENGTH, "mm")
    side = options.get("side", "both")
    if side not in _SIDES:
        raise ValueError(f"obstacle '{spec}': side '{side}'; valid: {', '.join(_SIDES)}")
    return Obstacle(start, 1e-3 * length, 1e-3 * size * (1.0 if kind == "cleat" else -1.0), side)


def _number(spec: str, what: str, text: str, low: float, high: float, unit: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise ValueError(f"obstacle '{spec}': {what} '{text}' must be {low:g} to {high:g} {unit}")
    return value
