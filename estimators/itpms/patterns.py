"""The 16 patterns of low tyres: how likely each is, and how much its tyres have lost, from the likelihood of a loss.

ln of the likelihood ratio of a loss d [ln pressure], shape (4,), against none is B d - d C d / 2 (`sound_car`). In
pattern m the n low tyres have lost about the same, the others nothing: d ~ N(TYPICAL, V),
V = SPREAD^2 1 1' + ALIKE^2 I. Integrated over d, with u = V^-1 TYPICAL, K = C + V^-1 over the rows of m,

    ln L(m) = (B + u)' K^-1 (B + u) / 2 - u' V u / 2 - ln det(V K) / 2

A gain, or a loss smaller than LEAST_LOSS, is nothing to warn of: of d's normal distributions before and after the data
only the part counts in which the mean of the low tyres' d is below ln(1 - LEAST_LOSS), so ln L(m) has the ratio of the
two parts added. The prior of a pattern: each further low tyre costs FURTHER, but all four lose as often as one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled

TYPICAL, SPREAD, ALIKE = -0.18, 0.08, 0.015  # ln pressure: 16 % less, give or take 7, alike to 1.5
LEAST_LOSS = 0.06  # of the pressure
LEAST = math.log1p(-LEAST_LOSS)
FURTHER = 1.0
WIDE = 0.25  # ln pressure
PATTERNS = np.array([[bool(code >> wheel & 1) for wheel in range(4)] for code in range(1, 16)])
_COST = FURTHER * np.array([0.0, 1.0, 2.0, 0.0])
PRIOR = -_COST[PATTERNS.sum(axis=1) - 1] - np.log(15.0)
_NUMBERS = PATTERNS.astype(np.int64)


@dataclass(frozen=True)
class Judgement:
    """statistic: ln of the likelihood ratio of some loss against none, patterns summed over their prior, for the onset
    that explains best; onset: its place in the list; low: probability of each wheel to be low, given some loss, (4,);
    best: the likeliest pattern (4,) bool; certainty: its probability; change, std: ln pressure of each wheel, averaged
    over patterns (4,); unknown: variance of a loss of each wheel from before the first onset that data do not exclude,
    with a prior std of WIDE, (4,)."""

    statistic: float
    onset: int
    low: NDArray[np.float64]
    best: NDArray[np.bool_]
    certainty: float
    change: NDArray[np.float64]
    std: NDArray[np.float64]
    unknown: NDArray[np.float64]


def judge(score: NDArray[np.float64], information: NDArray[np.float64]) -> Judgement:
    """score: (onsets, 4), information: (onsets, 4, 4), at least one onset."""
    evidence, mean, variance = np.empty((len(score), 15)), np.empty((15, 4)), np.empty((15, 4))
    onset = weigh(score, information, _NUMBERS, PRIOR, evidence, mean, variance)
    line = evidence[onset]
    weight = np.exp(line - line.max())
    statistic = float(line.max() + np.log(weight.sum()))
    weight /= weight.sum()
    change = weight @ mean
    spread = np.sqrt(np.maximum(weight @ (variance + mean**2) - change**2, 0.0))
    best = int(np.argmax(weight))
    unknown = np.diag(np.linalg.inv(information[0] + np.eye(4) / WIDE**2))
    return Judgement(statistic, onset, weight @ PATTERNS, PATTERNS[best], float(weight[best]), change, spread, unknown)


@compiled
def weigh(score, information, patterns, prior, evidence, mean, variance):
    """ln L + prior of each onset and pattern into evidence (onsets, 15); of the likeliest onset (returned) the mean and
    variance of each wheel's loss in each pattern, (15, 4), 0 where it is not low."""
    best, highest = 0, -np.inf
    for c in range(score.shape[0]):
        top = -np.inf
        for m in range(15):
            evidence[c, m] = prior[m] + _pattern(score[c], information[c], patterns[m])[0]
            top = max(top, evidence[c, m])
        total = 0.0
        for m in range(15):
            total += np.exp(evidence[c, m] - top)
        if top + np.log(total) > highest:
            best, highest = c, top + np.log(total)
    for m in range(15):
        _, at, spread = _pattern(score[best], information[best], patterns[m])
        for w in range(4):
            mean[m, w], variance[m, w] = at[w], spread[w]
    return best


@compiled
def _pattern(score, information, pattern):
    """ln L of one pattern, and mean and variance of the losses. Gauss elimination on the wheels that are low."""
    size = 0
    wheels = np.empty(4, np.int64)
    for w in range(4):
        if pattern[w]:
            wheels[size] = w
            size += 1
    whole = ALIKE * ALIKE + size * SPREAD * SPREAD
    offset = TYPICAL / whole
    a = np.zeros((size, size + 1 + size))
    for i in range(size):
        for j in range(size):
            a[i, j] = information[wheels[i], wheels[j]] - SPREAD * SPREAD / (ALIKE * ALIKE * whole)
        a[i, i] += 1.0 / (ALIKE * ALIKE)
        a[i, size] = score[wheels[i]] + offset
        a[i, size + 1 + i] = 1.0
    log_det = (size - 1) * np.log(ALIKE * ALIKE) + np.log(whole)
    for k in range(size):
        pivot = a[k, k]
        log_det += np.log(pivot)
        for j in range(a.shape[1]):
            a[k, j] /= pivot
        for i in range(size):
            if i != k:
                factor = a[i, k]
                for j in range(a.shape[1]):
                    a[i, j] -= factor * a[k, j]
    at, spread = np.zeros(4), np.zeros(4)
    value = -0.5 * log_det - 0.5 * size * TYPICAL * offset
    for i in range(size):
        at[wheels[i]] = a[i, size]
        spread[wheels[i]] = a[i, size + 1 + i]
        value += 0.5 * a[i, size] * (score[wheels[i]] + offset)
    mean, variance = 0.0, 0.0
    for i in range(size):
        mean += a[i, size] / size
        for j in range(size):
            variance += a[i, size + 1 + j] / size**2
    before = SPREAD * SPREAD + ALIKE * ALIKE / size
    value += _log_below(mean, variance) - _log_below(TYPICAL, before)
    return value, at, spread


@compiled
def _log_below(mean, variance):
    """ln P(d < LEAST) of a normal d."""
    z = (LEAST - mean) / np.sqrt(variance)
    if z > -6.0:
        return math.log(0.5 * math.erfc(-z / math.sqrt(2.0)))
    return -0.5 * z * z - math.log(-z * math.sqrt(2.0 * math.pi)) - 1.0 / (z * z)
