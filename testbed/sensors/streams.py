"""Random streams: one for each sensor and each purpose, from the seed and the signal's name alone.

So no sensor's randomness depends on which other sensors exist, on their settings, or on how a drive is cut into chunks.
"""

from __future__ import annotations

from zlib import crc32

import numpy as np

PURPOSES = ("part", "noise", "walk", "clock", "dropout", "burst")  # append only: the position is the stream's key


def stream(seed: int, name: str, purpose: str) -> np.random.Generator:
    """Generator of one purpose of one sensor. seed: whole, >= 0. purpose: one of PURPOSES."""
    root = np.random.SeedSequence([seed, crc32(name.encode())])
    key = PURPOSES.index(purpose)
    return np.random.default_rng(root.spawn(key + 1)[key])
