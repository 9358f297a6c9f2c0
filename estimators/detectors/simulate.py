"""Run lengths by simulation, for every kind of detector and any noise, with their interval.

One long stream of residuals is fed to the compiled detector, which restarts after each alarm; the samples from alarm to
alarm are independent draws of the run length. The stream ends at a number of alarms, never at a number of samples, so
long runs are not cut off and the mean has no bias. The interval is mean +- 1.96 s / sqrt(alarms).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from estimators.detectors.detector import Detector, RunLength
from estimators.detectors.loops import intervals

Noise = Callable[[np.random.Generator, int], NDArray[np.float64]]
"""(generator, n) -> n residuals that follow those of the call before."""

MOST_SAMPLES = 4e9  # one or two minutes
_BLOCK = 1 << 18


def gaussian(mean: float = 0.0, std: float = 1.0) -> Noise:
    """Independent Gaussian residuals."""

    def draw(generator: np.random.Generator, n: int) -> NDArray[np.float64]:
        noise = generator.standard_normal(n)
        if std != 1.0:
            noise *= std
        if mean != 0.0:
            noise += mean
        return noise

    return draw


def run_lengths(
    detector: Detector, noise: Noise, alarms: int, seed: int = 0, most_samples: float = MOST_SAMPLES
) -> NDArray[np.int64]:
    """Samples to each of so many alarms, shape (alarms,). ValueError if they do not come within `most_samples`."""
    generator = np.random.Generator(np.random.SFC64(seed))
    lengths = np.empty(alarms, dtype=np.int64)
    numbers, state = detector.numbers(), np.zeros(detector.state_size)
    found, waited, drawn = 0, 0, 0
    block = 1024  # grows, so that a few short runs cost little
    while found < alarms:
        if drawn >= most_samples:
            raise ValueError(f"{found} of {alarms} alarms in {drawn:.3g} samples: too rare to be simulated")
        more, waited = intervals(
            detector.kind, numbers, detector.level, state, waited, noise(generator, block), lengths[found:]
        )
        found += more
        drawn += block
        block = min(2 * block, _BLOCK)
    return lengths


def interval(lengths: NDArray[np.int64]) -> RunLength:
    """Mean of independent run lengths with its 95 % interval."""
    mean, half = float(lengths.mean()), 1.96 * float(lengths.std(ddof=1)) / len(lengths) ** 0.5
    return RunLength(mean, mean - half, mean + half, "simulation")


def simulated_run_length(
    detector: Detector, mean: float = 0.0, std: float = 1.0, alarms: int = 4000, seed: int = 0
) -> RunLength:
    """Average run length in Gaussian residuals; 4000 alarms give it to about 3 % (95 %)."""
    return interval(run_lengths(detector, gaussian(mean, std), alarms, seed))
