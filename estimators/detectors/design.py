"""From the change to find and the false alarms allowed to a detector's parameters, for every kind.

shift: change of the mean in units of the residual's standard deviation, > 0 (its sign is in `sides`). arl0: mean
samples between false alarms that is asked for (see `samples_between` for a rate per hour). Each function returns the
detector with the run length that it really has and its delay for that change, present from a reset on. Residuals are
taken as independent and Gaussian; for others see `whitening` and `empirical`. Thresholds are exact (integral equation)
but for the GLR and several local CUSUMs, whose run lengths carry the interval of a simulation. ValueError, in one line
that says what is feasible, for a request that cannot be met.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import ceil, exp, log, sqrt

from scipy.optimize import minimize_scalar

from estimators.detectors.cusum import CusumMean, CusumVariance, variance_drift, variance_run_length
from estimators.detectors.cusum_run_length import ROUGHLY
from estimators.detectors.detector import Detector, RunLength, check_number
from estimators.detectors.ewma import LONGEST_MEMORY, Ewma
from estimators.detectors.glr import LONGEST_WINDOW, Glr
from estimators.detectors.integrator import Integrator
from estimators.detectors.local_cusum import LocalCusum, channel_run_length
from estimators.detectors.threshold import check_run_length, threshold_for

LARGEST_SHIFT = 1e6  # std
PERIODS = (1, 2, 4, 8, 16, 32, 64, 128, 256)  # tried for an integrator
_WEIGHTS = (0.03, 1.0)  # 1 - phi over shift^1.5, between which the quickest GMA is (0.05 to 0.4 as arl0 falls)
_STEPS = 8  # of Newton's method for the GLR
_LEAST_THRESHOLD = 1e-3  # of a local CUSUM, whose statistic is in units of it


@dataclass(frozen=True)
class Design:
    """A detector, its mean run length without the change and with it [samples], and that change [std or S1 / S0]."""

    detector: Detector
    arl0: RunLength
    delay: RunLength
    change: float

    def false_alarms_per_hour(self, rate: float) -> float:
        """When `rate` [Hz] samples come a second and the detector restarts after each alarm."""
        return 3600.0 * rate / self.arl0.mean


def design_cusum_mean(shift: float, arl0: float, sides: str = "upper", drift: float | None = None) -> Design:
    """drift: [std], half the shift if None. Exact."""
    check_number("shift", shift, 0.0, LARGEST_SHIFT, above=True)
    probe = CusumMean(0.5 * shift if drift is None else drift, 0.0, sides)
    h = threshold_for(arl0, lambda t: replace(probe, threshold=t).average_run_length().mean)
    return _shifted(replace(probe, threshold=h), shift)


def design_cusum_variance(before: float, after: float, arl0: float) -> Design:
    """before, after: variances S0 and S1; the drift is theta = sigma*^2 / S0. Exact."""
    drift = variance_drift(before, after)
    change = "increase" if after > before else "decrease"
    rough = partial(variance_run_length, drift=drift, change=change, agree=ROUGHLY)
    h = threshold_for(arl0, partial(variance_run_length, drift=drift, change=change), rough=rough)
    detector, ratio = CusumVariance(drift, h, change), after / before
    delay = detector.average_run_length(std=sqrt(ratio))
    return Design(detector, detector.average_run_length(), delay, ratio)


def design_ewma(shift: float, arl0: float, sides: str = "upper", forgetting: float | None = None) -> Design:
    """forgetting: phi, if None the one with the shortest delay for the shift. Exact."""
    check_number("shift", shift, 0.0, LARGEST_SHIFT, above=True)
    check_run_length(arl0)

    def design(phi: float) -> Design:
        probe = Ewma(phi, 0.0, sides)
        scale = sqrt((1.0 - phi) / (1.0 + phi))
        h = threshold_for(arl0, lambda t: replace(probe, threshold=t).average_run_length().mean, scale)
        return _shifted(replace(probe, threshold=h), shift)

    if forgetting is not None:
        return design(forgetting)
    found = minimize_scalar(
        lambda v: design(1.0 - exp(v)).delay.mean,
        bounds=[log(min(max(c * shift**1.5, 1.0 - LONGEST_MEMORY), 1.0)) for c in _WEIGHTS],
        method="bounded",
        options={"xatol": 0.1},
    )
    return design(min(round(1.0 - exp(float(found.x)), 4), LONGEST_MEMORY))


def design_integrator(shift: float, arl0: float, sides: str = "both", period: int | None = None) -> Design:
    """period: samples (1 is the thesis' AC), if None the one of `PERIODS` with the shortest delay. Exact."""
    check_number("shift", shift, 0.0, LARGEST_SHIFT, above=True)

    def design(n: int) -> Design:
        probe = Integrator(n, 0.0, sides)
        h = threshold_for(arl0, lambda t: replace(probe, threshold=t).average_run_length().mean, sqrt(n))
        return _shifted(replace(probe, threshold=h), shift)

    if period is not None:
        return design(period)
    return min((design(n) for n in PERIODS), key=lambda d: d.delay.mean)


def design_glr(shift: float, arl0: float, sides: str = "both", window: int | None = None) -> Design:
    """window: samples, if None twice what the smallest shift to find, `shift`, takes: 4 ln(arl0) / shift^2.

    By importance sampling (direct simulation for short run lengths).
    """
    check_number("shift", shift, 0.0, LARGEST_SHIFT, above=True)
    check_run_length(arl0)
    if window is None:
        wanted = ceil(4.0 * log(max(arl0, 2.0)) / shift**2)
        if wanted > LONGEST_WINDOW:
            least = sqrt(4.0 * log(arl0) / LONGEST_WINDOW)
            raise ValueError(
                f"shift is {shift:g}, feasible: at least {least:.3g}, or give a window up to {LONGEST_WINDOW}"
            )
        window = wanted
    if arl0 <= (1.0 if sides == "both" else 2.0):  # any sample of the right sign exceeds 0
        return _shifted(Glr(window, 0.0, sides), shift)
    h = log(arl0)
    for _ in range(_STEPS):
        missed = log(arl0 / Glr(window, h, sides).average_run_length().mean)
        h = max(h + missed, 0.5 * h)  # the run length grows about as exp(h)
        if abs(missed) < 1e-3:
            break
    return _shifted(Glr(window, h, sides), shift)


def design_local_cusum(
    shift: float,
    arl0: float,
    limits: tuple[float, ...],
    sides: str = "upper",
    drifts: tuple[float, ...] | None = None,
) -> Design:
    """limits: of the channels [std], inf for the global one. drifts: half the shift each if None.

    Every channel gets the same run length. One channel is exact; several share arl0 by a ratio that is simulated.
    """
    check_number("shift", shift, 0.0, LARGEST_SHIFT, above=True)
    check_run_length(arl0)
    drifts = (0.5 * shift,) * len(limits) if drifts is None else drifts
    LocalCusum(limits, drifts, (1.0,) * len(limits), sides)  # refuses what makes no sense

    def with_each(length: float) -> LocalCusum:
        thresholds = []
        for limit, drift in zip(limits, drifts, strict=True):
            exact = partial(channel_run_length, limit=limit, drift=drift, sides=sides)
            thresholds.append(threshold_for(length, exact, rough=partial(exact, agree=ROUGHLY)))
        return LocalCusum(limits, drifts, tuple(max(h, _LEAST_THRESHOLD) for h in thresholds), sides)

    channels = len(limits)
    detector = with_each(arl0)
    if channels > 1:
        trial = with_each(channels * arl0)
        share = trial.average_run_length().mean / trial.bounds()[0]
        detector = with_each(max(arl0, channels * arl0 / share))
    return _shifted(detector, shift)


def _shifted(detector: Detector, shift: float) -> Design:
    """With its run lengths; a lower side is shown a fall."""
    towards = -shift if detector.sides == "lower" else shift
    return Design(detector, detector.average_run_length(), detector.average_run_length(towards), shift)
