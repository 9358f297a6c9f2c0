"""When a sensor samples, and what it sees then: instants on a clock, and the value or the mean of the steps up to each.

Instants are in steps of 1 ms from time zero: x_j = 1000 j / rate + jitter, j whole. A clock's pattern so belongs to the
time axis, not to the chunk. A mean runs over the steps in (x_{j-1}, x_j]; where none lies there (a clock as fast as the
steps, jittered) the step before counts.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled
from testbed.sensors.motion import STEPS_PER_SECOND, FloatArray

_JITTER_LIMIT = 0.49  # of an interval: instants never swap


class Clock:
    """Sampling instants of one sensor. rate [Hz]. jitter: std of an instant [s], clipped at half an interval."""

    def __init__(self, rate: float, jitter: float = 0.0, random: np.random.Generator | None = None) -> None:
        self._rate, self._random = rate, random
        self._jitter = jitter * STEPS_PER_SECOND if random is not None else 0.0
        self._interval = STEPS_PER_SECOND / rate
        self._next: int | None = None  # number j of the next instant to draw
        self._start = 0  # the drive's first step
        self._drawn: FloatArray = np.empty(0)  # drawn, but still ahead

    def due(self, first: int, last: int) -> FloatArray:
        """Instants [steps] up to and including step `last`, not given before. first: the chunk's first step."""
        if self._next is None:
            self._next = math.ceil(first * self._rate / STEPS_PER_SECOND - 1e-9)
            self._start = first
        ahead = _JITTER_LIMIT * self._interval if self._jitter else 0.0
        end = math.floor((last + ahead) * self._rate / STEPS_PER_SECOND) + 1  # at least all that can be due
        drawn = np.arange(self._next, end + 1) * STEPS_PER_SECOND / self._rate
        self._next += len(drawn)
        if self._random is not None and self._jitter:
            drawn += np.clip(self._jitter * self._random.standard_normal(len(drawn)), -ahead, ahead)
        instants = np.concatenate([self._drawn, np.maximum(drawn, float(self._start))])
        due = int(np.searchsorted(instants, last, side="right"))
        self._drawn = instants[due:]
        return instants[:due]


@compiled
def _values_at(instants, first, rows, before, out):
    """Values at the instants, linear between two steps; `before` is the row of step first - 1."""
    for j in range(instants.size):
        step = math.floor(instants[j])
        share = instants[j] - step
        for k in range(rows.shape[1]):
            low = rows[step - first, k] if step >= first else before[k]
            out[j, k] = low if share == 0.0 else low + share * (rows[step + 1 - first, k] - low)


@compiled
def _means_until(instants, first, rows, before, total, count, out):
    """Means of the steps since the instant before; total, count: the open sum, carried from chunk to chunk."""
    width, j = rows.shape[1], 0
    for i in range(rows.shape[0] + 1):
        while j < instants.size and (i == rows.shape[0] or instants[j] < first + i):
            for k in range(width):
                held = rows[i - 1, k] if i > 0 else before[k]
                out[j, k] = total[k] / count[0] if count[0] > 0 else held
                total[k] = 0.0
            count[0] = 0
            j += 1
        if i < rows.shape[0]:
            for k in range(width):
                total[k] += rows[i, k]
            count[0] += 1


class Sampler:
    """Turns rows, one a step, into samples at a clock's instants. width: columns."""

    def __init__(self, clock: Clock, average: bool, width: int) -> None:
        self._clock, self._average = clock, average
        self._before = np.zeros(width)
        self._total, self._count = np.zeros(width), np.zeros(1, dtype=np.int64)

    def advance(self, first: int, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Instants [steps], shape (m,), and samples, shape (m, width), of rows, shape (n, width), from step `first`."""
        instants = self._clock.due(first, first + len(rows) - 1)
        samples = np.empty((len(instants), rows.shape[1]))
        if self._average:
            _means_until(instants, first, rows, self._before, self._total, self._count, samples)
        else:
            _values_at(instants, first, rows, self._before, samples)
        self._before = rows[-1].copy()
        return instants, samples
