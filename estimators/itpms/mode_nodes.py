"""The torsional frequencies of the four wheels over speed: nominal, and how a car's own may lie about that.

ln f of each mode and wheel is piecewise linear over some of the NODES of speed. What a block's spectrum is taken for
moves with speed by more than the frequency does (at 13 to 16 m/s the contact patch's gap cuts the antiphase peak's
upper side), much the same on every car: `shape`. About nominal a vector a over (wheel, node) of one mode is normal with

    cov(a) = 1 1' x (LEVEL_c^2 + STEP_c^2 B) + I x (LEVEL_e^2 + STEP_e^2 B)      x: Kronecker, wheels by nodes

c common to the four wheels, e each wheel's own; B is a random walk over the nodes in both directions from the node
`anchor`. So a speed never driven has an error that is to a good part the same in all wheels: it hides an equal loss,
and leaves wheels beside each other sharper. `shape` and STEPs: from tuning cars, see `thresholds`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NODES = np.array([5.0, 10.0, 12.5, 15.0, 20.0, 25.0, 30.0, 36.0, 43.0])  # m/s
Array = NDArray[np.float64]


@dataclass(frozen=True)
class ModeNodes:
    """first, last: of NODES at which a frequency is kept; anchor: among these; nominal: front and rear [Hz]; shape: of
    ln f, by node; level, step: std of ln f, (common, each); loose: by how much wider each step between nodes is."""

    name: str
    first: int
    last: int
    anchor: int
    nominal: tuple[float, float]
    shape: tuple[float, ...]
    level: tuple[float, float]
    step: tuple[float, float]
    loose: tuple[float, ...]

    @property
    def count(self) -> int:
        """Nodes, K."""
        return self.last - self.first

    def expected(self) -> Array:
        """Nominal ln f, shape (4, K)."""
        front, rear = (math.log(f) + np.array(self.shape) for f in self.nominal)
        return np.array([front, front, rear, rear])

    def spread(self) -> Array:
        """cov(a), shape (4 K, 4 K)."""
        return self.covariance(self.level, self.step)

    def covariance(self, level: tuple[float, float], step: tuple[float, float]) -> Array:
        """The same with other stds, shape (4 K, 4 K)."""
        far = np.concatenate([[0.0], np.cumsum(np.square(self.loose))])
        far = far - far[self.anchor]
        same = np.sign(far)[:, None] * np.sign(far) > 0.0
        walk = np.where(same, np.minimum(np.abs(far)[:, None], np.abs(far)), 0.0)
        common, each = (a**2 + s**2 * walk for a, s in zip(level, step, strict=True))
        return np.kron(np.ones((4, 4)), common) + np.kron(np.eye(4), each)

    def weights(self, speed: float) -> Array:
        """Of the nodes at a speed [m/s], shape (K,)."""
        return weights(speed)[self.first : self.last]

    def everywhere(self, values: Array) -> Array:
        """(4, K) -> (4, nodes): ends hold beyond."""
        return np.take(values, np.clip(np.arange(len(NODES)) - self.first, 0, self.count - 1), axis=1)


ANTIPHASE = ModeNodes(
    "antiphase", 1, 9, 3, (86.15, 88.7), (-0.006, -0.007, -0.005, 0.0, 0.0025, 0.003, 0.004, 0.004), (0.06, 0.03),
    (2e-3, 2e-3), (6.0, 3.0, 1.5, 1.0, 1.0, 1.0, 1.0),
)  # fmt: skip
IN_PHASE = ModeNodes(
    "in_phase", 0, 5, 3, (43.0, 46.5), (0.0, 0.0, 0.0, 0.0, 0.0), (0.08, 0.06), (3e-2, 2e-2), (1.0, 1.0, 1.0, 1.0)
)
MODE_NODES = (ANTIPHASE, IN_PHASE)


def weights(speed: float) -> Array:
    """Of NODES at a speed [m/s], adding up to 1; the ends hold beyond."""
    return np.array([np.interp(speed, NODES, unit) for unit in np.eye(len(NODES))])


def remaining(spread: Array, information: Array) -> Array:
    """Covariance of nodes of which data with `information`, (4, K, K), have been seen; spread: before, (4 K, 4 K)."""
    count = information.shape[1]
    told = np.zeros_like(spread)
    for w in range(4):
        told[w * count : (w + 1) * count, w * count : (w + 1) * count] = information[w]
    # (S^-1 + J)^-1 = S - S J (I + S J)^-1 S, without inverting a spread that may be singular
    return spread - spread @ told @ np.linalg.solve(np.eye(len(spread)) + spread @ told, spread)
