"""Prewhitening of correlated residuals by an autoregression, so that designs for independent ones hold.

x_t - m = a_1 (x_{t-1} - m) + ... + a_p (x_{t-p} - m) + s e_t. The whitened residual is e_t, unit variance. Fitted by
least squares over stretches without a gap, the order by Akaike's criterion. A lasting shift d of x becomes d (1 - a_1 -
... - a_p) / s of e, often much less: correlation hides shifts, and `shift_after` says how much. A sample that is NaN or
infinite, and the p after it, give NaN, which a `Monitor` counts and passes over. Left out: moving-average terms, and
heavy tails (whitened residuals need not be Gaussian).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

HIGHEST_ORDER = 20


@dataclass(frozen=True)
class Whitener:
    """coefficients a_1 .. a_p, mean m and innovation std s of the residual."""

    coefficients: tuple[float, ...]
    mean: float
    std: float

    @property
    def order(self) -> int:
        """Samples before it that a whitened residual needs."""
        return len(self.coefficients)

    def whiten(self, x: ArrayLike) -> NDArray[np.float64]:
        """e of shape (n,) for residuals x of shape (n,); NaN for the first p and where a sample is missing."""
        centred = np.asarray(x, dtype=np.float64) - self.mean
        centred = np.where(np.isfinite(centred), centred, np.nan)
        white = np.full(len(centred), np.nan)
        if len(centred) > self.order:
            rest = centred[self.order :].copy()
            for lag, a in enumerate(self.coefficients, 1):
                rest -= a * centred[self.order - lag : len(centred) - lag]
            white[self.order :] = rest / self.std
        return white

    def shift_after(self, shift: float) -> float:
        """What a lasting shift of x, in the unit of x, is of e."""
        return shift * (1.0 - sum(self.coefficients)) / self.std


class WhiteningFilter:
    """`Whitener` one sample at a time, with the same result."""

    def __init__(self, whitener: Whitener) -> None:
        self.whitener = whitener
        self._recent = np.empty(0)

    def step(self, x: float) -> float:
        """e for the next residual, NaN while it cannot be told."""
        self._recent = np.append(self._recent, x)[-self.whitener.order - 1 :]
        return float(self.whitener.whiten(self._recent)[-1])

    def reset(self) -> None:
        """Forget the samples before."""
        self._recent = np.empty(0)


def fit_whitener(x: ArrayLike, order: int | None = None) -> Whitener:
    """From residuals without a change, shape (n,). order: p, if None the best up to `HIGHEST_ORDER`.

    ValueError if there are too few usable samples, they do not vary, or the fit is not stable.
    """
    samples = np.asarray(x, dtype=np.float64)
    if order is not None and not 0 <= order <= HIGHEST_ORDER:
        raise ValueError(f"order is {order}, valid: 0 to {HIGHEST_ORDER}")
    finite = np.isfinite(samples)
    highest = HIGHEST_ORDER if order is None else order
    need = 10 * (highest + 1)
    mean = float(samples[finite].mean()) if finite.any() else 0.0
    rows = _lagged(np.where(finite, samples, np.nan) - mean, highest)
    if len(rows) < need:
        raise ValueError(f"{len(rows)} stretches of {highest + 1} usable residuals, want at least {need}")
    if not np.ptp(rows[:, 0]) > 0.0:
        raise ValueError("the residuals do not vary")
    candidates = []
    for p in range(highest + 1) if order is None else (order,):
        a = np.linalg.lstsq(rows[:, 1 : p + 1], rows[:, 0], rcond=None)[0] if p else np.empty(0)
        variance = float(np.mean((rows[:, 0] - rows[:, 1 : p + 1] @ a) ** 2))
        candidates.append((len(rows) * np.log(max(variance, 1e-300)) + 2.0 * p, a, variance))
    _, a, variance = min(candidates, key=lambda c: c[0])
    if len(a) and np.abs(np.roots(np.concatenate([[1.0], -a]))).max() >= 1.0:
        raise ValueError(
            "the residuals wander without bound (an autoregression of them is not stable): difference them"
        )
    return Whitener(tuple(a.tolist()), mean, variance**0.5)


def _lagged(x: NDArray[np.float64], order: int) -> NDArray[np.float64]:
    """Rows (x_t, x_{t-1}, ..., x_{t-order}) without NaN."""
    if len(x) <= order:
        return np.empty((0, order + 1))
    rows = np.lib.stride_tricks.sliding_window_view(x, order + 1)[:, ::-1]
    return rows[np.isfinite(rows).all(axis=1)]
