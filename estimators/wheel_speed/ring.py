"""What is known of a toothed ring, kept over stops, drives and lost counts.

Every run (see `tooth_count`) numbers its teeth anew, so a pattern learnt before fits only after it has been turned to
the right tooth. The present run learns a pattern of its own; its shift against the known one is the best of N by least
squares, in units of the values' noise, taken once it beats the second best by SURE and fits at all. Then both are one.
Until then the run's own pattern is used. Either is shrunk by what of it is noise, order by order: what the road does to
the wheel falls with the frequency, the ring's errors hardly, so a noise that is common to all orders would leave a
tenth of the ring in those of the antiphase mode. A known pattern that fits no shift after
CHANGED turns belongs to another ring and is forgotten.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.wheel_speed.tooth_pattern import MOST_TURNS, learn_pattern, order_noise, value_noise

SURE = 20.0  # difference of ln likelihoods; neighbouring teeth share noise, so 20 is not the e^-20 of independent ones
FITS = 4.0  # mean square misfit per tooth, in noise variances
CHANGED = 300.0  # turns
LEAST_NOISE = 2e-4  # pitches: timer and wear, below which two patterns need not agree
LARGEST = 0.1  # pitches: of a tooth's place in a document
LEARNT = 30.0  # turns from which a pattern is worth keeping


class Ring:
    """One wheel's ring. teeth: N."""

    def __init__(self, teeth: int) -> None:
        self.teeth = teeth
        self._known: tuple[NDArray, float, float] | None = None  # pitches, turns, noise of a turn's value
        self._begin()
        self.changes = 0

    def _begin(self) -> None:
        self.pattern, self.turns, self._square = np.zeros(self.teeth), np.zeros(self.teeth), np.zeros(self.teeth)
        self._state, self._window = np.zeros(4), np.zeros(2 * self.teeth + 1)
        self._real = np.zeros(2 * self.teeth + 1)
        self._halves = np.zeros((4, self.teeth))
        self._aligned = self._known is None

    def learn(self, time: NDArray, tooth: NDArray, run: NDArray) -> None:
        """Takes counted edges in order: time [s], tooth, run, shape (n,)."""
        at = 0
        while at < len(time):
            at += learn_pattern(
                self._state, self._window, self._real, tooth[at:], time[at:], run[at:], self.pattern, self.turns,
                self._square, self._halves,
            )  # fmt: skip
            if at < len(time):
                number = run[at]
                self._keep()
                self._begin()
                self._state[3] = number
        if not self._aligned:
            self._align()

    def _keep(self) -> None:
        if self._aligned and self.turns.min() >= LEARNT:
            noise = value_noise(self.turns, self._square)
            self._known = (self.pattern - self.pattern.mean(), float(self.turns.min()), noise)

    def _align(self) -> None:
        """Turns the known pattern to the present run's teeth, if that can be told."""
        noise = value_noise(self.turns, self._square)
        if self._known is None or not math.isfinite(noise):
            return
        pattern, turns, before = self._known
        variance = noise**2 / self.turns.min() + before**2 / turns + LEAST_NOISE**2
        misfit = np.array([np.sum((np.roll(pattern, s) - self.pattern) ** 2) for s in range(self.teeth)]) / variance
        best, second = np.argsort(misfit)[:2]
        fits = misfit[best] < FITS * self.teeth
        if fits and misfit[second] - misfit[best] > 2.0 * SURE:
            self._merge(np.roll(pattern, best), turns, before)
        elif not fits and self.turns.min() > CHANGED:
            self._known, self._aligned = None, True
            self.changes += 1

    def _merge(self, pattern: NDArray, turns: float, noise: float) -> None:
        total = self.turns + turns
        share = turns / total
        self.pattern += share * (pattern - self.pattern)
        self._square += share * (noise**2 * (turns - 1.0) / turns - self._square)
        self.turns = np.minimum(total, MOST_TURNS)
        self._aligned = True

    @property
    def std(self) -> float:
        """Of a tooth's learnt place [pitches]; inf at the beginning of a run."""
        noise = value_noise(self.turns, self._square)
        return noise / math.sqrt(self.turns.min()) if math.isfinite(noise) else math.inf

    def places(self) -> NDArray[np.float64]:
        """e [pitches] of the present run's teeth, shape (N,), each order shrunk by its own noise (Wiener)."""
        noise = order_noise(self._halves)
        if noise is None:
            return np.zeros(self.teeth)
        noise *= self._halves[1::2].sum(axis=0).min() / self.turns.min()  # a merged pattern rests on more turns
        amplitude = np.fft.rfft(self.pattern)
        amplitude *= np.maximum(1.0 - noise / np.maximum(np.abs(amplitude) ** 2, 1e-300), 0.0)
        amplitude[0] = 0.0
        return np.fft.irfft(amplitude, self.teeth)

    def document(self) -> dict[str, Any] | None:
        """The pattern (JSON values), None while there is none."""
        self._keep()
        if self._known is None:
            return None
        pattern, turns, noise = self._known
        return {"pitches": pattern.tolist(), "turns": turns, "noise": noise}

    def use(self, document: Mapping[str, Any]) -> None:
        """Start from a document. ValueError names what is wrong."""
        if not isinstance(document, Mapping):
            raise ValueError(f"tooth pattern is {document!r}, valid: a mapping of pitches, turns and noise")
        pitches, numbers = document.get("pitches"), [document.get(key) for key in ("turns", "noise")]
        if not isinstance(pitches, list) or len(pitches) != self.teeth or not all(_finite(p) for p in pitches):
            raise ValueError(f"tooth pattern has pitches {pitches!r}, valid: {self.teeth} finite numbers")
        if max(abs(p) for p in pitches) > LARGEST:
            raise ValueError(f"tooth pattern has a pitch of {max(pitches, key=abs)!r}, valid: within {LARGEST}")
        if not all(_finite(n) and n > 0.0 for n in numbers) or not 2.0 <= numbers[0] <= MOST_TURNS:  # type: ignore[operator]
            raise ValueError(f"tooth pattern has turns, noise {numbers!r}, valid: 2 to {MOST_TURNS:g}, above 0")
        turns, noise = (float(n) for n in numbers)  # type: ignore[arg-type]
        self._known = (np.array(pitches, float), turns, noise)
        self._begin()


def _finite(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
