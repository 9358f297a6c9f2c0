"""Learning a car after a reset: levels of all residuals over speed from all blocks together, by least squares.

Frequencies of the four wheels at a mode's nodes have the prior of `mode_nodes`. Of radius contrasts neighbouring nodes
differ by a random step (RISE) and the level is about 0 (LEVEL_STD). So a node that was never driven borrows from its
neighbours, and its std grows with the distance from them. Regressors of contrasts are learnt along: the gyro's offset
(left-right; forgotten, it is another one the next day), the slip per traction (front-rear), the path's curvature
(left-right, diagonal). A pressure loss while learning is learnt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.itpms.mode_nodes import MODE_NODES, NODES, ModeNodes, remaining, weights
from estimators.itpms.speed_bins import CONTRASTS, FREQUENCIES, SIZE, Calibration

LEVEL_STD, RISE = 5e-3, (1.5e-4, 3e-4, 1e-4)  # of contrasts
CONTRAST_STD = 3e-4  # of a block's contrast, before it is measured
MEMORY = 2.0  # blocks: how far contrasts remember, by which their information is divided
SLIP, SLIP_STD = 0.045, 0.02  # per normalised traction
SLIP_DIFFERENCE_STD = 4e-3
BEND_STD = 0.1  # m
GYRO_STD = 0.01  # rad/s
LEAST_BLOCKS = 60  # with something read, from which on a calibration is one
Array = NDArray[np.float64]


@dataclass(frozen=True)
class LearningBlock:
    """speed [m/s]; value, variance: of `speed_bins.NAMES`, shape (SIZE,), NaN where not read; yaw_gain, traction,
    curvature: of `contrasts.RadiusBlock`."""

    speed: float
    value: Array
    variance: Array
    yaw_gain: float
    traction: float
    curvature: float


def learn(blocks: Sequence[LearningBlock]) -> Calibration | None:
    """The calibration of all blocks, None while they are too few."""
    if sum(bool(np.isfinite(block.value).any()) for block in blocks) < LEAST_BLOCKS:
        return None
    speed = np.array([weights(block.speed) for block in blocks])
    value, variance = np.array([block.value for block in blocks]), np.array([block.variance for block in blocks])
    beside = np.array([(block.yaw_gain, block.traction, block.curvature) for block in blocks])
    level, std, told = np.empty((SIZE, len(NODES))), np.empty((3, len(NODES))), []
    for m, mode in enumerate(MODE_NODES):
        rows = slice(4 * m, 4 * m + 4)
        level[rows], information = _frequencies(
            mode, speed[:, mode.first : mode.last], value[:, rows], variance[:, rows]
        )
        told.append(information)
    slip, bend, bend_std = (SLIP, SLIP_STD), np.zeros(2), np.full(2, BEND_STD)
    regressors: dict[str, tuple[list[int], list[float], list[float]]] = {
        "left_right": ([0, 1, 2], [0.0, 0.0, 0.0], [GYRO_STD, SLIP_DIFFERENCE_STD, BEND_STD]),
        "front_rear": ([1], [SLIP], [SLIP_STD]),
        "diagonal": ([1, 2], [0.0, 0.0], [SLIP_DIFFERENCE_STD, BEND_STD]),
    }
    for c, name in enumerate(CONTRASTS):
        columns, mean, spread = regressors[name]
        i = len(FREQUENCIES) + c
        design = np.hstack([speed, beside[:, columns]])
        found, error = _contrast(RISE[c], design, value[:, i], variance[:, i], mean, spread)
        level[i], std[c] = found[: len(NODES)], error[: len(NODES)]
        rest, rest_std = found[len(NODES) :], error[len(NODES) :]
        if name == "front_rear":
            slip = (float(rest[0]), float(rest_std[0]))
        else:
            bend[c // 2], bend_std[c // 2] = rest[-1], rest_std[-1]
    return Calibration(level, tuple(told), std, slip, bend, bend_std)


def _frequencies(mode: ModeNodes, weight: Array, value: Array, variance: Array) -> tuple[Array, Array]:
    """weight: of the nodes in each block, shape (n, K); value, variance: shape (n, 4). Levels at all NODES, shape
    (4, nodes), and information, shape (4, K, K)."""
    read = np.isfinite(value) & np.isfinite(variance)
    sure = np.where(read, 1.0 / np.where(read, variance, 1.0), 0.0)
    information = np.einsum("nw,nj,nk->wjk", sure, weight, weight)
    expected = mode.expected()
    rest = np.where(read, value - weight @ expected.T, 0.0)
    told = np.einsum("nw,nw,nk->wk", sure, rest, weight)
    off = remaining(mode.spread(), information) @ told.reshape(-1)
    return mode.everywhere(expected + off.reshape(expected.shape)), information


def _contrast(
    rise: float, design: Array, value: Array, variance: Array, mean: list[float], spread: list[float]
) -> tuple[Array, Array]:
    """Estimates and std of the nodes and regressors of a contrast; twice, so that its noise is measured."""
    nodes, size = len(NODES), design.shape[1]
    prior, target = np.zeros((size, size)), np.zeros(size)
    step = np.diff(np.eye(nodes), axis=0)
    prior[:nodes, :nodes] = step.T @ step / rise**2 + np.ones((nodes, nodes)) / (nodes * LEVEL_STD) ** 2
    prior[range(nodes, size), range(nodes, size)] = [s**-2.0 for s in spread]
    target[nodes:] = [m / s**2 for m, s in zip(mean, spread, strict=True)]
    read = np.isfinite(value) & np.isfinite(variance)
    noise = variance[read]
    for _ in range(2):
        information = design[read].T / noise
        covariance = np.linalg.inv(prior + information @ design[read])
        found = covariance @ (target + information @ value[read])
        if read.sum() < 2 * size:
            break
        rest = value[read] - design[read] @ found
        noise = np.full(
            read.sum(), MEMORY * float(np.mean(np.clip(rest, *(3.0 * CONTRAST_STD * np.array([-1.0, 1.0]))) ** 2))
        )
    return found, np.sqrt(np.diag(covariance))
