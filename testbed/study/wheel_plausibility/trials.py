"""Errors added to wheel speeds: sizes in km/h, on one wheel or two, constant from a moment on.

A trial watches WATCH seconds. delay: to the moment at which all wheels in error are accused, as the driver would be
told (end of the cell, and LATENCY of the monitor's wait for late samples); right: nobody else is accused then."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.grid import LATENCY
from estimators.wheel_plausibility.kernel import ACCUSED, SAID, STEP, State, constants, follow, new_state
from estimators.wheel_plausibility.published import METHODS, published
from estimators.wheel_plausibility.thresholds import LIMITS
from testbed.study.wheel_plausibility.heard import Heard
from testbed.study.wheel_plausibility.truth import KMH, OUTLIER, SECOND, Truth

WATCH, BEFORE = 3 * SECOND, 2 * SECOND  # cells
SINGLE, DOUBLE = ((6.0,), (13.0,), (20.0,), (50.0,)), ((13.0, 13.0), (13.0, 20.0), (15.0, 13.0))
SIZES = (*SINGLE, *DOUBLE)  # km/h
# as in Tables 6.2 to 6.4: (wheel, km/h) each
CONSTANT = (((3, 4.0),), ((2, 6.0),), ((2, 13.0),), ((2, 20.0),), ((2, 50.0),),
            ((2, 13.0), (3, 20.0)), ((2, 15.0), (3, 13.0)))  # fmt: skip
CONSTANT_START = 10.0  # s


def with_errors(drive: Heard, errors: dict[int, float], first: int, car: Car) -> NDArray[np.float64]:
    """Cells with errors [m/s] on wheels from cell `first` on; a wheel speed is never below 0."""
    value = drive.value.copy()
    for wheel, size in errors.items():
        value[first:, wheel] = np.maximum(value[first:, wheel] + size / car.rolling_radius, 0.0)
    return value


def trials(drive: Heard, of: Truth, car: Car, random: np.random.Generator) -> list[dict[str, Any]]:
    """One of each of SIZES at a moment at which the car moves and no wheel is off; none if there is none."""
    fit = [
        k for k in range(BEFORE, of.end - WATCH)
        if of.worst[k - BEFORE : k + WATCH].max() < 0.5 * OUTLIER and drive.forward[k] > OUTLIER
    ]  # fmt: skip
    found = []
    for sizes in SIZES if fit else ():
        first = int(random.choice(fit))
        wheels = random.permutation(4)[: len(sizes)].tolist()
        fast = drive.forward[first] > 1.5 * max(sizes) * KMH
        sign = -1.0 if fast and random.random() < 0.5 else 1.0
        errors = {w: sign * size * KMH for w, size in zip(wheels, sizes, strict=True)}
        value = with_errors(drive, errors, first, car)
        span = slice(first, first + WATCH)
        state = copied(_state_before(drive, car, first))
        said = np.empty((WATCH, SAID))
        follow(constants(car), state, LIMITS, drive.index[span], np.ascontiguousarray(value[span]), said)
        row = {"sizes": list(sizes), "monitor": _told(said[:, ACCUSED] > 0.5, wheels, LATENCY)}
        kmh = value[max(first - 10 * SECOND, 0) : first + WATCH, :4] * car.rolling_radius / KMH
        for method in METHODS:
            row[method] = _told(published(method, kmh, STEP).accused[-WATCH:], wheels, 0.0)
        found.append(row)
    return found


def copied(state: State) -> State:
    """A state of its own."""
    return State(*(copy.deepcopy(part) for part in state))


def _state_before(drive: Heard, car: Car, first: int) -> State:
    state, said = new_state(), np.empty((first, SAID))
    follow(constants(car), state, LIMITS, drive.index[:first], np.ascontiguousarray(drive.value[:first]), said)
    return state


def _told(accused: NDArray[np.bool_], wheels: list[int], waits: float) -> list[Any]:
    """[delay in s or null, right]."""
    whole = np.flatnonzero(accused[:, wheels].all(axis=1))
    if not len(whole):
        return [None, False]
    others = [i for i in range(4) if i not in wheels]
    return [(int(whole[0]) + 1) * STEP + waits, not accused[whole[0], others].any()]


def constant_errors(drive: Heard, car: Car) -> dict[str, dict[str, Any]]:
    """Tables 6.2 to 6.4: method -> errors -> [seconds to the first accusation or null, wheels accused then]; and
    `diagonal`, seconds to its alarm."""
    first = round(CONSTANT_START / STEP)
    found: dict[str, dict[str, Any]] = {method: {} for method in ("monitor", *METHODS, "diagonal")}
    for errors in CONSTANT:
        name = "+".join(f"{size:g}" for _, size in errors)
        value = with_errors(drive, {wheel: size * KMH for wheel, size in errors}, first, car)
        said = np.empty((len(value), SAID))
        follow(constants(car), new_state(), LIMITS, drive.index, np.ascontiguousarray(value), said)
        found["monitor"][name] = _first(said[first:, ACCUSED] > 0.5, LATENCY)
        kmh = value[:, :4] * car.rolling_radius / KMH
        for method in METHODS:
            verdict = published(method, kmh, STEP)
            found[method][name] = _first(verdict.accused[first:], 0.0)
            if method == "average":
                over = np.flatnonzero(verdict.diagonal[first:])
                found["diagonal"][name] = [(int(over[0]) + 1) * STEP if len(over) else None, []]
    return found


def _first(accused: NDArray[np.bool_], waits: float) -> list[Any]:
    some = np.flatnonzero(accused.any(axis=1))
    if not len(some):
        return [None, []]
    return [(int(some[0]) + 1) * STEP + waits, np.flatnonzero(accused[some[0]]).tolist()]
