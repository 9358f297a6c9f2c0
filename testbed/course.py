"""What an estimate is of: the true course of a drive at one value a stretch, and the truth that belongs to a quantity.

Quantities by the last part of their name, as the estimators name them:

    WHEEL/pressure          gauge pressure [Pa]
    WHEEL/stiffness         vertical tyre stiffness [N/m]
    WHEEL/relative_pressure_change   against nominal, less the mean of the four [Pa]: what a method that only compares
                                     wheels with one another can know
    WHEEL/relative_radius_change     ln of the rolling radius over its reference, less the mean of the four [-]
    delta12 delta34 delta13 delta24   r1/r2 - 1, r3/r4 - 1, r3/r1 - 1, r4/r2 - 1 [-], wheels 1 to 4 = fl fr rl rr

The reference of a radius is its mean over the calibration drive, or nominal without one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import WHEELS
from testbed.simulation import Stretch

PAIRS = {"delta12": (0, 1), "delta34": (2, 3), "delta13": (2, 0), "delta24": (3, 1)}
COLUMNS = ("pressure", "rolling_radius", "stiffness")


@dataclass(frozen=True)
class Course:
    """time: ends of the stretches [s], shape (n,); pressure [Pa], rolling_radius [m], stiffness [N/m]: means over each
    stretch, shape (n, 4)."""

    time: NDArray[np.float64]
    pressure: NDArray[np.float64]
    rolling_radius: NDArray[np.float64]
    stiffness: NDArray[np.float64]


class CourseTaker:
    """Takes the course of a drive, stretch by stretch."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, list[NDArray[np.float64]]]] = []

    def add(self, stretch: Stretch) -> None:
        """The next stretch."""
        time = stretch["time"]
        self._rows.append((float(time[-1]), [stretch[name].mean(axis=0) for name in COLUMNS]))

    def course(self) -> Course:
        """All so far."""
        columns = zip(*(means for _, means in self._rows), strict=True)
        return Course(np.array([time for time, _ in self._rows]), *(np.array(column) for column in columns))


def truth_of(
    quantity: str, course: Course, nominal_pressure: float, reference: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """The true course of a quantity, shape (n,), None where there is none. reference: of the radii [m], shape (4,)."""
    if quantity in PAIRS:
        i, j = PAIRS[quantity]
        return course.rolling_radius[:, i] / course.rolling_radius[:, j] - 1.0
    wheel, _, name = quantity.partition("/")
    if wheel not in WHEELS:
        return None
    i = WHEELS.index(wheel)
    if name == "pressure":
        return course.pressure[:, i]
    if name == "stiffness":
        return course.stiffness[:, i]
    if name == "relative_pressure_change":
        return _less_mean(course.pressure - nominal_pressure)[:, i]
    if name == "relative_radius_change":
        return _less_mean(np.log(course.rolling_radius / reference))[:, i]
    return None


def _less_mean(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values - values.mean(axis=1, keepdims=True)


def low_wheels(pressure: Iterable[float], nominal_pressure: float, low: float) -> tuple[str, ...]:
    """Wheels that have lost at least the share `low` of nominal pressure [Pa]."""
    return tuple(w for w, p in zip(WHEELS, pressure, strict=True) if p <= (1.0 - low) * nominal_pressure)
