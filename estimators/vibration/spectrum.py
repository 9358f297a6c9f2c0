"""Periodograms of a wheel's speed and what is summed of them.

A segment of 1 s, overlapping the next by half, less its own straight line, in a Hann window; its one-sided power
spectral density at whole Hz, corrected for the linear angle between teeth. Lines that cannot be trusted count nothing:
above USABLE of the tooth rate, and within ORDER_WIDTH of a wheel order that carries something of the ring or tyre.
Half-overlapped Hann segments hold EFFICIENCY of an independent periodogram each (Welch 1967: their mean has 0.53 times
the variance of that of half as many).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_speed.orders import order_lines
from estimators.wheel_speed.resampling import RATE, USABLE, droop

SEGMENT = round(RATE)  # samples: 1 s
HOP = SEGMENT // 2
EFFICIENCY = 0.475
LINES = np.arange(171.0)  # Hz
MOST_EVEN = 2.0
STEADY = 0.15  # largest relative change of speed within a segment
WINDOW = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(SEGMENT) / SEGMENT)
_NORM = 2.0 / (RATE * np.sum(WINDOW**2))
_PLACE = np.arange(SEGMENT) - 0.5 * (SEGMENT - 1)
_SQUARE = float(_PLACE @ _PLACE)


@dataclass(frozen=True)
class Segment:
    """omega: mean speed [rad/s]; tooth_rate [Hz]; power: PSD at LINES [(rad/s)^2/Hz]; white: what samples of white
    noise of 1 (rad/s)^2/Hz would have there; used: which lines count."""

    omega: float
    tooth_rate: float
    power: NDArray[np.float64]
    white: NDArray[np.float64]
    used: NDArray[np.bool_]


def segment(speed: NDArray[np.float64], knots: float, orders: int) -> Segment | None:
    """Of SEGMENT samples of wheel speed [rad/s]; None if they are not all known or the speed is not steady.

    knots: known angles per turn (teeth), or per second if negative (bus updates). orders: wheel orders to leave out.
    """
    mean = float(np.mean(speed))
    if not math.isfinite(mean) or mean <= 0.0:
        return None
    slope = float(speed @ _PLACE) / _SQUARE
    if abs(slope) * SEGMENT > STEADY * mean:
        return None
    power = _NORM * np.abs(np.fft.rfft((speed - mean - slope * _PLACE) * WINDOW)[: len(LINES)]) ** 2
    tooth_rate = knots * mean / (2.0 * math.pi) if knots > 0.0 else -knots
    used = USABLE * tooth_rate > LINES
    if orders:
        used &= ~order_lines(LINES, mean, abs(slope) * SEGMENT, orders)
    white = np.where(used, droop(LINES, tooth_rate), 1.0) ** -2.0
    return Segment(mean, tooth_rate, power * white, white, used)


class Spectrum:
    """Sums over segments, which may fade. count: of segments by line; white: sum of what white noise of the samples is
    at each line; timing: of what white timing noise of 1 s^2 per edge puts into f^2 (rad/s)^2/Hz.

    What faded evenly over a long time holds up to MOST_EVEN times as many independent segments as its weights come to,
    which is (sum of weights)^2 / sum of squares; that they may not grow further lets a spectrum that only fades lose
    its worth.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self.power, self.white, self.count = np.zeros((3, len(LINES)))
        self.segments, self.squares, self.omega, self.timing = 0.0, 0.0, 0.0, 0.0

    def add(self, one: Segment) -> None:
        """Count a segment in."""
        self.power += np.where(one.used, one.power, 0.0)
        self.white += np.where(one.used, one.white, 0.0)
        self.count += one.used
        self.segments += 1.0
        self.squares += 1.0
        self.omega += one.omega
        self.timing += timing_noise(one)

    @property
    def worth(self) -> float:
        """Independent segments per weight."""
        return min(self.segments / self.squares, MOST_EVEN) if self.squares > 0.0 else 1.0

    def fade(self, factor: float) -> None:
        """Let what was counted weigh less."""
        self.power *= factor
        self.white *= factor
        self.count *= factor
        self.segments *= factor
        self.squares *= factor**2
        self.omega *= factor
        self.timing *= factor


def timing_noise(one: Segment) -> float:
    """PSD [(rad/s)^2/Hz] per f^2 [Hz^2] from edge times with a variance of 1 s^2: (2 pi omega)^2 2 / tooth rate."""
    return 2.0 * (2.0 * math.pi * one.omega) ** 2 / one.tooth_rate
