"""Decimated hub accelerations that the chain of `vertical_pressure` itself makes, for its tests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.vertical_pressure.anti_alias import STEP, analogue
from estimators.vertical_pressure.bank import (
    SENSOR_VARIANCE,
)
from estimators.vertical_pressure.chain import continuous, sampled
from estimators.vertical_pressure.corner import maker_corner
from estimators.vertical_pressure.hub_spectrum import Beside

SPEED, STIFFNESS, LEVEL = 60.0 / 3.6, 220e3, 4e-6
CORNER = maker_corner(Car(), "front")
QUARTER, LOW = CORNER.quarter, analogue()
ALONE = Beside(QUARTER, 0.0, 2.8, 1.6)


def in_band(frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    """The analogue low-pass."""
    A, B, C = LOW
    return np.array([C @ np.linalg.solve(2j * np.pi * f * np.eye(len(B)) - A, B) for f in frequency])


def drives(count: int, seconds: float, seed: int, level: float = LEVEL) -> NDArray[np.float64]:
    """Decimated hub accelerations that the chain itself makes, (count, n): driven by white noise, sampled exactly."""
    M, b, C = continuous(QUARTER, STIFFNESS, SPEED, *LOW)
    A, Q = sampled(M, b, STEP)
    rng = np.random.default_rng(seed)
    scale = np.sqrt(np.diag(Q))
    values, vectors = np.linalg.eigh(Q / np.outer(scale, scale))
    root = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)) * np.sqrt(level)
    steps = round(seconds / STEP)
    x = np.zeros((count, len(b)))
    out = np.empty((count, steps))
    for k in range(-300, steps):  # runs in
        x = x @ A.T + rng.standard_normal((count, len(b))) @ root.T
        if k >= 0:
            out[:, k] = x @ C[1]
    return out + np.sqrt(SENSOR_VARIANCE) * rng.standard_normal(out.shape)
