"""Calibration by speed: what each residual is on sound tyres, at NODES of speed, and how surely; as a JSON document.

Of a frequency the document holds its level at the nodes and the information that the data gave: a block at a speed
between two nodes tells the sum of both, so the information is tridiagonal, `node` and `next`. With what is known of
every car (`mode_nodes`) that gives the covariance of all that was not learnt. Of a radius contrast it holds level and
std. Beside them the slip per traction and what the path's curvature adds (`learning`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS
from estimators.itpms.mode_nodes import MODE_NODES, NODES, remaining, weights

CONTRASTS = ("left_right", "front_rear", "diagonal")
FREQUENCIES = tuple(f"{mode.name}/{wheel}" for mode in MODE_NODES for wheel in WHEELS)
NAMES = (*FREQUENCIES, *CONTRASTS)
SIZE = len(NAMES)
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Calibration:
    """level: of NAMES at NODES, shape (SIZE, nodes); information: of each mode's ln f, shape (4, K, K) each; std: of
    the contrasts, shape (3, nodes); slip, bend (left-right, diagonal) and their std."""

    level: Array
    information: tuple[Array, ...]
    std: Array
    slip: tuple[float, float]
    bend: Array
    bend_std: Array

    def expected(self, speed: float) -> Array:
        """Of NAMES at a speed [m/s], shape (SIZE,)."""
        return self.level @ weights(speed)

    def unlearnt(self, mode: int) -> Array:
        """Covariance of a mode's ln f at its nodes, wheel by wheel, shape (4 K, 4 K)."""
        return remaining(MODE_NODES[mode].spread(), self.information[mode])

    def document(self) -> dict[str, Any]:
        """JSON values."""
        table: dict[str, Any] = {}
        for i, name in enumerate(FREQUENCIES):
            told = self.information[i // 4][i % 4]
            told = {"node": np.diag(told).tolist(), "next": np.diag(told, 1).tolist()}
            table[name] = {"level": self.level[i].tolist(), **told}
        for i, name in enumerate(CONTRASTS):
            table[name] = {"level": self.level[len(FREQUENCIES) + i].tolist(), "std": self.std[i].tolist()}
        bends = {"value": self.bend.tolist(), "std": self.bend_std.tolist()}
        return {"speeds": NODES.tolist(), **table, "slip": list(self.slip), "bend": bends}

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> Calibration:
        """The inverse of `document`. ValueError names what is wrong."""
        if list(document.get("speeds", ())) != NODES.tolist():
            raise ValueError(f"calibration has speeds {document.get('speeds')!r}, valid: {NODES.tolist()}")
        nodes, level, told = len(NODES), [], []
        for i, name in enumerate(FREQUENCIES):
            count = MODE_NODES[i // 4].count
            sizes = {"level": nodes, "node": count, "next": count - 1}
            own, node, following = _numbers(document, name, sizes)
            table = np.diag(node) + np.diag(following, 1) + np.diag(following, -1)
            if np.linalg.eigvalsh(table).min() < -1e-6 * max(float(table.max()), 1.0):
                raise ValueError(f"calibration of {name} has an information that is below 0 in some direction")
            level.append(own)
            told.append(table)
        rows = [_numbers(document, name, {"level": nodes, "std": nodes}) for name in CONTRASTS]
        bend = _numbers(document, "bend", {"value": 2, "std": 2})
        slip = document.get("slip")
        if slip is None or not _finite(slip, 2):
            raise ValueError(f"calibration has slip {slip!r}, valid: value and std")
        if min(min(std) for _, std in (*rows, bend)) < 0.0:
            raise ValueError("calibration has a std below 0")
        return cls(
            np.array([*level, *(row[0] for row in rows)]), (np.array(told[:4]), np.array(told[4:])),
            np.array([row[1] for row in rows]), (slip[0], slip[1]), np.array(bend[0]), np.array(bend[1]),
        )  # fmt: skip


def _finite(values: Any, size: int) -> bool:
    number = isinstance(values, Sequence) and not isinstance(values, str) and len(values) == size
    return number and all(isinstance(v, int | float) and math.isfinite(v) for v in values)


def _numbers(document: Mapping[str, Any], name: str, sizes: Mapping[str, int]) -> list[list[float]]:
    entry = document.get(name)
    found = [entry.get(key) if isinstance(entry, Mapping) else None for key in sizes]
    if not all(_finite(values, size) for values, size in zip(found, sizes.values(), strict=True)):
        wanted = ", ".join(f"{size} finite {key}" for key, size in sizes.items())
        raise ValueError(f"calibration of {name} is {entry!r}, valid: {wanted}")
    return found  # type: ignore[return-value]
