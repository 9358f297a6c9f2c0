"""Rolling-radius contrasts of the four wheels over a block of time, from the cells of the wheel-radius analysis.

With l_i = ln(wheel speed / rolling ratio of the path) and small relative radius changes e of fl fr rl rr,

    y = -CONTRASTS l,   CONTRASTS: left-right, front-rear, diagonal, each half a sum
    left-right  = (e1 - e2 + e3 - e4)/2 - (t_f + t_r)/2 (b / v) + s D mu    b: offset of the gyro [rad/s]
    front-rear  = (e1 + e2 - e3 - e4)/2 + s c mu                            c: slip per normalised traction mu, mean of
    diagonal    = (e1 - e2 - e3 + e4)/2 + D' mu                             the driven axle, D half left less right
                                                                            (s = D'/D = -1 front, 1 rear driven)

A block holds the mean of its readable cells; those of unknown traction (braking) count only where it is never known.
`standing` cells give the gyro's offset itself. The mean of the four radii is in none of them. Where one wheel is dead
two sums of contrasts are left that do not hold it: its neighbour axle's left against right (left-right + or -
diagonal) and the other side's front against rear (front-rear + or - diagonal).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.wheel_radius.motion import Motion
from estimators.wheel_radius.wheel_change import CONTRASTS

LEFT_RIGHT, FRONT_REAR, DIAGONAL = range(3)
ENOUGH = 0.5  # share of a block's cells that must be readable


@dataclass(frozen=True)
class RadiusBlock:
    """value: of what was read [-], shape (k,); mixing: what contrasts each holds, shape (k, 3): all three, two sums of
    them where a wheel is dead, or none (k = 0); yaw_gain: of b in left-right [s/rad]; traction: s mu [-], 0 where
    unknown; curvature: of the path [1/m]; speed: [m/s], NaN if nothing was read; standstill: mean of the gyro while
    the car stood [rad/s], NaN if it did not."""

    value: NDArray[np.float64]
    mixing: NDArray[np.float64]
    yaw_gain: float
    traction: float
    curvature: float
    speed: float
    standstill: float

    @property
    def contrasts(self) -> NDArray[np.float64]:
        """Shape (3,), NaN where a contrast was not read by itself."""
        alone = np.abs(self.mixing).sum(axis=1) == 1.0
        found = np.full(3, np.nan)
        found[np.argmax(self.mixing[alone], axis=1)] = self.value[alone]
        return found


def mixing_without(wheel: int) -> NDArray[np.float64]:
    """Of the two sums of contrasts that do not hold a wheel, shape (2, 3)."""
    side, axle, _ = np.sign(CONTRASTS[:, wheel])
    return np.array([[1.0, 0.0, -axle], [0.0, 1.0, -side]])


class Contrasts:
    """Collects the cells of one block. cells: of a whole block."""

    def __init__(self, car: Car, cells: int) -> None:
        self._half_tracks = 0.5 * (car.front_track + car.rear_track)
        self._sign = -1.0 if car.driven_axle == "front" else 1.0
        self._cells = cells
        self._rows: list[tuple[float, ...]] = []
        self._still: list[float] = []
        self._traction_seen = False

    def add(self, motion: Motion) -> None:
        """The next cell."""
        if motion.standing and not np.isnan(motion.gyro) and not motion.stand_in:
            self._still.append(motion.gyro)
        known = not np.isnan(motion.traction)
        self._traction_seen |= known
        if not motion.readable or (motion.omega <= 0.0).any() or (self._traction_seen and not known):
            return
        if np.isfinite(motion.omega).sum() < 3:
            return
        curvature = motion.gyro / motion.speed if not np.isnan(motion.gyro) else 0.0
        gain = self._half_tracks * motion.gyro_gain / motion.speed
        self._rows.append((*np.log(motion.omega / motion.roll), gain, motion.traction, curvature, motion.speed))

    def close(self) -> RadiusBlock:
        """The block's means; the next block begins empty."""
        rows, still = np.array(self._rows).reshape(-1, 8), self._still
        self._rows, self._still = [], []
        standstill = float(np.mean(still)) if len(still) > 0.5 * self._cells else float("nan")
        seen = np.isfinite(rows[:, :4]).sum(axis=0) >= ENOUGH * self._cells
        rows = rows[np.isfinite(rows[:, :4][:, seen]).all(axis=1)]
        if seen.sum() < 3 or len(rows) < ENOUGH * self._cells:
            return RadiusBlock(np.empty(0), np.empty((0, 3)), 0.0, 0.0, 0.0, float("nan"), standstill)
        mixing = np.eye(3) if seen.all() else mixing_without(int(np.argmin(seen)))
        value = -(mixing @ CONTRASTS)[:, seen] @ rows[:, :4][:, seen].mean(axis=0)
        traction = self._sign * float(rows[:, 5].mean())
        if np.isnan(traction):
            kept = mixing[:, FRONT_REAR] == 0.0
            traction, value, mixing = 0.0, value[kept], mixing[kept]
        yaw_gain, curvature, speed = -float(rows[:, 4].mean()), float(rows[:, 6].mean()), float(rows[:, 7].mean())
        return RadiusBlock(value, mixing, yaw_gain, traction, curvature, speed, standstill)
