"""Whittle fit of one damped mode to an averaged spectrum: natural frequency, damping, road input and noise together.

One-sided power spectral density of the wheel speed at f, with x = f / f0 and u = ln(f / reference):

    S(f) = exp(c0 + c1 u + c2 u^2) / ((1 - x^2)^2 + (2 zeta x)^2) + exp(w) g(f) + exp(t) f^2

f0: undamped natural frequency [Hz]; zeta: damping ratio. The polynomial is what the road puts in and the other modes
pass, w a floor [(rad/s)^2/Hz] that is white in the samples, g what correcting their droop makes of it (1 if nothing was
corrected), t that of the edges' timer, white in time, so growing with f^2; both are also told
by lines above every mode, in which S has no first term. Averaged periodograms P of weight n (in independent ones) have
the ln likelihood -sum n (ln S + P / S) (Whittle 1953), so nothing needs to be smoothed, and the floor is in the model
instead of in the frequency. Gaussian priors on the parameters (below) keep what a short or quiet record does not tell
where it was. Maximum by Fisher scoring with Levenberg's damping; the inverse of the information matrix at the maximum
is the covariance: the Cramer-Rao bound of this model.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled

FREQUENCY, DAMPING, LEVEL, SLOPE, BEND, WHITE, TIMER = range(7)  # ln f0, ln zeta, c0, c1, c2, w, t
SIZE = 7
_ROUNDS = 60
_STEP = 1e-6  # of a change that counts, in standard deviations' squares


@compiled
def density(p, reference, f, within, white_shape, signal, total, slopes):
    """Fills signal and total PSD, and d ln S / d p, at f [Hz], shape (n,); slopes shape (n, 7). p: shape (7,). within:
    shape (n,), 0 for a line of noise alone. white_shape: g, shape (n,)."""
    f0, zeta = math.exp(p[FREQUENCY]), math.exp(p[DAMPING])
    white, timer = math.exp(p[WHITE]), math.exp(p[TIMER])
    for i in range(f.size):
        x2, u = (f[i] / f0) ** 2, math.log(f[i] / reference)
        damped = 4.0 * zeta * zeta * x2
        nearness = (1.0 - x2) ** 2 + damped
        mode = within[i] * math.exp(p[LEVEL] + u * (p[SLOPE] + u * p[BEND])) / nearness
        floor = white * white_shape[i]
        s = mode + floor + timer * f[i] * f[i]
        share = mode / s
        signal[i], total[i] = mode, s
        slopes[i, FREQUENCY] = share * (2.0 * damped - 4.0 * x2 * (1.0 - x2)) / nearness
        slopes[i, DAMPING] = -share * 2.0 * damped / nearness
        slopes[i, LEVEL], slopes[i, SLOPE], slopes[i, BEND] = share, share * u, share * u * u
        slopes[i, WHITE], slopes[i, TIMER] = floor / s, timer * f[i] * f[i] / s


@compiled
def _value(p, total, power, weight, mean, precision):
    """ln posterior density."""
    value = 0.0
    for i in range(power.size):
        value -= weight[i] * (math.log(total[i]) + power[i] / total[i])
    for a in range(p.size):
        value -= 0.5 * precision[a] * (p[a] - mean[a]) ** 2
    return value


@compiled
def fit(p, reference, f, within, white_shape, power, weight, mean, precision, information):
    """Moves p, shape (7,), to the maximum; fills the posterior information, shape (7, 7). Returns the rounds taken.

    f [Hz], within, white_shape, power, weight: shape (n,), weight 0 for a line that is not used. mean, precision: of
    the priors, shape (7,).
    """
    n, size = f.size, p.size
    signal, total, slopes = np.empty(n), np.empty(n), np.empty((n, size))
    trial_signal, trial_total, trial_slopes = np.empty(n), np.empty(n), np.empty((n, size))
    density(p, reference, f, within, white_shape, signal, total, slopes)
    value, damping, rounds = _value(p, total, power, weight, mean, precision), 1e-3, 0
    score = np.empty(size)
    while rounds < _ROUNDS:
        rounds += 1
        for a in range(size):
            score[a] = -precision[a] * (p[a] - mean[a])
            for b in range(size):
                information[a, b] = precision[a] if a == b else 0.0
        for i in range(n):
            if weight[i] == 0.0:
                continue
            surprise = weight[i] * (power[i] / total[i] - 1.0)
            for a in range(size):
                score[a] += surprise * slopes[i, a]
                for b in range(a + 1):
                    information[a, b] += weight[i] * slopes[i, a] * slopes[i, b]
        for a in range(size):
            for b in range(a):
                information[b, a] = information[a, b]
        damped = information.copy()
        for a in range(size):
            damped[a, a] += damping * information[a, a]
        step = np.linalg.solve(damped, score)
        gain = 0.0
        for a in range(size):
            gain += step[a] * score[a]
        trial = p + step
        density(trial, reference, f, within, white_shape, trial_signal, trial_total, trial_slopes)
        better = _value(trial, trial_total, power, weight, mean, precision)
        if better >= value:
            p[:], value = trial, better
            signal, trial_signal = trial_signal, signal
            total, trial_total = trial_total, total
            slopes, trial_slopes = trial_slopes, slopes
            damping *= 0.1
        else:
            damping = max(10.0 * damping, 1e-6)
        if gain < _STEP or damping > 1e9:
            break
    return rounds
