"""The threshold at which a run length that rises with it reaches the one asked for.

The run length of every kind grows about exponentially with its threshold, so the search is for the zero of its
logarithm. Where no threshold at all (h = 0) already gives more than asked, h = 0 is the answer, never less.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, log

from scipy.optimize import brentq

LONGEST = 1e12  # samples that are designed for
UNRESOLVED = 100.0  # of ln(run length / arl0): far beyond what was asked for
_CORRECTIONS = 6
_CLOSE, _REFUSED = 1e-3, 0.05  # of ln(run length / arl0): good enough, and not resolved


def check_run_length(arl0: float) -> None:
    """ValueError unless it can be designed for."""
    if not (isfinite(arl0) and 1.0 <= arl0 <= LONGEST):
        raise ValueError(f"mean run length between false alarms is {arl0:g} samples, feasible: 1 to {LONGEST:g}")


def threshold_for(
    arl0: float,
    run_length: Callable[[float], float],
    step: float = 1.0,
    rough: Callable[[float], float] | None = None,
) -> float:
    """The least h >= 0 whose run length [samples] is arl0, to 1e-3 of the run length; 0 where that gives more.

    step: scale of h. rough: a cheaper, less accurate run_length to start with. Both may raise ArithmeticError where
    they cannot be resolved. ValueError if arl0 is not feasible, or so long that it cannot be resolved.
    """
    check_run_length(arl0)
    if run_length(0.0) >= arl0:
        return 0.0
    excess, exact = _log_excess(rough or run_length, arl0), _log_excess(run_length, arl0)
    low, high = 0.0, step
    while excess(high) < 0.0:
        low, high = high, 1.5 * high + step
    h = float(brentq(excess, low, high, xtol=1e-9 * step, rtol=1e-6))
    if rough is not None:
        slope = (excess(1.02 * h) - excess(h)) / (0.02 * h)
        for _ in range(_CORRECTIONS):
            missed = exact(h)
            if missed >= UNRESOLVED:
                break
            h = max(h - missed / slope, 0.5 * h)
            if abs(missed) < _CLOSE:  # what is left is of the order of its square
                break
    if abs(exact(h)) > _REFUSED:
        raise ValueError(
            f"mean run length between false alarms is {arl0:g} samples, feasible for this change (what is longer is "
            f"not resolved): {_feasible(run_length, arl0, h):.2g}"
        )
    return h


def _feasible(run_length: Callable[[float], float], arl0: float, h: float) -> float:
    """A run length below arl0 that is resolved, at a threshold below h: half of arl0, if not less and less."""
    step = log(2.0) / log(arl0)  # the logarithm of the run length grows about as h
    while True:
        h, step = (1.0 - step) * h, min(1.5 * step, 0.5)
        try:
            length = run_length(h)
        except ArithmeticError:
            continue
        if length < arl0:
            return length


def _log_excess(run_length: Callable[[float], float], arl0: float) -> Callable[[float], float]:
    """ln(run length / arl0) as a function of h; at least UNRESOLVED where it cannot be resolved."""

    def excess(h: float) -> float:
        try:
            return log(max(run_length(h), 1.0)) - log(arl0)
        except ArithmeticError:
            return UNRESOLVED + h

    return excess


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
