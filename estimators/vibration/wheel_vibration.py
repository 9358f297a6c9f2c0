"""Vibration of one wheel, second by second: a fading memory of its spectrum, and blocks that share nothing.

The memory of each mode keeps all that was heard until it is worth FULL segments, then fades with MEMORY seconds, as it
does in a second in which nothing is heard, and with changes of speed beyond the mode's span; what it says after a
second is the running estimate, and as nothing is added while the wheel stands, or the road is too smooth for the
timer, its std grows to the prior's. A block collects BLOCK_SEGMENTS segments, is closed early when the speed leaves
the span or it has become old, and is then forgotten: blocks' estimates are independent (but for the half second that
neighbours share) and may be averaged or used as likelihoods by their information.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.vibration.mode_frequency import Fitted, ModeFrequency
from estimators.vibration.modes import MODES, Mode
from estimators.vibration.spectrum import HOP, SEGMENT, Segment, Spectrum, segment
from estimators.wheel_speed.edge_speed import Samples
from estimators.wheel_speed.resampling import RATE

MEMORY = 30.0  # s: what has always faded so is worth a record of 60 s
FULL = 2.0 * MEMORY * RATE / HOP  # segments of that record
BLOCK_SEGMENTS = 16  # 8.5 s
LEAST_SEGMENTS = 6  # of a block that is closed early
OLDEST_BLOCK = 30.0  # s
TYRE_ORDERS = 2  # never read: mass and stiffness of tyre and rim vary round the wheel
LEARNT_TIME = 10.0  # s of turning over which the ring was learnt: what was mistaken for it is then a tenth of a line


@dataclass(frozen=True)
class Reading:
    """What one mode of one wheel says. kind: `running` (memory, with prior) or `block` (alone).

    time: until when [s]; seconds: of record that it rests on; frequency: natural frequency [Hz]; ln_std: of its ln;
    information: of ln frequency, from the spectrum alone; speed: mean wheel speed [rad/s], nan without; excitation:
    PSD of the mode over that of the noise at its peak, 0 without; parameters: of `spectral_fit`, () without.
    """

    wheel: str
    mode: Mode
    kind: str
    time: float
    seconds: float
    frequency: float
    ln_std: float
    information: float
    damping: float
    speed: float
    excitation: float
    parameters: tuple[float, ...] = ()


class _Listener:
    """One mode of one wheel: its memory and its open block."""

    def __init__(self, wheel: str, mode: Mode, radius: float) -> None:
        self.wheel, self.mode = wheel, mode
        self.fit = ModeFrequency(mode, radius)
        self.memory, self.block = Spectrum(), Spectrum()
        self.start: NDArray | None = None
        self.begun = 0.0
        self.heard = False  # in the present second

    def age(self) -> None:
        """Begin another second."""
        if not self.heard or self.memory.segments * self.memory.worth >= FULL:
            self.memory.fade(math.exp(-1.0 / MEMORY))
        self.heard = False

    def add(self, one: Segment) -> None:
        if self.memory.segments > 0.0:
            moved = abs(math.log(one.omega * self.memory.segments / self.memory.omega))
            self.memory.fade(math.exp(-0.5 * max(moved - 0.5 * self.mode.speed_span, 0.0) / self.mode.speed_span))
        self.memory.add(one)
        self.heard = True

    def leaves(self, one: Segment) -> bool:
        """Whether a segment is too fast or slow for the open block."""
        block = self.block
        return block.segments > 0.0 and abs(math.log(one.omega * block.segments / block.omega)) > self.mode.speed_span

    def reading(self, kind: str, spectrum: Spectrum, time: float) -> Reading:
        """Of a spectrum; the prior if it holds too little."""
        found: Fitted | None = None
        if spectrum.segments >= (1.0 if kind == "running" else LEAST_SEGMENTS):
            found = self.fit.fitted(spectrum, self.start)
        if found is None:
            m = self.mode
            return Reading(
                self.wheel, m, kind, time, 0.0, m.frequency, m.frequency_std, 0.0, m.damping, math.nan, 0.0
            )  # fmt: skip
        if kind == "running":
            self.start = found.parameters
        speed, seconds = spectrum.omega / spectrum.segments, spectrum.segments * HOP / RATE
        return Reading(
            self.wheel, self.mode, kind, time, seconds, found.frequency, found.ln_std, found.information,
            found.damping, speed, found.excitation, tuple(found.parameters.tolist()),
        )  # fmt: skip


class WheelVibration:
    """One wheel. radius: rolling radius [m], which turns the modes' speeds into wheel speeds."""

    def __init__(self, wheel: str, radius: float, modes: tuple[Mode, ...] = MODES) -> None:
        self._radius = radius
        self._listeners = [_Listener(wheel, mode, radius) for mode in modes]
        self._speed, self._first = np.empty(0), 0

    def forget(self) -> None:
        """After a silence of unknown length: what was heard before says nothing."""
        for listener in self._listeners:
            listener.memory.clear()
            listener.block.clear()

    def advance(self, samples: Samples, time: float, learnt: float) -> list[Reading]:
        """One second of samples, to the clock `time` [s]; learnt: turns over which the ring's pattern is known."""
        if self._first + len(self._speed) != samples.first:
            self._speed, self._first = np.empty(0), samples.first
        self._speed = np.concatenate([self._speed, samples.speed])
        for listener in self._listeners:
            listener.age()
        readings: list[Reading] = []
        at = -self._first % HOP
        while at + SEGMENT <= len(self._speed):
            self._take(
                self._speed[at : at + SEGMENT],
                (self._first + at + SEGMENT) / RATE,
                samples.knots,
                learnt,
                readings,
            )
            at += HOP
        self._speed, self._first = self._speed[at:], self._first + at
        for listener in self._listeners:
            if listener.block.segments and time - listener.begun > OLDEST_BLOCK:
                self._close(listener, time, readings)
            readings.append(listener.reading("running", listener.memory, time))
        return readings

    def _take(
        self,
        speed: NDArray,
        time: float,
        knots: float,
        learnt: float,
        readings: list[Reading],
    ) -> None:
        mean = float(np.mean(speed))
        if not math.isfinite(mean) or mean <= 0.0:
            return
        v = mean * self._radius
        listening = [x for x in self._listeners if x.mode.slowest <= v <= x.mode.fastest]
        if not listening:
            return
        ring = knots < 0.0 or learnt >= LEARNT_TIME * mean / (2.0 * math.pi)
        one = segment(speed, knots, TYRE_ORDERS if ring else round(abs(knots) / 2.0))
        if one is None:
            return
        for listener in listening:
            if listener.leaves(one):
                self._close(listener, time, readings)
            if listener.block.segments == 0.0:
                listener.begun = time - SEGMENT / RATE
            listener.add(one)
            listener.block.add(one)
            if listener.block.segments >= BLOCK_SEGMENTS:
                self._close(listener, time, readings)

    def _close(self, listener: _Listener, time: float, readings: list[Reading]) -> None:
        if listener.block.segments >= LEAST_SEGMENTS:
            reading = listener.reading("block", listener.block, time)
            if reading.information > 0.0:
                readings.append(reading)
        listener.block.clear()
