"""The five residuals of the wheel-radius analysis, their joint covariance, and what each says of the four wheels.

Order: static, delta12, delta34, delta13, delta24. With small relative radius changes e of fl fr rl rr, residuals =
MIXING @ e:
    static  = e_2 - e_1 - e_4 + e_3     w1/w2 - w3/w4
    delta12 = e_1 - e_2                 r1/r2 - 1            delta34 = e_3 - e_4           r3/r4 - 1
    delta13 = e_3 - e_1                 r3/r1 - 1            delta24 = e_4 - e_2           r4/r2 - 1
The rows span three contrasts: left/right (lateral filter), front/rear (longitudinal filter) and the diagonal one, which
all three methods see through the same wheel speeds. The mean of the four is in none of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.wheel_radius import lateral, longitudinal, static_residual
from estimators.wheel_radius.grip import Grip
from estimators.wheel_radius.lateral import FRONT, REAR, Lateral
from estimators.wheel_radius.longitudinal import Longitudinal
from estimators.wheel_radius.motion import Motion
from estimators.wheel_radius.payload import Payload
from estimators.wheel_radius.static_residual import StaticResidual

NAMES = ("static_residual", "delta12", "delta34", "delta13", "delta24")
MIXING = np.array(
    [[-1.0, 1.0, 1.0, -1.0], [1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0], [-1.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 1.0]]
)
# A rough road adds slip and takes contact from both sides alike: a bias of delta13 and delta24 that grows with the
# scatter of the slip. Of the size of the scatter on simulated classes D to F (a set of seeds kept for tuning).
ROUGH = 0.8


@dataclass(frozen=True)
class Residuals:
    """value (5,), covariance (5, 5) (of what the filters say now; what a reference or a load adds is the business of
    `Calibration.change`), seconds (5,) of driving in which each was read.

    mass: (value, std) of the loaded car [kg]; stops: stands in which its load may have changed, see `payload`.
    """

    value: NDArray[np.float64]
    covariance: NDArray[np.float64]
    seconds: NDArray[np.float64]
    mass: tuple[float, float] = (0.0, math.inf)
    stops: int = 0


class Methods:
    """The three methods side by side, with the road's grip and the car's load. learning: the deltas are constants, for
    a calibration."""

    def __init__(self, car: Car, learning: bool = False) -> None:
        self.static = StaticResidual(drift=0.0 if learning else static_residual.DRIFT)
        self.longitudinal = (
            Longitudinal(0, car.driven_axle, drift=0.0 if learning else longitudinal.DRIFT),
            Longitudinal(1, car.driven_axle, drift=0.0 if learning else longitudinal.DRIFT),
        )
        self.lateral = Lateral(car, drift=0.0 if learning else lateral.DRIFT)
        self.grip = Grip()
        self.payload = Payload(car)

    def step(self, motion: Motion) -> None:
        """Take one cell."""
        self.static.step(motion)
        self.lateral.step(motion)
        for side in self.longitudinal:
            side.step(motion)
        self.grip.step(*self.longitudinal)
        self.payload.step(motion)

    def residuals(self) -> Residuals:
        """Where they stand."""
        left, right = self.longitudinal
        value = np.array(
            [
                self.static.value(),
                self.lateral.delta(FRONT)[0],
                self.lateral.delta(REAR)[0],
                left.delta()[0],
                right.delta()[0],
            ]
        )
        covariance = np.zeros((5, 5))
        covariance[0, 0] = self.static.std() ** 2
        covariance[1:3, 1:3] = self.lateral.delta_covariance()
        covariance[3, 3], covariance[4, 4] = left.delta()[1] ** 2, right.delta()[1] ** 2
        covariance[3:, 3:] += (ROUGH * 0.5 * (left.roughness() + right.roughness())) ** 2
        across = self.lateral.seconds
        seconds = [self.static.seconds, across[FRONT], across[REAR], left.seconds, right.seconds]
        return Residuals(value, covariance, np.array(seconds), self.payload.mass(), self.payload.stops)
