"""The threshold at which a run length that rises with it reaches the one asked for.

The run length of every kind grows about exponentially with its threshold, so the search is for the zero of its
logarithm. Where no threshold at all (h = 0) already gives more than asked, h = 0 is the answer, never less.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from math import isfinite, log

from scipy.linalg import LinAlgError, LinAlgWarning
from scipy.optimize import brentq

from estimators.detectors.cusum_run_length import LONGEST

_UNRESOLVED = 1e4 * LONGEST  # stands for run lengths too long to be computed


def check_run_length(arl0: float) -> None:
    """ValueError unless it can be designed for."""
    if not (isfinite(arl0) and 1.0 <= arl0 <= LONGEST):
        raise ValueError(f"mean run length between false alarms is {arl0:g} samples, feasible: 1 to {LONGEST:g}")


def threshold_for(arl0: float, run_length: Callable[[float], float], step: float = 1.0) -> float:
    """The least h >= 0 whose run length [samples] is arl0, to 1e-6 of h; 0 where that gives more. step: scale of h.

    ValueError if arl0 is not feasible.
    """
    check_run_length(arl0)

    def excess(h: float) -> float:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", LinAlgWarning)
                length = run_length(h)
        except (ArithmeticError, LinAlgError):
            length = _UNRESOLVED
        return log(length if 1.0 <= length < _UNRESOLVED else _UNRESOLVED) - log(arl0)

    if run_length(0.0) >= arl0:
        return 0.0
    low, high = 0.0, step
    while excess(high) < 0.0:
        low, high = high, 1.5 * high + step
    return float(brentq(excess, low, high, xtol=1e-9 * step, rtol=1e-6))


def samples_between(false_alarms_per_hour: float, rate: float) -> float:
    """Mean run length [samples] that means so many false alarms per hour when `rate` [Hz] samples come a second."""
    for name, value in (("rate", rate), ("false alarms per hour", false_alarms_per_hour)):
        if not (isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value:g}, valid: a number above 0")
    most = 3600.0 * rate
    if false_alarms_per_hour > most:
        raise ValueError(
            f"false alarms per hour is {false_alarms_per_hour:g}, feasible at {rate:g} Hz: at most {most:g}"
        )
    return most / false_alarms_per_hour
