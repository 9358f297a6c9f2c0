"""What a sound car's residuals do: a linear Kalman filter of everything but a loss, and what a loss would do to it.

State, in which a sound car differs from its calibration (all random walks)

    0-31    ln antiphase frequency of each wheel at 8 nodes of speed    what was not learnt; day's temperature, road
    32-51   ln in-phase frequency of each wheel at 5 nodes
    52-54   radius contrasts: left-right, front-rear, diagonal    day's radii, payload
    55      offset of the gyro [rad/s]        56  slip per normalised traction of the driven axle [-]
    57, 58  what the path's curvature adds to left-right and diagonal [m]: tracks that are not as told
    59      half the difference of slip per traction, left less right [-]
    60      how much more the tyres warm than `warming` says [-]

One scalar measurement y with row h and variance R updates mean x and covariance P as usual, with a Huber weight. A loss
d [ln pressure], shape (4,), that has come to the share s of its size adds g s d to the measurement. It moves the
innovation by phi d,

    phi = g s - h M,     M <- M + K phi          M: what the loss has pulled the state along so far, shape (61, 4)

so each onset carries M and the sums B = sum phi nu / S, C = sum phi phi' / S, from which the likelihood ratio of any
loss d is B d - d C d / 2 [Willsky & Jones, IEEE Trans. Autom. Control 21 (1976) 108]. Two kinds of onset begin with
each block: a sudden loss (s = 1 at once) and a leak (s rises over LEAK seconds). They are kept at ages that grow by a
ratio: the newest ones all; the first (a loss before the drive) and the likeliest for good.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.itpms.mode_nodes import MODE_NODES

FREQUENCY = (0, 4 * MODE_NODES[0].count)  # of the two modes, wheel by wheel, node by node
CONTRAST = FREQUENCY[1] + 4 * MODE_NODES[1].count
GYRO, SLIP, BEND_LEFT_RIGHT, BEND_DIAGONAL, SLIP_DIFFERENCE, WARMTH, STATES = range(CONTRAST + 3, CONTRAST + 10)
ONSETS = (32, 16)  # sudden, leaks
LEAK = 120.0  # s
HUBER = 3.0


class SoundCar:
    """mean (61,), covariance (61, 61); onsets: block numbers, rise: s over which each loss comes, shape (n,); score
    (n, 4), information (n, 4, 4)."""

    def __init__(self, covariance: NDArray[np.float64], mean: NDArray[np.float64] | None = None) -> None:
        self.mean = np.zeros(STATES) if mean is None else mean.copy()
        self.covariance = covariance.copy()
        self.onsets, self.rise = np.empty(0, dtype=np.int64), np.empty(0)
        self._share = np.empty(0)
        size = sum(ONSETS) + 2
        self._pulled = np.zeros((size, STATES, 4))
        self._score = np.zeros((size, 4))
        self._information = np.zeros((size, 4, 4))

    @property
    def score(self) -> NDArray[np.float64]:
        return self._score[: len(self.onsets)]

    @property
    def information(self) -> NDArray[np.float64]:
        return self._information[: len(self.onsets)]

    def begin(self, block: int, seconds: float, walk: NDArray[np.float64], likeliest: int | None) -> int | None:
        """A block begins: the state may have moved (walk: covariance, (61, 61)) and a loss may begin with it. seconds:
        of a block. likeliest: place of the onset that is best at present, which is kept; returns its place now."""
        self.covariance += walk
        for rise, most in zip((0.0, LEAK), ONSETS, strict=True):
            if int((self.rise == rise).sum()) == most:
                likeliest = self._forget(block, rise, likeliest)
            self.onsets, self.rise = np.append(self.onsets, block), np.append(self.rise, rise)
            slot = len(self.onsets) - 1
            self._pulled[slot], self._score[slot], self._information[slot] = 0.0, 0.0, 0.0
        age = seconds * (block - self.onsets + 0.5)
        self._share = np.where(self.rise > 0.0, np.minimum(age / np.maximum(self.rise, seconds), 1.0), 1.0)
        return likeliest

    def _forget(self, block: int, rise: float, likeliest: int | None) -> int | None:
        """Of one kind of onset the one whose neighbours are nearest in the ratio of their ages goes; never the first or
        the likeliest."""
        places = np.flatnonzero(self.rise == rise)
        age = (block - self.onsets[places]).astype(np.float64)
        ratio = age[:-2] / age[2:]
        ratio[places[1:-1] == likeliest] = np.inf
        gone = int(places[np.argmin(ratio) + 1])
        kept = np.delete(np.arange(len(self.onsets)), gone)
        for table in (self._pulled, self._score, self._information):
            table[: len(kept)] = table[kept]
        self.onsets, self.rise = self.onsets[kept], self.rise[kept]
        return likeliest - 1 if likeliest is not None and likeliest > gone else likeliest

    def take(
        self, row: NDArray[np.float64], loss: NDArray[np.float64], value: float, variance: float
    ) -> tuple[float, float]:
        """One measurement: row h (61,), loss g (4,), value, variance R. Returns innovation and its explained
        variance h P h'."""
        return absorb(
            self.mean, self.covariance, self._pulled, self._score, self._information, self._share,
            row, loss, value, variance,
        )  # fmt: skip


@compiled
def absorb(mean, covariance, pulled, score, information, share, row, loss, value, variance):
    """See `SoundCar.take`; all arrays but share, row and loss are written."""
    n = mean.size
    used = np.flatnonzero(row)
    gain = np.zeros(n)
    innovation, explained = value, 0.0
    for j in used:
        innovation -= row[j] * mean[j]
        for i in range(n):
            gain[i] += covariance[j, i] * row[j]
    for j in used:
        explained += row[j] * gain[j]
    total = explained + variance
    total = explained + variance * max(1.0, abs(innovation) / (HUBER * np.sqrt(total)))
    phi = np.empty(4)
    for c in range(share.size):
        for w in range(4):
            phi[w] = loss[w] * share[c]
            for j in used:
                phi[w] -= row[j] * pulled[c, j, w]
        for w in range(4):
            score[c, w] += phi[w] * innovation / total
            for v in range(4):
                information[c, w, v] += phi[w] * phi[v] / total
        for i in range(n):
            for w in range(4):
                pulled[c, i, w] += gain[i] * phi[w] / total
    for i in range(n):
        mean[i] += gain[i] * innovation / total
        for k in range(n):
            covariance[i, k] -= gain[i] * gain[k] / total
    return innovation, explained
