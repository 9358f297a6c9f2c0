"""How much the load may have changed since the calibration, and what that does to front against rear radii.

A rolling radius falls with the wheel's load (`RADIUS_LOAD`), so a payload behind looks like two low rear tyres. While
the car drives its load is constant; it can change while the car stands for `LOADING_TIME`, or is parked. What can be
told: the mass, from the force that it takes (state m [kg], b [N]; f_x specific force, so a grade does not matter)
    force - drag - spin-up = m f_x + b,     b: rolling resistance and the accelerometer's bias
What cannot: where the payload lies. With share s of it on the rear axle, believed REAR_SHARE +- REAR_SHARE_STD, mass
change M moves ln(r_rear / r_front) by RADIUS_LOAD g M (2 s - 1) / 2 on both sides alike. That mean is taken off, the
rest is part of delta13's and delta24's covariance, fully correlated. What lies on one side, of moment SIDE_MOMENT, and
at any time a side wind's moment move delta12 and delta34 alike, by RADIUS_LOAD g / track each kg m. The diagonal
comparison keeps its sharpness. Without torque or acceleration the mass stays at its prior, and front against rear is
worth little after every stop.
"""

from __future__ import annotations

import numpy as np

from estimators.car import GRAVITY, Car
from estimators.wheel_radius.bounded_filter import Anchor, BoundedFilter
from estimators.wheel_radius.curve import RADIUS_LOAD
from estimators.wheel_radius.motion import Motion
from estimators.wheel_radius.noise import NoiseLevel

REAR_SHARE, REAR_SHARE_STD = 0.72, 0.25  # between the front seats and behind the rear axle
USUAL, SPREAD = 150.0, 250.0  # [kg] of people and luggage over the car's own mass, and its std
SIDE_MOMENT = 20.0  # [kg m], std of load times its place across the car: one passenger more or less is 28.
# The sound drives' own spread is 45; with that the measured Mustang's low tyre is no longer called (3.16 of 3.57)
WIND_MOMENT = 15.0  # [kg m] whose weight rolls the car as a side wind does
TRACK = 1.6  # [m]
LOADING_TIME = 10.0  # [s] of standing in which somebody may get in
CHANGE = 120.0  # [kg], std of what a stop changes
RESISTANCE, RESISTANCE_STD = 230.0, 200.0  # [N] of b
RESISTANCE_DRIFT = 10.0  # [N/sqrt(s)]: gusts, which are as large over some ten seconds
PULLING = 0.05  # [m/s^2]; below, brakes may help that no signal tells of
MODEL_ERROR = 0.04  # of the mass: pitch that the accelerometer feels, resistance that changes with the speed
LOAD_CHANGE = 350.0  # [kg], std of a change of the load before anything is measured: 600 kg are not two of it
EXCITATION = 0.2  # [m/s^2] by which the specific force must change to tell m from b
FORCE_ERROR = 300.0  # [N] of a block before it is measured
BLOCK, CELL, MIN_IN_BLOCK = 10, 0.1, 8


class Payload:
    """Mass of the loaded car and how often its load may have changed."""

    def __init__(self, car: Car) -> None:
        self._filter = BoundedFilter([car.mass + USUAL, RESISTANCE], [SPREAD, RESISTANCE_STD], [0.0, RESISTANCE_DRIFT])
        self._noise = NoiseLevel(FORCE_ERROR**2)
        self._anchor = Anchor()
        self._block: list[tuple[float, float]] = []
        self._number: int | None = None
        self._stood = 0.0
        self.stops = 0
        """Stands long enough for the load to change."""

    def step(self, motion: Motion) -> None:
        """Take one cell."""
        number = motion.index // BLOCK
        if number != self._number:
            self._finish(1 if self._number is None else number - self._number)
            self._number = number
        if motion.standing:
            before, self._stood = self._stood, self._stood + CELL
            if before < LOADING_TIME <= self._stood:
                self.stops += 1
                self._filter.predict(0.0, noise=np.diag([CHANGE**2, 0.0]))
            return
        self._stood = 0.0
        if motion.readable and motion.specific > PULLING and not np.isnan(motion.force):
            self._block.append((motion.force, motion.specific))

    def _finish(self, elapsed: int) -> None:
        block, self._block = self._block, []
        self._filter.predict(elapsed * BLOCK * CELL)
        if elapsed > 1 or len(block) < MIN_IN_BLOCK:
            self._noise.interrupt()
        if len(block) < MIN_IN_BLOCK:
            return
        force, specific = np.mean(block, axis=0).tolist()
        excited = np.array([self._anchor.follow(specific, EXCITATION), 1.0])
        explained = self._filter.spread(excited)
        self._noise.add(self._filter.update(force, np.array([specific, 1.0]), self._noise.variance, excited), explained)

    def mass(self) -> tuple[float, float]:
        """(mass, std) of the loaded car [kg]."""
        mass = float(self._filter.state[0])
        return mass, float(np.hypot(self._filter.std[0], MODEL_ERROR * mass))


def side_shift(reloaded: bool) -> float:
    """Std of what load and wind from the side do to delta12 and delta34 alike since they were learnt [-]."""
    moment = float(np.hypot(SIDE_MOMENT if reloaded else 0.0, WIND_MOMENT))
    return abs(RADIUS_LOAD) * GRAVITY * moment / TRACK


def radius_shift(mass_change: float, std: float) -> tuple[float, float]:
    """(mean, std) [-] of the change of ln(r_rear / r_front) that a change of the mass [kg], measured to `std`,
    brings."""
    known = LOAD_CHANGE**2 / (LOAD_CHANGE**2 + std**2)  # what is badly measured is small rather than large
    mass_change, std = known * mass_change, known**0.5 * std
    each = 0.5 * RADIUS_LOAD * GRAVITY
    lever, doubt = 2.0 * REAR_SHARE - 1.0, 2.0 * REAR_SHARE_STD
    return each * lever * mass_change, abs(each) * float(np.hypot(lever * std, doubt * np.hypot(mass_change, std)))
