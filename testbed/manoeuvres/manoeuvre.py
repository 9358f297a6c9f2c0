"""A manoeuvre: the speed and the path that the driver is to follow.

One file adds one manoeuvre: a subclass of `Manoeuvre` in this folder is found by itself. A path begins at the origin
along x, where the road begins; the car comes to it on a straight and level run-in, already at the first speed of the
plan.
"""

from __future__ import annotations

import importlib
import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from testbed.driver import PLAN_STEP, SPEED, Plan

PATH_STEP = 0.5  # m
COMFORT = 1.5  # m/s^2, ordinary acceleration and braking
PULL, PULL_END = (
    1.8,
    57.0,
)  # m/s^2, m/s: acceleration falls from PULL to nothing at PULL_END, as the reserve
LATERAL_COMFORT = 3.0  # m/s^2
FASTEST = 200.0 / 3.6  # m/s, of a car that wanders about the given speed


class Manoeuvre(ABC):
    """name: as typed after --manoeuvre; about: one line for the help."""

    name: str
    about: str

    @abstractmethod
    def plan(self, speed: float, duration: float) -> Plan:
        """The plan for a speed [m/s] and a duration [s]. ValueError where they do not fit the manoeuvre."""


def speed_plan(time: ArrayLike, speed: ArrayLike, duration: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Speed [m/s] and its derivative [m/s^2] at PLAN_STEP from corner points (time [s], speed [m/s]), corners rounded
    over 1 s so that the jerk is bounded."""
    at = np.arange(0.0, duration + 1.0, PLAN_STEP)
    wanted = np.interp(at, np.asarray(time, float), np.asarray(speed, float))
    width = round(1.0 / PLAN_STEP)
    padded = np.concatenate([np.full(width // 2, wanted[0]), wanted, np.full(width - width // 2 - 1, wanted[-1])])
    smooth = np.convolve(padded, np.full(width, 1.0 / width), mode="valid")
    smooth[smooth < 1e-6] = 0.0
    return smooth, np.gradient(smooth, PLAN_STEP)


def pull_away(first: float, last: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corner points, time [s] and speed [m/s], of an ordinary acceleration from one speed [m/s] to a higher one."""
    level = np.linspace(first, last, 41)
    pull = np.minimum(COMFORT, PULL * (1.0 - level / PULL_END))
    return np.concatenate([[0.0], np.cumsum(np.diff(level) * 0.5 * (1.0 / pull[1:] + 1.0 / pull[:-1]))]), level


def wandering_speed(
    speed: float, duration: float, shares: Sequence[float], hold: float, change: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """As `speed_plan`: one share after the other of a speed [m/s], FASTEST at the most, each held for `hold` [s]; a
    change takes `change` [s], or longer where the engine's reserve is small."""
    time, level, now, i = [0.0], [speed], 0.0, 0
    while now < duration:
        coming = min(speed * shares[(i + 1) % len(shares)], FASTEST)
        lasts = change if coming <= level[-1] else max(change, pull_away(level[-1], coming)[0][-1])
        time += [now + hold, now + hold + lasts]
        level += [level[-1], coming]
        now, i = now + hold + lasts, i + 1
    return speed_plan(time, level, duration)


def curvature_path(curvature: ArrayLike, step: float = PATH_STEP) -> NDArray[np.float64]:
    """Path x, y, heading, curvature from the curvature [1/m] at every `step` [m], shape (n,) -> (n, 4)."""
    bend = np.asarray(curvature, float)
    middle = 0.5 * (bend[1:] + bend[:-1])
    heading = np.concatenate([[0.0], np.cumsum(middle) * step])
    half = 0.5 * (heading[1:] + heading[:-1])
    x = np.concatenate([[0.0], np.cumsum(np.cos(half)) * step])
    y = np.concatenate([[0.0], np.cumsum(np.sin(half)) * step])
    return np.stack([x, y, heading, bend], axis=1)


def offset_path(offset: ArrayLike) -> NDArray[np.float64]:
    """Path from a smooth sideways offset y [m] at every PATH_STEP along x, shape (n,) -> (m, 4), at PATH_STEP along
    the path itself."""
    y = np.asarray(offset, float)
    x = np.arange(len(y)) * PATH_STEP
    slope = np.gradient(y, PATH_STEP)
    bend = np.gradient(slope, PATH_STEP) / (1.0 + slope**2) ** 1.5
    station = np.concatenate([[0.0], np.cumsum(np.hypot(PATH_STEP, np.diff(y)))])
    at = np.arange(0.0, station[-1] + 1e-9, PATH_STEP)
    along = np.interp(at, station, x)
    cell = np.minimum((along / PATH_STEP).astype(int), len(y) - 2)
    part = along / PATH_STEP - cell
    chord = y[cell + 1] - y[cell]
    bow = (
        part
        * (1.0 - part)
        * (  # cubic Hermite: the chord plus what the slopes at its ends add
            (1.0 - part) * (slope[cell] * PATH_STEP - chord) - part * (slope[cell + 1] * PATH_STEP - chord)
        )
    )
    return np.stack(
        [along, y[cell] + part * chord + bow, np.arctan(np.interp(along, x, slope)), np.interp(along, x, bend)], axis=1
    )


def straight_path() -> NDArray[np.float64]:
    """The x axis."""
    return offset_path(np.zeros(3))


def driven(speed: NDArray[np.float64], acceleration: NDArray[np.float64], path: NDArray[np.float64]) -> Plan:
    """A plan under speed control throughout."""
    return Plan(speed, acceleration, np.full(len(speed), SPEED, np.int64), path, PATH_STEP)


def smooth_step(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """0 to 1 over x in 0..1 with continuous curvature (fifth-order polynomial)."""
    z = np.clip(x, 0.0, 1.0)
    return z**3 * (10.0 - 15.0 * z + 6.0 * z**2)


def manoeuvres() -> dict[str, Manoeuvre]:
    """Every manoeuvre found in this folder, by name."""
    package = importlib.import_module("testbed.manoeuvres")
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"testbed.manoeuvres.{module.name}")
    return {kind.name: kind() for kind in sorted(_derived(Manoeuvre.__subclasses__()), key=lambda k: k.name)}


def _derived(kinds: Sequence[type[Manoeuvre]]) -> list[type[Manoeuvre]]:
    """They and all that derive from them, however far."""
    return [found for kind in kinds for found in (kind, *_derived(kind.__subclasses__()))]


def find_manoeuvre(name: str) -> Manoeuvre:
    """The manoeuvre of that name. ValueError lists the valid ones."""
    found = manoeuvres()
    if name not in found:
        raise ValueError(f"unknown manoeuvre {name!r}; valid: {', '.join(found)}")
    return found[name]
