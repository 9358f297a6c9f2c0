"""What a sound car's residuals do: a linear Kalman filter of everything but a loss, and what a loss would do to it.

State, in which a sound car differs from its calibration (all random walks)

    0-3     ln antiphase frequency of each wheel        day's temperature, load, camber, road
    4-7     ln in-phase frequency of each wheel
    8-10    radius contrasts: left-right, front-rear, diagonal    day's radii, payload
    11      offset of the gyro [rad/s]        12  slip per normalised traction of the driven axle [-]
    13, 14  what the path's curvature adds to left-right and diagonal [m]: tracks that are not as told
    15      half the difference of slip per traction, left less right [-]

One scalar measurement y with row h and variance R updates mean x and covariance P as usual, with a Huber weight. A loss
d [ln pressure], shape (4,), from block t0 on adds g d to the measurement. It moves the innovation by phi d,

    phi = g - h M,     M <- M + K phi            M: what the loss has pulled the state along so far, shape (16, 4)

so each onset t0 carries M and the sums B = sum phi nu / S, C = sum phi phi' / S, from which the likelihood ratio of any
loss d is B d - d C d / 2 [Willsky & Jones, IEEE Trans. Autom. Control 21 (1976) 108]. Onsets are kept at ages that grow
by a ratio: the newest ones all, the first one (a loss before the drive) and the likeliest for good.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled

STATES = 16
ANTIPHASE, IN_PHASE, CONTRAST, GYRO, SLIP, BEND_LEFT_RIGHT, BEND_DIAGONAL, SLIP_DIFFERENCE = 0, 4, 8, 11, 12, 13, 14, 15
ONSETS = 32
HUBER = 3.0


class SoundCar:
    """mean (16,), covariance (16, 16); onsets: block numbers, shape (n,); score (n, 4), information (n, 4, 4)."""

    def __init__(self, covariance: NDArray[np.float64], mean: NDArray[np.float64] | None = None) -> None:
        self.mean = np.zeros(STATES) if mean is None else mean.copy()
        self.covariance = covariance.copy()
        self.onsets = np.empty(0, dtype=np.int64)
        self._pulled = np.zeros((ONSETS + 1, STATES, 4))
        self._score = np.zeros((ONSETS + 1, 4))
        self._information = np.zeros((ONSETS + 1, 4, 4))

    @property
    def score(self) -> NDArray[np.float64]:
        return self._score[: len(self.onsets)]

    @property
    def information(self) -> NDArray[np.float64]:
        return self._information[: len(self.onsets)]

    def begin(self, block: int, walk: NDArray[np.float64], likeliest: int | None) -> None:
        """A block begins: the state may have moved (walk: covariance, (16, 16)) and a loss may begin with it.
        likeliest: place of the onset that is best at present, which is kept."""
        self.covariance += walk
        if len(self.onsets) == ONSETS:
            self._forget(block, likeliest)
        self.onsets = np.append(self.onsets, block)
        slot = len(self.onsets) - 1
        self._pulled[slot], self._score[slot], self._information[slot] = 0.0, 0.0, 0.0

    def _forget(self, block: int, likeliest: int | None) -> None:
        """The onset whose neighbours are nearest in the ratio of their ages goes; never the first or the likeliest."""
        age = (block - self.onsets).astype(np.float64)
        ratio = age[:-2] / age[2:]
        if likeliest is not None and 0 < likeliest < len(age) - 1:
            ratio[likeliest - 1] = np.inf
        gone = int(np.argmin(ratio)) + 1
        kept = np.delete(np.arange(len(self.onsets)), gone)
        for table in (self._pulled, self._score, self._information):
            table[: len(kept)] = table[kept]
        self.onsets = self.onsets[kept]

    def take(
        self, row: NDArray[np.float64], loss: NDArray[np.float64], value: float, variance: float
    ) -> tuple[float, float]:
        """One measurement: row h (16,), loss g (4,), value, variance R. Returns innovation and its explained
        variance h P h'."""
        return absorb(
            self.mean, self.covariance, self._pulled, self._score, self._information, len(self.onsets),
            row, loss, value, variance,
        )  # fmt: skip


@compiled
def absorb(mean, covariance, pulled, score, information, onsets, row, loss, value, variance):
    """See `SoundCar.take`; all arrays but row and loss are written."""
    n = mean.size
    gain = np.zeros(n)
    innovation, explained = value, 0.0
    for i in range(n):
        innovation -= row[i] * mean[i]
        for j in range(n):
            gain[i] += covariance[i, j] * row[j]
    for i in range(n):
        explained += row[i] * gain[i]
    total = explained + variance
    total = explained + variance * max(1.0, abs(innovation) / (HUBER * np.sqrt(total)))
    phi = np.empty(4)
    for c in range(onsets):
        for w in range(4):
            phi[w] = loss[w]
            for i in range(n):
                phi[w] -= row[i] * pulled[c, i, w]
        for w in range(4):
            score[c, w] += phi[w] * innovation / total
            for v in range(4):
                information[c, w, v] += phi[w] * phi[v] / total
            for i in range(n):
                pulled[c, i, w] += gain[i] * phi[w] / total
    for i in range(n):
        mean[i] += gain[i] * innovation / total
    for i in range(n):
        for j in range(n):
            covariance[i, j] -= gain[i] * gain[j] / total
    return innovation, explained
