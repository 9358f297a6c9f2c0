"""Vertical tyre stiffness from inflation pressure, and back, each with its standard deviation.

Brancati & Tufano, Machines 2022, 10, 1221, eq. 3 and 4, with the terms of speed and load that the Magic Formula 6.1
load law has beside it (Pacejka, Tire and Vehicle Dynamics, 3rd ed., ch. 4.3): stiffness at the mean load and speed,

    k_t = k_t0 (1 + p_Fz1 (p - p0) / p0) (1 + e_v V) (F / F0)^e_F

F0: mean static wheel load of the empty car. Gauge pressures [Pa]. Without the last two factors 40 km/h more reads as 9
kPa, and 24 % more load as as much. Left out: below p0/2 the law of a real tyre bends down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.car import GRAVITY, Car

LOWEST = 0.05  # of p0: a pressure below it is not told from the stiffness


@dataclass(frozen=True)
class TyreLaw:
    """k_t0 [N/m] at rest, p0 [Pa] and F0 [N]; p_Fz1 [-]; e_v [s/m]; e_F [-]."""

    stiffness: float
    pressure: float
    load: float
    per_pressure: float
    per_speed: float = 0.0
    per_load: float = 0.0

    @classmethod
    def of(cls, car: Car) -> TyreLaw:
        """What the car's maker says of its tyres."""
        return cls(
            stiffness=car.tyre_stiffness,
            pressure=car.pressure,
            load=0.25 * car.mass * GRAVITY,
            per_pressure=car.tyre_stiffness_per_pressure,
            per_speed=car.tyre_stiffness_per_speed,
            per_load=car.tyre_stiffness_per_load,
        )

    def circumstance(self, speed: ArrayLike = 0.0, load: float | None = None) -> NDArray[np.float64]:
        """Factor of speed [m/s] and load [N] on the stiffness [-]."""
        share = 1.0 if load is None else (load / self.load) ** self.per_load
        return (1.0 + self.per_speed * np.asarray(speed, float)) * share

    def stiffness_at(self, pressure: ArrayLike, speed: ArrayLike = 0.0, load: float | None = None) -> NDArray:
        """k_t [N/m]."""
        dpi = (np.asarray(pressure, float) - self.pressure) / self.pressure
        return self.stiffness * (1.0 + self.per_pressure * dpi) * self.circumstance(speed, load)

    def pressure_of(self, stiffness: ArrayLike, speed: ArrayLike = 0.0, load: float | None = None) -> NDArray:
        """p [Pa] that gives k_t [N/m], at least `LOWEST` of nominal."""
        factor = np.asarray(stiffness, float) / (self.stiffness * self.circumstance(speed, load))
        return self.pressure * np.maximum(1.0 + (factor - 1.0) / self.per_pressure, LOWEST)

    def pressure_std(self, stiffness_std: ArrayLike, speed: ArrayLike = 0.0, load: float | None = None) -> NDArray:
        """std of p [Pa] from the std of k_t [N/m]; the law itself taken for exact."""
        slope = self.stiffness * self.circumstance(speed, load) * self.per_pressure / self.pressure
        return np.asarray(stiffness_std, float) / slope
