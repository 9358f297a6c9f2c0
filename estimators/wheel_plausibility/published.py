"""The thesis' detectors of erroneous wheel speeds: Wheel-to-Wheel A and B, Average, and its advice Average with B.

Razavi, Lund 2006, sections 6.1 and 6.3 (seed 004). Speeds in km/h through a low pass, residuals (`residuals`), a CUSUM
g <- max(g + (eps - nu) dt, 0) on each, an alarm above h [km/h s]. The thesis prints no nu, h or filter; those here
follow from its detection times t of constant errors theta: t = tau + h / (theta - nu) fits Table 6.4's diagonal within
5 % from 1 to 50 km/h, its single wheels and Table 6.3 within about a third.

    A              13 patterns of the six alarms: one wheel, a pair against a pair, two wheels of their own
    B              a wheel of which two of the three pairs have alarmed
    average        the first of the four single averages to alarm; `diagonal` only says that something is wrong
    average_and_b  average or B, whichever is first

What is accused stays so for a time t, then all sums begin anew (re-check). B and average see single wheels: with two
in error they name the worse one, or a sound one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from estimators.compiled import compiled
from estimators.wheel_plausibility.residuals import AVERAGES, PAIRS, averages, wheel_to_wheel

METHODS = ("A", "B", "average", "average_and_b")
TAU = 0.15  # s of the low pass
PAIR_DRIFT, PAIR_LEVEL = 3.5, 39.0  # km/h, km/h s; Table 6.3
WHEEL_DRIFT, WHEEL_LEVEL = 1.2, 58.0  # Table 6.4, eps_1 to eps_4, and front_back and sides
DIAGONAL_DRIFT, DIAGONAL_LEVEL = 0.3, 5.3  # Table 6.4
RECHECK = 2.0  # s, the thesis' t. Declared: it names none
DIAGONAL = AVERAGES.index("diagonal")


def _patterns() -> NDArray[np.bool_]:
    """Alarms of the PAIRS for each status 1 to 13, shape (13, 6)."""
    rows = [[wheel in pair for pair in PAIRS] for wheel in range(4)]
    for together in ((0, 1), (0, 2), (0, 3)):  # a pair against the other pair
        rows.append([(i in together) != (j in together) for i, j in PAIRS])
    for both in PAIRS:  # two wheels, each unlike all others
        rows.append([i in both or j in both for i, j in PAIRS])
    return np.array(rows)


PATTERNS = _patterns()
ACCUSED = np.zeros((14, 4), dtype=np.bool_)  # of each status; a pair against a pair accuses nobody
for _status in range(4):
    ACCUSED[1 + _status, _status] = True
for _status, _both in enumerate(PAIRS):
    ACCUSED[8 + _status, list(_both)] = True


@dataclass(frozen=True)
class Verdicts:
    """accused: shape (n, 4), fl fr rl rr; status: of method A, 0 to 13, else 0, shape (n,); diagonal: its alarm."""

    accused: NDArray[np.bool_]
    status: NDArray[np.int64]
    diagonal: NDArray[np.bool_]


@compiled
def _summed(x, drift, level, step, pairs, patterns, kind, held, accused, status):
    """Walks the residuals x (n, m); kind: 0 A, 1 B, 2 average, 3 average and B. held: samples of RECHECK."""
    g = np.zeros(x.shape[1])
    until = -1
    for k in range(x.shape[0]):
        if k == until:
            g[:] = 0.0
        for j in range(len(g)):
            if np.isfinite(x[k, j]):
                g[j] = max(g[j] + (x[k, j] - drift[j]) * step, 0.0)
        if k < until:
            accused[k] = accused[k - 1]
            status[k] = status[k - 1]
            continue
        if kind == 0:
            for s in range(len(patterns)):
                same = True
                for j in range(6):
                    same = same and (g[j] > level[j]) == patterns[s, j]
                if same:
                    status[k] = s + 1
        else:
            best, worst = -1, 0.0
            for wheel in range(4):
                over, total = 0, 0.0
                if kind != 2:
                    for j in range(6):
                        if (pairs[j, 0] == wheel or pairs[j, 1] == wheel) and g[j] > level[j]:
                            over += 1
                            total += g[j] / level[j]
                single = kind != 1 and g[6 + wheel] > level[6 + wheel]
                if single:
                    total += g[6 + wheel] / level[6 + wheel]
                if (over >= 2 or single) and total > worst:
                    best, worst = wheel, total
            if best >= 0:
                accused[k, best] = True
        if status[k] > 0 or accused[k].any():
            until = k + held


def published(method: str, speed_kmh: ArrayLike, step: float, recheck: float = RECHECK) -> Verdicts:
    """What a method says of wheel speeds [km/h], shape (n, 4), every `step` [s], NaN where missing; divided by a
    geometry's factors if one is used. ValueError for an unknown method."""
    if method not in METHODS:
        raise ValueError(f"method is {method!r}, valid: {', '.join(METHODS)}")
    v = _low_pass(np.asarray(speed_kmh, float), step)
    x = np.hstack([wheel_to_wheel(v), averages(v)])
    drift = np.repeat([PAIR_DRIFT, WHEEL_DRIFT, DIAGONAL_DRIFT], [6, 6, 1])
    level = np.repeat([PAIR_LEVEL, WHEEL_LEVEL, DIAGONAL_LEVEL], [6, 6, 1])
    accused = np.zeros((len(v), 4), dtype=np.bool_)
    status = np.zeros(len(v), dtype=np.int64)
    held = max(round(recheck / step), 1)
    _summed(x, drift, level, step, np.array(PAIRS), PATTERNS, METHODS.index(method), held, accused, status)
    g = _single_sum(np.ascontiguousarray(x[:, 6 + DIAGONAL]), DIAGONAL_DRIFT, step)
    return Verdicts(accused | ACCUSED[status], status, g > DIAGONAL_LEVEL)


@compiled
def _single_sum(x, drift, step):
    g = np.zeros(len(x))
    last = 0.0
    for k in range(len(x)):
        if np.isfinite(x[k]):
            last = max(last + (x[k] - drift) * step, 0.0)
        g[k] = last
    return g


def _low_pass(v: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """First order, TAU; begun at the first sample."""
    out = np.empty_like(v)
    _filtered(v, step / (TAU + step), out)
    return out


@compiled
def _filtered(v, share, out):
    last = v[0].copy()
    for k in range(v.shape[0]):
        for i in range(v.shape[1]):
            if not np.isfinite(last[i]):
                last[i] = v[k, i]
            elif np.isfinite(v[k, i]):
                last[i] += share * (v[k, i] - last[i])
        out[k] = last
