"""How a measured road of finite length goes on without end: through its own patch, turned round at random places.

The first pass runs straight through, as measured. At the end the road is read backwards, then forwards again, and so
on; each turn lies at a random cell of the patch's first or last quarter, drawn from the seed, so the height stays
continuous, nothing is invented, and no two rounds are alike. The slope changes sign at a turn. Before the start the
first value is held. Only the last KEPT legs are remembered: an endless road takes no endless memory.
"""

from __future__ import annotations

import threading
from bisect import bisect_right

import numpy as np

from testbed.roads.road import Array

KEPT = 2048  # legs, an even number; the shortest patches have legs of a few metres
_STREAM = 0x7075726E  # separates these draws from a seed's other uses


class TurningPath:
    """Maps the distance along the endless road to the place in the patch, both in cells.

    cells: length of the patch in cells, at least 1; seed: of the turning points.
    """

    def __init__(self, cells: int, seed: int) -> None:
        self._cells = cells
        self._rng = np.random.default_rng([seed, _STREAM])
        self._starts = [0, cells]  # distance at which each leg begins
        self._places = [0, cells]  # place in the patch there; legs run forwards and backwards in turn
        self._forgotten = False
        self._lock = threading.Lock()  # the drive and its recording read the same road, each in its thread

    def places(self, distance: Array) -> Array:
        """Places [cells], 0..cells, for ascending distances [cells], shape (n,). ValueError for distances on legs that
        are forgotten."""
        with self._lock:
            while self._starts[-1] <= distance[-1]:
                self._add_leg()
            if self._forgotten and distance[0] < self._starts[0]:
                raise ValueError(f"distance {distance[0]:g} cells lies on a leg that is forgotten")
            low = max(bisect_right(self._starts, distance[0]) - 1, 0)
            high = bisect_right(self._starts, distance[-1])
            starts, places = np.array(self._starts[low : high + 1]), np.array(self._places[low : high + 1])
        leg = np.clip(np.searchsorted(starts, distance, side="right") - 1, 0, None)
        direction = np.where((leg + low) % 2 == 0, 1.0, -1.0)
        return np.where(distance < 0.0, 0.0, places[leg] + direction * (distance - starts[leg]))

    def _add_leg(self) -> None:
        backwards = len(self._starts) % 2 == 0
        turn = int(self._rng.integers(0, self._cells // 4 + 1))
        if not backwards:
            turn = self._cells - turn
        self._starts.append(self._starts[-1] + abs(turn - self._places[-1]))
        self._places.append(turn)
        if len(self._starts) >= 2 * KEPT:
            del self._starts[:KEPT], self._places[:KEPT]
            self._forgotten = True
