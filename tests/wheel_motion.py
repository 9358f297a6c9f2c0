"""Closed-form angular motion of a wheel and the exact edge times of its ring: truth for the tests of wheel speed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

TEETH = 48
PITCH = 2.0 * np.pi / TEETH


def ring(seed: int, error: float = 0.003) -> NDArray[np.float64]:
    """Places of the teeth against an even ring [pitches], zero mean; pitches off by `error` r.m.s."""
    deviation = np.random.default_rng(seed).standard_normal(TEETH)
    deviation -= deviation.mean()
    place = np.cumsum(error * deviation / np.sqrt(np.mean(deviation**2)))
    return place - place.mean()


def edges(
    angle: Callable[[NDArray], NDArray], speed: Callable[[NDArray], NDArray], duration: float, places: NDArray,
    timer: float = 0.0,
) -> NDArray[np.float64]:  # fmt: skip
    """Times at which a rising angle(t) [rad] passes each edge, by Newton from a fine table; speed(t): its derivative
    [rad/s]. timer: stamps are its next whole tick."""
    coarse = np.linspace(0.0, duration, round(2000 * duration) + 1)
    table = angle(coarse)
    first, last = np.ceil(table[0] / PITCH) + 1, np.floor(table[-1] / PITCH) - 1
    number = np.arange(first, last + 1)
    wanted = PITCH * (number + places[number.astype(int) % TEETH])
    time = np.interp(wanted, table, coarse)
    for _ in range(4):
        time -= (angle(time) - wanted) / np.maximum(speed(time), 1e-3)
    return np.ceil(time / timer) * timer if timer else time
