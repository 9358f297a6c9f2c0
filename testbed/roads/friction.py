"""Friction of the road surface along and across it: `0.9`, `0.9/0.3` (left/right of y = 0), `0.9:100,0.9/0.2:50` (m).

mu is the factor that scales the tyre's peak friction; 1 is the surface on which the tyre was measured. Sections
follow one another from x = 0; before it the first one holds and behind the end the last one goes on. The change is
abrupt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from estimators.compiled import inlined
from testbed.roads.road import Array

FORM = "MU | LEFT/RIGHT | in sequence MU:METRES,LEFT/RIGHT:METRES"
_MOST = 2.0  # racing rubber on a warm track stays below this


@dataclass(frozen=True)
class FrictionMap:
    """Sections of friction, arrays of shape (n,). edges: their starts in x [m], the first -inf; left, right: mu [-]."""

    edges: Array
    left: Array
    right: Array


@inlined
def friction_at(x, y, edges, left, right):
    """mu [-] at the point (x, y) [m]; y >= 0 is left."""
    section = 0
    while section + 1 < len(edges) and x >= edges[section + 1]:
        section += 1
    return left[section] if y >= 0.0 else right[section]


def parse_friction(spec: str) -> FrictionMap:
    """A friction map from its text; ValueError in one line for anything malformed, mu <= 0, mu > 2 or NaN."""
    edges, left, right = [-math.inf], [], []
    words = spec.split(",")
    place = 0.0
    for k, word in enumerate(words):
        level, colon, metres = word.partition(":")
        sides = level.split("/")
        if len(sides) > 2:
            raise ValueError(f"friction '{spec}': '{word.strip()}' has more than two sides; valid: {FORM}")
        left.append(_number(spec, sides[0], _MOST, "mu"))
        right.append(_number(spec, sides[-1], _MOST, "mu"))
        if not colon and k < len(words) - 1:
            raise ValueError(f"friction '{spec}': section '{word.strip()}' needs a length in metres; valid: {FORM}")
        if colon:
            place += _number(spec, metres, 1e6, "length")
        if k < len(words) - 1:
            edges.append(place)
    arrays = [np.array(values) for values in (edges, left, right)]
    for array in arrays:
        array.setflags(write=False)
    return FrictionMap(*arrays)


def _number(spec: str, text: str, most: float, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value <= most:
        raise ValueError(
            f"friction '{spec}': {what} '{text.strip()}' must be above 0 and at most {most:g}; valid: {FORM}"
        )
    return value
