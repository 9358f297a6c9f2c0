"""Recursive AR(2) of band-passed wheel speed (SAE 2002-01-1250, Figure 3), and the three maps to a frequency.

    y_t = -a1 y_{t-1} - a2 y_{t-2} + e_t        (the paper prints the filter without its input e_t)

The poles are r exp(+-i theta), r = sqrt(a2), cos theta = -a1 / (2 r). A "resonance" can mean
    pole angle      theta
    natural         |ln(pole)| = sqrt(theta^2 + ln(r)^2), undamped natural frequency: the one used here, as it is the
                    one that stiffness and inertia give and that `spectral_fit` reports
    spectral peak   cos(omega) = -a1 (1 + a2) / (4 a2), if there is one
each times rate / 2 pi. Least squares with forgetting (RLS) and a Kalman filter whose parameters walk at random are the
same recursion with other numbers. Both assume that y is measured without noise: white noise added to it makes the poles
shrink and turn (errors in variables), so the frequency moves with the signal-to-noise, more than with the pressure.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled

MEMORY = 30.0  # s, declared: the paper's batch
VAGUE = 1e3  # prior variance of a1, a2


def pole_angle(a1: float, a2: float, rate: float) -> float:
    """[Hz]; nan for real poles."""
    return _turns(math.acos(-a1 / (2.0 * math.sqrt(a2))), rate) if _complex(a1, a2) else math.nan


def natural_frequency(a1: float, a2: float, rate: float) -> float:
    """[Hz]; nan for real poles."""
    if not _complex(a1, a2):
        return math.nan
    return _turns(math.hypot(math.acos(-a1 / (2.0 * math.sqrt(a2))), 0.5 * math.log(a2)), rate)


def spectral_peak(a1: float, a2: float, rate: float) -> float:
    """[Hz]; nan where the spectrum has no peak."""
    cosine = -a1 * (1.0 + a2) / (4.0 * a2) if a2 > 0.0 else math.nan
    return _turns(math.acos(cosine), rate) if abs(cosine) <= 1.0 and _complex(a1, a2) else math.nan


def coefficients(frequency: float, damping: float, rate: float) -> tuple[float, float]:
    """(a1, a2) of the sampled mode with this natural frequency [Hz] and damping ratio below 1."""
    omega = 2.0 * math.pi * frequency / rate
    r = math.exp(-damping * omega)
    return -2.0 * r * math.cos(omega * math.sqrt(1.0 - damping**2)), r * r


def _complex(a1: float, a2: float) -> bool:
    return a2 > 0.0 and a1 * a1 < 4.0 * a2


def _turns(angle: float, rate: float) -> float:
    return rate * angle / (2.0 * math.pi)


@compiled
def recursion(signal, forgetting, noise, walk, vague, out):
    """a1, a2 after each sample into out, shape (n, 2).

    P <- (P - K phi' P) / forgetting + walk I, K = P phi / (noise + phi' P phi). Least squares: noise = forgetting,
    walk 0. Kalman: forgetting 1, noise the variance of e, walk that of a step of a1, a2. vague: P at the start.
    """
    a1, a2, p11, p12, p22 = 0.0, 0.0, vague, 0.0, vague
    for t in range(signal.size):
        if t > 1:
            f1, f2 = -signal[t - 1], -signal[t - 2]
            g1, g2 = p11 * f1 + p12 * f2, p12 * f1 + p22 * f2
            s = noise + f1 * g1 + f2 * g2
            e = signal[t] - a1 * f1 - a2 * f2
            a1 += g1 * e / s
            a2 += g2 * e / s
            p11 = (p11 - g1 * g1 / s) / forgetting + walk
            p12 = (p12 - g1 * g2 / s) / forgetting
            p22 = (p22 - g2 * g2 / s) / forgetting + walk
        out[t, 0], out[t, 1] = a1, a2


def least_squares(signal: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """(a1, a2) over time by RLS that forgets with MEMORY, shape (n, 2). signal: shape (n,), sampled at `rate` [Hz]."""
    out = np.empty((len(signal), 2))
    forgetting = math.exp(-1.0 / (MEMORY * rate))
    recursion(signal / np.std(signal), forgetting, forgetting, 0.0, VAGUE, out)
    return out


def kalman(signal: NDArray[np.float64], rate: float, innovation: float) -> NDArray[np.float64]:
    """(a1, a2) over time, shape (n, 2), by a Kalman filter whose steady gain forgets with MEMORY. innovation: variance
    of e over that of the signal."""
    out = np.empty((len(signal), 2))
    walk = innovation / (MEMORY * rate) ** 2  # of a scalar regressor with unit variance: gain = sqrt(walk / innovation)
    recursion(signal / np.std(signal), 1.0, innovation, walk, VAGUE, out)
    return out
