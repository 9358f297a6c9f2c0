"""What every road is: a surface z(x, y) [m] over the whole plane, and a kind that recognises its text.

World axes are ISO 8855: x along the road, y to the left, z up. A road has no end: whatever its data, it answers
everywhere. Adding a kind of road is adding one file to this folder that holds a `KIND`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FINEST_SPACING = 0.01  # [m] grid of obstacles and of fine scans; a tyre's contact patch holds a dozen of these
ISO_SPACING = 0.05  # [m] Nyquist 10 cycle/m, the shortest wave of the synthetic roads


class Road(ABC):
    """A surface z(x, y) that is the same however it is read.

    name: the text that it was made from.
    spacing: grid spacing [m] that the road wants for its height field; its heights mean most on multiples of it.
    """

    name: str
    spacing: float

    @abstractmethod
    def heights(self, x: Array, y: Array) -> Array:
        """Heights z [m], shape (ny, nx), at the nodes of a grid.

        x, y: uniform ascending coordinates [m], shapes (nx,) and (ny,), multiples of `spacing`.
        A node's height does not depend on the call that asks for it.
        """


@dataclass(frozen=True)
class RoadKind:
    """How one kind of road is written and made.

    form: one short piece of text for help and for error messages.
    example: a text that makes such a road, or with a file kind a name of the right form.
    recognises: whether a text claims to be of this kind (it may still be wrong in detail).
    build: (text, seed, length [m] over which the road must not repeat) -> road; ValueError in one line.
    """

    form: str
    example: str
    recognises: Callable[[str], bool]
    build: Callable[[str, int, float], Road]


def smoothstep(t: Array) -> Array:
    """C1 step from 0 (t <= 0) to 1 (t >= 1)."""
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
