"""A linear Kalman filter that cannot wind up: covariance bounded by the prior, information gated on excitation.

filterpy's `KalmanFilter` inside. Three additions:
- Bound: after each prediction the covariance is scaled, P <- D P D, so that no standard deviation exceeds the prior's.
  An unobservable state keeps its value and becomes as uncertain as at the start, never more.
- Gate: `update` takes the true measurement row and an `excited` one, built from regressors that follow the signal only
  when it leaves a band (`Anchor`). The innovation uses the true row, the gain and covariance the excited one, so noise
  in a nearly constant regressor cannot pretend to separate two states.
- Clip: an innovation beyond `OUTLIER` standard deviations counts with a larger variance (Huber), never not at all.
"""

from __future__ import annotations

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray

OUTLIER = 3.0


class Anchor:
    """A value that follows a signal only when the two are more than a band apart.

    memory: samples over which the signal is averaged before (exponentially), so that noise does not leave the band.
    """

    def __init__(self, memory: float = 1.0) -> None:
        self._value = self._mean = float("nan")
        self._memory = memory

    def follow(self, signal: float, band: float) -> float:
        """The anchor after seeing `signal`."""
        known = self._mean == self._mean
        self._mean = self._mean + (signal - self._mean) / self._memory if known else signal
        if not abs(self._mean - self._value) <= band:
            self._value = self._mean
        return self._value


class BoundedFilter:
    """State x of shape (n,), prior mean and std, random walk `drift` [unit per sqrt(s)] of each state."""

    def __init__(self, mean: list[float], std: list[float], drift: list[float]) -> None:
        size = len(mean)
        self._filter = KalmanFilter(dim_x=size, dim_z=1)
        self._filter.inv = np.reciprocal  # measurements are scalar
        self._filter.x = np.array(mean, dtype=np.float64).reshape(size, 1)
        self._filter.P = np.diag(np.square(np.array(std, dtype=np.float64)))
        self._bound = np.array(std, dtype=np.float64)
        self._drift = np.diag(np.square(np.array(drift, dtype=np.float64)))

    @property
    def state(self) -> NDArray[np.float64]:
        """Estimate, shape (n,)."""
        return self._filter.x[:, 0].copy()

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Of the estimate, shape (n, n)."""
        return self._filter.P.copy()

    @property
    def std(self) -> NDArray[np.float64]:
        """Of each state, shape (n,)."""
        return np.sqrt(np.maximum(np.diag(self._filter.P), 0.0))

    def predict(self, elapsed: float, transition: NDArray | None = None, noise: NDArray | float = 0.0) -> None:
        """Step `elapsed` [s] ahead: random walk, plus `transition` and process noise (n, n) of a dynamic part."""
        self._filter.predict(F=transition, Q=self._drift * elapsed + noise)
        std = self.std
        if (std > self._bound).any():
            scale = self._bound / np.maximum(std, self._bound)
            self._filter.P = self._filter.P * np.outer(scale, scale)

    def forget(self, state: int) -> None:
        """The state keeps its value, is as uncertain as at the start, and tells nothing of the others."""
        self._filter.P[state, :] = self._filter.P[:, state] = 0.0
        self._filter.P[state, state] = self._bound[state] ** 2

    def innovation(self, measured: float, row: NDArray[np.float64]) -> float:
        """measured - row @ x."""
        return float(measured - row @ self._filter.x[:, 0])

    def spread(self, row: NDArray[np.float64]) -> float:
        """Variance that the state's uncertainty gives row @ x."""
        return float(row @ self._filter.P @ row)

    def update(
        self, measured: float, row: NDArray[np.float64], variance: float, excited: NDArray[np.float64] | None = None
    ) -> float:
        """One scalar measurement, row of shape (n,); returns the innovation. `excited`: the row that carries
        information.
        """
        surprise = self.innovation(measured, row)
        gain_row = (row if excited is None else excited).reshape(1, -1)
        spread = self.spread(gain_row[0]) + variance
        variance *= max(1.0, abs(surprise) / (OUTLIER * spread**0.5))
        equivalent = surprise + float(gain_row[0] @ self._filter.x[:, 0])
        self._filter.update(equivalent, R=np.array([[variance]]), H=gain_row)
        self._filter.P = 0.5 * (self._filter.P + self._filter.P.T)
        return surprise
