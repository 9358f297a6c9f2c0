"""Residuals of the thesis: each wheel against each, and each against the others' mean (eq 6.1 and 6.2).

Razavi, Lund 2006 (seed 004). Speeds in columns fl fr rl rr, any unit; residuals in the same."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

PAIRS = tuple(combinations(range(4), 2))  # eps_12, eps_13, eps_14, eps_23, eps_24, eps_34
AVERAGES = ("fl", "fr", "rl", "rr", "front_back", "sides", "diagonal")
# rows: a residual; columns: the wheels' share in it
_AVERAGE = np.array([
    [1.0, -1 / 3, -1 / 3, -1 / 3], [-1 / 3, 1.0, -1 / 3, -1 / 3], [-1 / 3, -1 / 3, 1.0, -1 / 3],
    [-1 / 3, -1 / 3, -1 / 3, 1.0], [0.5, 0.5, -0.5, -0.5], [0.5, -0.5, 0.5, -0.5], [0.5, -0.5, -0.5, 0.5],
])  # fmt: skip


def wheel_to_wheel(speed: ArrayLike) -> NDArray[np.float64]:
    """|v_i - v_j| of the PAIRS, shape (n, 6); speed (n, 4)."""
    v = np.asarray(speed, float)
    return np.stack([np.abs(v[:, i] - v[:, j]) for i, j in PAIRS], axis=1)


def averages(speed: ArrayLike) -> NDArray[np.float64]:
    """Of the AVERAGES, shape (n, 7); speed (n, 4)."""
    return np.abs(np.asarray(speed, float) @ _AVERAGE.T)
