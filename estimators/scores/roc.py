"""What a statistic can tell at any threshold: ROC and DET, area under the curve, operating point.

From one number a drive (the largest statistic of the drive, say), of m sound and n faulty drives, independent of each
other. An alarm is a statistic above the threshold; equal numbers of a sound and a faulty drive count half in the area.

    area = P(faulty > sound) + P(faulty = sound) / 2
    var = var_i(V_i) / m + var_j(W_j) / n        DeLong, DeLong, Clarke-Pearson, Biometrics 44 (1988) 837

V_i is the share of faulty drives above sound drive i, W_j of sound drives below faulty drive j. Limits are DeLong's on
the logit of the area, which keeps them within 0 to 1. Where the drives separate entirely the variance is 0; then
k = min(m, n) pairs without a drive in common were all right, and the limit is tail^(1/k).

At a given share f of false alarms the threshold is a quantile of the sound drives, itself uncertain. The band of the
detected share takes the limits of that quantile (order statistics) and of the shares above them (Clopper-Pearson), each
at half the error: distribution-free, never covering less than stated (Campbell, Stat. Med. 13 (1994) 499, with exact
limits), hence wide. Below f of about 4 / m the sound drives do not bound the threshold, and the lower limit is 0.

DET: the miss share over the false-alarm share, both as Gaussian deviates, where two Gaussians give a straight line
(Martin et al., Eurospeech 1997). Shares of 0 and 1 are infinite there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from estimators.scores.interval import CONFIDENCE, Band, Interval, finite_samples, proportion_interval, quantile_ranks


@dataclass(frozen=True, eq=False)
class Roc:
    """The empirical curve. threshold: falling from infinity, shape (k,). false_alarm, detection: shares of sound and of
    faulty drives above it, rising from 0 to 1; each with the Clopper-Pearson limits of that threshold.
    """

    threshold: NDArray[np.float64]
    false_alarm: Band
    detection: Band

    def det(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Gaussian deviates of the false-alarm share and of the miss share, shape (k,) each."""
        return special.ndtri(self.false_alarm.value), special.ndtri(1.0 - self.detection.value)


@dataclass(frozen=True)
class OperatingPoint:
    """threshold: lowest that keeps the share of false alarms on these drives, and limits of the threshold that keeps it
    on all drives. false_alarm: share of sound drives above it. detection: share of faulty drives, its limits for the
    wanted share of false alarms, the threshold's uncertainty included.
    """

    threshold: Interval
    false_alarm: Interval
    detection: Interval


def roc(sound: ArrayLike, faulty: ArrayLike, confidence: float = CONFIDENCE) -> Roc:
    """ROC of the statistic, one number a drive: sound shape (m,), faulty shape (n,); NaN is dropped."""
    s, f = finite_samples(sound, "sound"), finite_samples(faulty, "faulty")
    threshold = np.concatenate([[np.inf], np.unique(np.concatenate([s, f]))[::-1], [-np.inf]])
    return Roc(threshold, _shares_above(s, threshold, confidence), _shares_above(f, threshold, confidence))


def area(sound: ArrayLike, faulty: ArrayLike, confidence: float = CONFIDENCE) -> Interval:
    """Area under the ROC with DeLong's limits on the logit. At least 2 drives of each kind."""
    s, f = finite_samples(sound, "sound", 2), finite_samples(faulty, "faulty", 2)
    ordered_s, ordered_f = np.sort(s), np.sort(f)
    below = 0.5 * (np.searchsorted(ordered_s, f) + np.searchsorted(ordered_s, f, side="right")) / len(s)
    above = 1.0 - 0.5 * (np.searchsorted(ordered_f, s) + np.searchsorted(ordered_f, s, side="right")) / len(f)
    value = float(below.mean())
    tail = (1.0 - confidence) / 2.0
    if value in (0.0, 1.0):
        limit = tail ** (1.0 / min(len(s), len(f)))
        return Interval(1.0, limit, 1.0) if value == 1.0 else Interval(0.0, 0.0, 1.0 - limit)
    error = math.sqrt(above.var(ddof=1) / len(s) + below.var(ddof=1) / len(f))
    centre, reach = special.logit(value), special.ndtri(1.0 - tail) * error / (value * (1.0 - value))
    return Interval(value, float(special.expit(centre - reach)), float(special.expit(centre + reach)))


def operating_point(
    sound: ArrayLike, faulty: ArrayLike, false_alarm_share: float, confidence: float = CONFIDENCE
) -> OperatingPoint:
    """Threshold and detected share where at most `false_alarm_share` of the sound drives alarm.

    ValueError unless 0 < false_alarm_share < 1.
    """
    s, f = np.sort(finite_samples(sound, "sound")), finite_samples(faulty, "faulty")
    if not 0.0 < false_alarm_share < 1.0:
        raise ValueError(f"false_alarm_share is {false_alarm_share}, valid: above 0 and below 1")
    allowed = math.floor(false_alarm_share * len(s) + 1e-9)
    threshold = float(s[len(s) - 1 - allowed])
    limits = np.concatenate([[-np.inf], s, [np.inf]])
    ranks = quantile_ranks(len(s), 1.0 - false_alarm_share, confidence)
    half_error = 0.5 * (1.0 + confidence)
    outer = quantile_ranks(len(s), 1.0 - false_alarm_share, half_error)
    fewest, most = (proportion_interval(int(np.sum(f > limits[rank])), len(f), half_error) for rank in outer[::-1])
    return OperatingPoint(
        Interval(threshold, min(float(limits[ranks[0]]), threshold), max(float(limits[ranks[1]]), threshold)),
        proportion_interval(int(np.sum(s > threshold)), len(s), confidence),
        Interval(float(np.mean(f > threshold)), fewest.low, most.high),
    )


def detection_band(
    sound: ArrayLike, faulty: ArrayLike, false_alarm_shares: ArrayLike, confidence: float = CONFIDENCE
) -> Band:
    """Detected share at each share of false alarms, with its pointwise band; shape (k,) as the shares."""
    shares = np.atleast_1d(np.asarray(false_alarm_shares, dtype=np.float64))
    points = [operating_point(sound, faulty, float(share), confidence).detection for share in shares]
    return Band(*np.array([(point.value, point.low, point.high) for point in points]).T)


def _shares_above(samples: NDArray[np.float64], thresholds: NDArray[np.float64], confidence: float) -> Band:
    counts = len(samples) - np.searchsorted(np.sort(samples), thresholds, side="right")
    found = {count: proportion_interval(count, len(samples), confidence) for count in np.unique(counts).tolist()}
    rows = [(found[count].value, found[count].low, found[count].high) for count in counts.tolist()]
    return Band(*np.array(rows).T)
