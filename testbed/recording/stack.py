"""Probabilities that sum to one, drawn on top of one another: each a band from the sum of those before to its own.

They are the estimates named `est/METHOD/road/CLASS` (`series.share_of`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from testbed.recording.series import share_of

Chunk = tuple[NDArray[np.int64], NDArray[Any]]
Band = tuple[str, NDArray[np.int64], NDArray[Any], NDArray[Any]]  # name, ticks, middle, half the width


class Stacks:
    """Collects one round of every group, which is whole once the next begins."""

    def __init__(self) -> None:
        self._rounds: dict[str, dict[str, Chunk]] = {}

    def add(self, name: str, ticks: NDArray[np.int64], values: NDArray[Any]) -> Iterator[Band]:
        """The next samples of one probability; gives the bands of a round that is whole."""
        group = name.rpartition("/")[0]
        begun = self._rounds.setdefault(group, {})
        if name in begun:
            yield from _bands(self._rounds.pop(group))
            begun = self._rounds.setdefault(group, {})
        begun[name] = ticks, values

    def rest(self) -> Iterator[Band]:
        """The rounds that were begun."""
        for begun in self._rounds.values():
            yield from _bands(begun)
        self._rounds = {}


def _bands(begun: dict[str, Chunk]) -> Iterator[Band]:
    """Of the members that came for the same times as the first one, in the order of their names."""
    members = sorted(begun.items(), key=lambda item: share_of(item[0]) or "")
    ticks = members[0][1][0]
    below = np.zeros(len(ticks))
    for name, (at, share) in members:
        if np.array_equal(at, ticks):
            yield name, ticks, below + 0.5 * share, 0.5 * np.abs(share)
            below = below + share
