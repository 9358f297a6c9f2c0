"""How noisy a residual is, measured from its innovations: variance, and how much their memory worsens an average.

Over the last `MEMORY` samples (exponentially weighted) the variance s^2 and the lag-one correlation a of the
innovations are tracked, starting from a declared variance that counts as `PRIOR` samples. What the filter's own
uncertainty adds to the innovations is taken off s^2. The variance given to a filter is that of white noise with the
same information, s^2 (1 + a) / (1 - a) (first-order Markov noise), a less one standard error of itself and within 0 and
0.9. Large innovations enter clipped at `CLIP` standard deviations, so that one kerb does not widen the next minute.
"""

from __future__ import annotations

MEMORY = 600.0
PRIOR = 3.0
CLIP = 4.0
LEAST = 0.2  # share of the innovations' variance that is noise in any case
FLOOR = 1e-14


class NoiseLevel:
    """Variance of one residual, in its unit squared."""

    def __init__(self, variance: float) -> None:
        self._variance = self._total = variance
        self._explained = self._product = 0.0
        self._count = PRIOR
        self._last: float | None = None

    @property
    def variance(self) -> float:
        """White noise that carries as much information as this one per sample."""
        correlation = self._product / max(self._total, FLOOR) - self._count**-0.5
        correlation = min(max(correlation, 0.0), 0.9)
        return self._variance * (1.0 + correlation) / (1.0 - correlation)

    @property
    def scatter(self) -> float:
        """Std of one sample, whatever its memory, in the residual's unit."""
        return self._variance**0.5

    def add(self, innovation: float, explained: float) -> None:
        """One more innovation, in time order; explained: its variance from the state's own uncertainty."""
        bound = CLIP * (self._variance + explained) ** 0.5
        clipped = min(max(innovation, -bound), bound)
        self._count = min(self._count + 1.0, MEMORY)
        self._explained += (explained - self._explained) / self._count
        self._total += (clipped**2 - self._total) / self._count
        self._variance = max(self._total - self._explained, LEAST * self._total, FLOOR)
        if self._last is not None:
            self._product += (clipped * self._last - self._product) / self._count
        self._last = clipped

    def interrupt(self) -> None:
        """The next innovation does not follow on the last one."""
        self._last = None
