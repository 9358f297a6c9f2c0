"""Randomness that belongs to an instant and not to a position in a stream: the same stamp gives the same number.

A counter-based generator (splitmix64's finaliser over key and counter; Steele, Lea, Flood, OOPSLA 2014). So nothing
depends on how a drive is cut, on its other signals, or on the order in which samples come. A stamp counts in ticks of
`quantum` [s]: a nanosecond for the samples of one signal, a cell of 10 ms where two signals of one sensor (tooth edges
and bus speed) must be hit together.
"""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

NANO = 1e-9  # s
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))


class Chance:
    """seed: of the drive, whole, >= 0. name: of the sensor and the fault. quantum: [s] of one tick."""

    def __init__(self, seed: int, name: str, quantum: float = NANO) -> None:
        digest = hashlib.sha256(f"{seed} {name}".encode()).digest()
        self._key = np.frombuffer(digest[:8], dtype=np.uint64)[0]
        self.quantum = quantum

    def uniform(self, time: NDArray[np.float64], stream: int = 0) -> NDArray[np.float64]:
        """Numbers in (0, 1) of the ticks that hold `time` [s], shape (n,). stream: another for independent ones."""
        ticks = (np.rint(time / NANO).astype(np.int64) // round(self.quantum / NANO)).view(np.uint64)
        with np.errstate(over="ignore"):
            x = (ticks + np.uint64(stream) * _MIX[1]) * _GOLDEN + self._key
            for shift, factor in ((30, _MIX[0]), (27, _MIX[1])):
                x = (x ^ (x >> np.uint64(shift))) * factor
            x ^= x >> np.uint64(31)
        return ((x >> np.uint64(11)).astype(np.float64) + 0.5) * 2.0**-53

    def normal(self, time: NDArray[np.float64], stream: int = 0) -> NDArray[np.float64]:
        """Standard normal numbers, shape (n,)."""
        return ndtri(self.uniform(time, stream))
