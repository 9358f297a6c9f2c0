"""Local CUSUM (LCUSUM), and local + global (LGCUSUM), one- and double-sided. Thesis chapter 3.

A local CUSUM sees x where |x| <= limit and 0 else; several with different limits run side by side, each with its drift
and threshold, and any of them alarms. A limit of infinity is a normal ("global") CUSUM. The thesis' filter lacks the
abs(), so it passes every negative residual. The statistic is the largest of the channels', each in units of its own
threshold: alarm above 1.

Run length of one channel: exact, by the integral equation with the atom that the filter puts at 0. Of several: between
1 / sum(1 / L_c), as if they alarmed independently, and the smallest L_c; measured by simulation up to `SIMULATED`
samples. Beyond, the ratio to the lower bound is measured twice, at thresholds all lowered by one factor, and its excess
over 1 extrapolated as a power of the run length: rarer alarms coincide more rarely.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, log
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from estimators.detectors import recursions
from estimators.detectors.cusum_run_length import AGREE, gaussian_run_length, run_length
from estimators.detectors.detector import Detector, RunLength, both_sides, check_number, numbers_of
from estimators.detectors.increments import Filtered
from estimators.detectors.simulate import simulated_run_length

SIMULATED = 1e4  # samples: longer run lengths of several channels are extrapolated
_SHARES = (0.05, 0.7)  # of `SIMULATED`, where a ratio to extrapolate is measured
ALARMS = 10000  # of a simulation: 2 % (95 %)


@dataclass(frozen=True)
class LocalCusum(Detector):
    """limits [std] > 0 (inf: global), drifts k [std] in [0, limit), thresholds h [std] > 0, one of each per channel.

    sides: upper, lower or both.
    """

    limits: tuple[float, ...]
    drifts: tuple[float, ...]
    thresholds: tuple[float, ...]
    sides: str = "upper"
    kind: ClassVar[int] = recursions.LOCAL_CUSUM

    def _check(self) -> None:
        if not len(self.limits) == len(self.drifts) == len(self.thresholds) > 0:
            raise ValueError(
                f"{len(self.limits)} limits, {len(self.drifts)} drifts and {len(self.thresholds)} thresholds, "
                "valid: one of each per channel"
            )
        for limit, drift, threshold in zip(self.limits, self.drifts, self.thresholds, strict=True):
            if not limit > 0.0:
                raise ValueError(f"limit is {limit:g}, valid: a number above 0, or inf")
            check_number("threshold", threshold, 0.0, above=True)
            check_number("drift", drift, 0.0)
            if drift >= limit:
                raise ValueError(f"drift is {drift:g}, valid: below the limit {limit:g}, or the channel never alarms")

    @property
    def threshold(self) -> float:  # type: ignore[override]
        """1: the statistic is in units of the thresholds."""
        return 1.0

    @property
    def state_size(self) -> int:
        """g+ and g- of each channel."""
        return 2 * len(self.limits)

    def numbers(self) -> NDArray[np.float64]:
        """The sides; limit, drift and threshold of each channel."""
        channels = np.column_stack([self.limits, self.drifts, self.thresholds])
        return numbers_of(self.sides, channels.ravel().tolist())

    def average_run_length(self, mean: float = 0.0, std: float = 1.0) -> RunLength:
        """Exact for one channel, else by simulation."""
        least, most = self.bounds(mean, std)
        if len(self.limits) == 1:
            return RunLength.exact(least)
        if least <= SIMULATED:
            return simulated_run_length(self, mean, std, ALARMS)
        (short, excess_short), (long, excess) = (self._excess(SIMULATED * s, mean, std) for s in _SHARES)
        decay = log(max(excess_short / excess, 1.0)) / log(long / short) if excess > 0.0 else 0.0
        ratio = 1.0 + max(excess, 0.0) * (long / least) ** decay
        return RunLength(min(least * ratio, most), least, most, "simulation, extrapolated")

    def bounds(self, mean: float = 0.0, std: float = 1.0) -> tuple[float, float]:
        """Run length as if the channels were independent, and that of the channel which alarms soonest."""
        lengths = [
            channel_run_length(*channel, self.sides, mean, std)
            for channel in zip(self.thresholds, self.limits, self.drifts, strict=True)
        ]
        return 1.0 / sum(1.0 / length for length in lengths), min(lengths)

    def scaled(self, factor: float) -> LocalCusum:
        """The same with all thresholds times a factor."""
        return LocalCusum(self.limits, self.drifts, tuple(factor * h for h in self.thresholds), self.sides)

    def _excess(self, length: float, mean: float, std: float) -> tuple[float, float]:
        """With thresholds lowered to a lower bound of about `length`: that bound, and by what share it is passed."""
        factor = brentq(lambda f: log(self.scaled(f).bounds(mean, std)[0] / length), 0.01, 1.0, rtol=1e-2)
        easier = self.scaled(float(factor))
        bound = easier.bounds(mean, std)[0]
        return bound, simulated_run_length(easier, mean, std, ALARMS).mean / bound - 1.0


def channel_run_length(
    threshold: float,
    limit: float,
    drift: float,
    sides: str,
    mean: float = 0.0,
    std: float = 1.0,
    agree: float = AGREE,
) -> float:
    """Exact run length of a single channel, one- or two-sided, to a relative accuracy of about `agree`."""

    def one_sided(m: float) -> float:
        if limit == inf:
            return gaussian_run_length(threshold, drift, m, std)
        return run_length(threshold, drift, Filtered(m, std, limit), agree)

    if sides == "both":
        up = one_sided(mean)
        return both_sides(up, up if mean == 0.0 else one_sided(-mean))
    return one_sided(mean if sides == "upper" else -mean)
