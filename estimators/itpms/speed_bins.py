"""Calibration by speed: what each residual is on sound tyres, learnt at NODES of speed and interpolated between them.

A residual at speed v is a(v) + known regressors, a piecewise linear over the nodes. Learnt from all blocks of the time
after a reset together, by least squares with two priors: neighbouring nodes differ by a random step (RISE), and the
level is about nominal (LEVEL). So a node that was never driven borrows from its neighbours, and its std grows with the
distance from them. Regressors are learnt along: the gyro's offset (left-right; forgotten, it is another one the next
day), the slip per traction (front-rear), the path's curvature (left-right, diagonal). A pressure loss while learning is
learnt.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS

NODES = np.array([5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 36.0, 43.0])  # m/s
MODES = ("antiphase", "in_phase")
CONTRASTS = ("left_right", "front_rear", "diagonal")
NAMES = (*(f"{mode}/{wheel}" for mode in MODES for wheel in WHEELS), *CONTRASTS)
SIZE = len(NAMES)
# nominal level and its std, std of the step from node to node, std of one block beyond what it says of itself
LEVEL = np.array([math.log(86.0)] * 2 + [math.log(88.5)] * 2 + [math.log(40.0)] * 2 + [math.log(42.5)] * 2 + [0.0] * 3)
LEVEL_STD = np.array([0.06] * 8 + [5e-3] * 3)
RISE = np.array([3e-3] * 4 + [1.5e-2] * 4 + [1.5e-4, 3e-4, 1e-4])
CONTRAST_STD = 3e-4  # of a block's contrast, before it is measured
MEMORY = 2.0  # blocks: how far contrasts remember, by which their information is divided
SLIP, SLIP_STD = 0.045, 0.02  # per normalised traction
SLIP_DIFFERENCE_STD = 4e-3
BEND_STD = 0.1  # m
GYRO_STD = 0.01  # rad/s
LEAST_BLOCKS = 60  # with something read, from which on a calibration is one


@dataclass(frozen=True)
class LearningBlock:
    """speed [m/s]; value, variance: of NAMES, shape (SIZE,), NaN where not read; yaw_gain, traction, curvature: of
    `contrasts.RadiusBlock`."""

    speed: float
    value: NDArray[np.float64]
    variance: NDArray[np.float64]
    yaw_gain: float
    traction: float
    curvature: float


@dataclass(frozen=True)
class Calibration:
    """level, std: of NAMES at NODES, shape (SIZE, nodes); slip, bend (left-right, diagonal) and their std."""

    level: NDArray[np.float64]
    std: NDArray[np.float64]
    slip: tuple[float, float]
    bend: NDArray[np.float64]
    bend_std: NDArray[np.float64]

    def expected(self, speed: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Of NAMES at a speed [m/s]: value and std, shape (SIZE,) each."""
        weight = weights(speed)
        return self.level @ weight, self.std @ weight

    def document(self) -> dict[str, Any]:
        """JSON values."""
        table = {name: {"level": self.level[i].tolist(), "std": self.std[i].tolist()} for i, name in enumerate(NAMES)}
        bends = {"value": self.bend.tolist(), "std": self.bend_std.tolist()}
        return {"speeds": NODES.tolist(), **table, "slip": list(self.slip), "bend": bends}

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> Calibration:
        """The inverse of `document`. ValueError names what is wrong."""
        if list(document.get("speeds", ())) != NODES.tolist():
            raise ValueError(f"calibration has speeds {document.get('speeds')!r}, valid: {NODES.tolist()}")
        rows = [_numbers(document, name, ("level", "std"), len(NODES)) for name in NAMES]
        bend = _numbers(document, "bend", ("value", "std"), 2)
        slip = document.get("slip")
        if slip is None or not _finite(slip, 2):
            raise ValueError(f"calibration has slip {slip!r}, valid: value and std")
        return cls(
            np.array([row[0] for row in rows]), np.array([row[1] for row in rows]), (slip[0], slip[1]),
            np.array(bend[0]), np.array(bend[1]),
        )  # fmt: skip


def _finite(values: Any, size: int) -> bool:
    number = isinstance(values, Sequence) and not isinstance(values, str) and len(values) == size
    return number and all(isinstance(v, int | float) and math.isfinite(v) for v in values)


def _numbers(document: Mapping[str, Any], name: str, keys: tuple[str, str], size: int) -> list[list[float]]:
    entry = document.get(name)
    found = [entry.get(key) if isinstance(entry, Mapping) else None for key in keys]
    if not all(_finite(values, size) for values in found) or min(found[1]) < 0.0:  # type: ignore[arg-type]
        raise ValueError(f"calibration of {name} is {entry!r}, valid: {size} finite {keys[0]} and {keys[1]}, std >= 0")
    return found  # type: ignore[return-value]


def weights(speed: float) -> NDArray[np.float64]:
    """Of the nodes at a speed [m/s], adding up to 1; the ends hold beyond."""
    return np.array([np.interp(speed, NODES, unit) for unit in np.eye(len(NODES))])


def learn(blocks: Sequence[LearningBlock]) -> Calibration | None:
    """The calibration of all blocks, None while they are too few."""
    if sum(bool(np.isfinite(block.value).any()) for block in blocks) < LEAST_BLOCKS:
        return None
    speed = np.array([weights(block.speed) for block in blocks])
    value, variance = np.array([block.value for block in blocks]), np.array([block.variance for block in blocks])
    beside = np.array([(block.yaw_gain, block.traction, block.curvature) for block in blocks])
    level, std = np.empty((SIZE, len(NODES))), np.empty((SIZE, len(NODES)))
    slip, bend, bend_std = (SLIP, SLIP_STD), np.zeros(2), np.full(2, BEND_STD)
    regressors: dict[int, tuple[list[int], list[float], list[float]]] = {
        8: ([0, 1, 2], [0.0, 0.0, 0.0], [GYRO_STD, SLIP_DIFFERENCE_STD, BEND_STD]),
        9: ([1], [SLIP], [SLIP_STD]),
        10: ([1, 2], [0.0, 0.0], [SLIP_DIFFERENCE_STD, BEND_STD]),
    }
    for i in range(SIZE):
        columns, mean, spread = regressors.get(i, ([], [], []))
        design = np.hstack([speed, beside[:, columns]])
        found, error = _fit(i, design, value[:, i], variance[:, i], mean, spread)
        level[i], std[i] = found[: len(NODES)], error[: len(NODES)]
        rest, rest_std = found[len(NODES) :], error[len(NODES) :]
        if i == 9:
            slip = (float(rest[0]), float(rest_std[0]))
        elif i in (8, 10):
            bend[int(i == 10)], bend_std[int(i == 10)] = rest[-1], rest_std[-1]
    return Calibration(level, std, slip, bend, bend_std)


def _fit(
    i: int, design: NDArray[np.float64], value: NDArray[np.float64], variance: NDArray[np.float64],
    mean: list[float], spread: list[float],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:  # fmt: skip
    """Estimates and std of the nodes and regressors of residual i; twice, so that contrasts' noise is measured."""
    nodes, size = len(NODES), design.shape[1]
    prior, target = np.zeros((size, size)), np.zeros(size)
    step = np.diff(np.eye(nodes), axis=0)
    prior[:nodes, :nodes] = step.T @ step / RISE[i] ** 2 + np.ones((nodes, nodes)) / (nodes * LEVEL_STD[i]) ** 2
    target[:nodes] = LEVEL[i] / (nodes * LEVEL_STD[i] ** 2)
    prior[range(nodes, size), range(nodes, size)] = [s**-2.0 for s in spread]
    target[nodes:] = [m / s**2 for m, s in zip(mean, spread, strict=True)]
    read = np.isfinite(value) & np.isfinite(variance)
    noise = variance[read]
    for _ in range(2):
        information = design[read].T / noise
        covariance = np.linalg.inv(prior + information @ design[read])
        found = covariance @ (target + information @ value[read])
        if i < 8 or read.sum() < 2 * size:
            break
        rest = value[read] - design[read] @ found
        noise = np.full(
            read.sum(), MEMORY * float(np.mean(np.clip(rest, *(3.0 * CONTRAST_STD * np.array([-1.0, 1.0]))) ** 2))
        )
    return found, np.sqrt(np.diag(covariance))
