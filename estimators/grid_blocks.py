"""Cells of a fine grid in whole blocks, for methods that work on many samples at once: the same however it was cut."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import Signal
from estimators.estimator import Flag
from estimators.grid import LATENCY, Cells, Channel, Grid

Block = tuple[int, NDArray[np.float64]]  # number, values (length, channels), NaN where missing


class GridBlocks:
    """A grid of `step` [s] and blocks of `length` cells on its own clock."""

    def __init__(self, channels: tuple[Channel, ...], step: float, length: int) -> None:
        self._grid = Grid(channels, step)
        self._channels, self._step, self._length = len(channels), step, length
        self._waiting: list[Cells] = []

    def add(self, samples: Mapping[str, Signal], until: float) -> tuple[list[Block], list[Flag]]:
        """Takes samples as they arrived before the clock `until` [s]; the blocks that are complete and hold samples, in
        time order, and flags."""
        flags = self._grid.add(samples)
        cells, more = self._grid.close(until)
        if len(cells.index):
            self._waiting.append(cells)
        return self._whole(int(np.floor((until - LATENCY) / self._step + 1e-6)) // self._length), [*flags, *more]

    def _whole(self, closed: int) -> list[Block]:
        """Blocks before number `closed`."""
        if not self._waiting:
            return []
        index = np.concatenate([cells.index for cells in self._waiting])
        value = np.concatenate([cells.value for cells in self._waiting])
        number = index // self._length
        ready = number < closed
        self._waiting = [Cells(index[~ready], index[~ready] * self._step, value[~ready])] if (~ready).any() else []
        found = []
        for block in np.unique(number[ready]).tolist():
            inside = number == block
            values = np.full((self._length, self._channels), np.nan)
            values[index[inside] - block * self._length] = value[inside]
            found.append((block, values))
        return found
