"""How a road's class changes: Markov transition matrices for any sample time.

Entry [i, j]: probability to go from mode i to mode j in one step, so rows sum to 1 (Brancati & Tufano, Machines 2022,
10, 1221, eq. 17, is symmetric and does not say). A matrix belongs to its step: with ten times the samples the same
matrix switches ten times as often. It is scaled through its generator, M(dt) = exp(log(M) dt / dt0), which exists for
every matrix whose modes stay with more than one half.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, logm

PUBLISHED_STAY, MODES = 0.97, 4  # eq. 17: 0.97 to stay, 0.01 for each other class
PUBLISHED_STEP = 1e-3  # s. Declared: the paper's sensors run at 1 kHz, its filter's step is not stated
_TOLERANCE = 1e-9  # of a row's sum, and of a rate below zero


def published() -> NDArray[np.float64]:
    """Eq. 17, shape (4, 4)."""
    other = (1.0 - PUBLISHED_STAY) / (MODES - 1)
    return np.full((MODES, MODES), other) + (PUBLISHED_STAY - other) * np.eye(MODES)


def scaled(matrix: NDArray[np.float64], step: float, wanted_step: float) -> NDArray[np.float64]:
    """The matrix of `step` [s] for another step [s]. ValueError for no transition matrix, or one without generator."""
    size = matrix.shape[0]
    if matrix.shape != (size, size) or (matrix < 0.0).any() or (abs(matrix.sum(axis=1) - 1.0) > _TOLERANCE).any():
        raise ValueError("transition matrix: want a square one with rows that sum to 1, entries of at least 0")
    if not (step > 0.0 and wanted_step > 0.0):
        raise ValueError(f"transition matrix: steps are {step} and {wanted_step} s, want numbers above 0")
    rates = logm(matrix) / step
    off = rates[~np.eye(size, dtype=bool)]
    if np.iscomplexobj(rates) or not np.isfinite(rates).all() or (off < -_TOLERANCE / step).any():
        raise ValueError("transition matrix: has no generator, so it cannot be scaled; modes must stay more often")
    result = np.maximum(expm(rates * wanted_step), 0.0)
    return result / result.sum(axis=1, keepdims=True)
