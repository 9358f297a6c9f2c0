"""Random streams: one for each sensor and each purpose, from the seed and the signal's name alone.

The car's seed decides what its parts are (bias, scale, tooth pitches), the drive's what they say on the day. So no
sensor's randomness depends on which other sensors exist, on their settings, or on how a drive is cut into chunks.
"""

from __future__ import annotations

from typing import NamedTuple
from zlib import crc32

import numpy as np

PART = "part"
PURPOSES = (PART, "noise", "walk", "clock", "dropout", "burst")  # append only: the position is the stream's key


class Seeds(NamedTuple):
    """Whole numbers >= 0: of the drive, and of the car's parts."""

    drive: int
    car: int


def stream(seed: int | Seeds, name: str, purpose: str) -> np.random.Generator:
    """Generator of one purpose of one sensor. seed: of the drive and its car. purpose: one of PURPOSES."""
    seeds = seed if isinstance(seed, Seeds) else Seeds(seed, seed)
    root = np.random.SeedSequence([seeds.car if purpose == PART else seeds.drive, crc32(name.encode())])
    key = PURPOSES.index(purpose)
    return np.random.default_rng(root.spawn(key + 1)[key])
