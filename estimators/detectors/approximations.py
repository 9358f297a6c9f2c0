"""Wald's and Siegmund's approximations of the run length of a one-sided CUSUM (thesis 2.14, 2.15), for comparison.

mu = mean of the residual minus drift, sigma its standard deviation; alarm if g > h.
    Wald       L = (exp(-2 h mu / sigma^2) - 1 + 2 h mu / sigma^2) / (2 mu^2 / sigma^2)
    Siegmund   the same with h / sigma + 1.166 for h / sigma; (h / sigma + 1.166)^2 where mu = 0
Neither is used for a design: Wald ignores the overshoot, and both fail where h is not large against sigma.
"""

from __future__ import annotations

from math import expm1

from scipy.optimize import brentq

OVERSHOOT = 1.166  # [sigma] mean overshoot of a Gaussian walk over both boundaries


def wald_run_length(threshold: float, drift: float, mean: float = 0.0, std: float = 1.0) -> float:
    """Samples to the alarm."""
    return _brownian(threshold / std, (mean - drift) / std)


def siegmund_run_length(threshold: float, drift: float, mean: float = 0.0, std: float = 1.0) -> float:
    """Samples to the alarm."""
    return _brownian(threshold / std + OVERSHOOT, (mean - drift) / std)


def _brownian(h: float, mu: float) -> float:
    """Mean first passage of a Brownian motion with drift mu, reflected at 0, over h (unit variance)."""
    a = 2.0 * h * mu
    if abs(a) < 1e-6:
        return h * h
    if a < -700.0:
        return float("inf")
    return (expm1(-a) + a) / (2.0 * mu * mu)


def siegmund_threshold(drift: float, arl0: float, std: float = 1.0) -> float:
    """The threshold that Siegmund's formula gives for arl0 [samples]; the thesis' (2.16). Negative where it fails."""
    most = 1.0
    while _brownian(most, -drift / std) < arl0:
        most *= 2.0
    return std * (float(brentq(lambda h: _brownian(h, -drift / std) - arl0, 0.0, most, xtol=1e-12)) - OVERSHOOT)
