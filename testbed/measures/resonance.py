"""Natural frequency of a damped resonance from a spectrum: a fitted form, not the highest line, which on a broad peak
is noise.

Form of the power spectral density, f0 the undamped natural frequency and d the damping ratio of each resonance:

    S(f) = A N(f) / prod [(f0^2 - f^2)^2 + (2 d f0 f)^2]

N is what excites and passes: see the two functions. The fit is least squares in ln S of a Welch spectrum (Hann, half
overlapped), whose error is equal at all frequencies; the standard deviation of f0 comes from its Jacobian and its
residual, times OVERLAP for lines that are not independent. A form that does not fit so tells on itself by its std.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import welch

Array = NDArray[np.float64]

OVERLAP = 1.5**0.5  # a Hann window spreads a line over 1.5 lines (its equivalent noise bandwidth)
EVALUATIONS = 300
HOP_LINE, HOP_BAND = 0.5, (5.0, 20.0)  # Hz: width of a line of the spectrum, band of the fit
ROTATION_LINE, ROTATION_BAND = 1.0, (28.0, 100.0)
LEAST_DAMPED = 0.02
SHARPEST, BROADEST = 1.0, 0.6  # damping ratios beyond which no peak is left: of the hop, of the rotation


@dataclass(frozen=True)
class Resonance:
    """frequency: f0 [Hz]; std: of it [Hz]; damping: ratio [-]."""

    frequency: float
    std: float
    damping: float


def _log_resonance(f: Array, f0: float, damping: float) -> Array:
    return -np.log((f0**2 - f**2) ** 2 + (2.0 * damping * f0 * f) ** 2)


def _spectrum(signals: Sequence[Array], rate: float, line: float, band: tuple[float, float]) -> tuple[Array, Array]:
    """Frequencies [Hz] in the band and ln of the mean spectrum of signals, less its mean."""
    spectra = [welch(signal, rate, nperseg=round(rate / line)) for signal in signals]
    f = spectra[0][0]
    inside = (f >= band[0]) & (f <= band[1])
    level = np.log(np.mean([power for _, power in spectra], axis=0)[inside])
    return f[inside], level - level.mean()


def _fitted(
    form: Callable[[Array], Array], level: Array, starts: Sequence[Sequence[float]], low: Sequence[float],
    high: Sequence[float],
) -> tuple[Array, Array]:  # fmt: skip
    """Parameters of the form nearest to the level, and their standard deviations."""
    fits = [
        least_squares(lambda p: form(p) - level, start, bounds=(low, high), max_nfev=EVALUATIONS, x_scale="jac")
        for start in starts
    ]
    best = min(fits, key=lambda fit: fit.cost)
    variance = 2.0 * best.cost / max(len(level) - len(best.x), 1)
    spread = np.sqrt(np.diag(np.linalg.pinv(best.jac.T @ best.jac)) * variance)
    return best.x, OVERLAP * spread


def wheel_hop(left: Array, right: Array, rate: float) -> Resonance:
    """Wheel hop of an axle from its hubs' vertical accelerations [m/s^2], shape (n,) each, at `rate` [Hz].

    Their sum moves in heave alone. The velocity of an ISO 8608 road is white at constant speed, so N =
    f^2 exp(-b^2 f^2), b for what the contact's length smooths.
    """
    f, level = _spectrum([left + right], rate, HOP_LINE, HOP_BAND)

    def form(p: Array) -> Array:
        return p[0] + 2.0 * np.log(f) + _log_resonance(f, p[1], p[2]) - (p[3] * f) ** 2

    start = [np.log(11.0**2), 11.0, 0.3, 0.03]
    p, std = _fitted(form, level, [start], [-50.0, 5.0, LEAST_DAMPED, 0.0], [50.0, 20.0, SHARPEST, 0.2])
    return Resonance(float(p[1]), float(std[1]), float(p[2]))


def rotation(left: Array, right: Array, rate: float) -> tuple[Resonance, Resonance]:
    """In-phase and antiphase rotation of rim and belt of an axle from its wheel speeds [rad/s], shape (n,) each, at
    `rate` [Hz].

    Both are fitted together to the spectrum of the derivative. N = e^a + e^b u + u^2 with u = (f/50 Hz)^2: road height
    excites through the load and road slope directly, with other powers of f. Slip damps the in-phase mode the more the
    faster the car (0.12 at 30 km/h, 0.27 at 80): there its std says that the spectrum does not hold it.
    """
    f, level = _spectrum([np.gradient(w, 1.0 / rate) for w in (left, right)], rate, ROTATION_LINE, ROTATION_BAND)
    u = (f / 50.0) ** 2

    def form(p: Array) -> Array:
        smooth = np.log(np.exp(p[5]) + np.exp(p[6]) * u + u**2)
        return p[0] + smooth + _log_resonance(f / 50.0, p[1] / 50.0, p[2]) + _log_resonance(f / 50.0, p[3] / 50.0, p[4])

    starts = [[-3.0, 38.0, 0.15, second, 0.07, n, n] for second, n in ((80.0, 0.0), (72.0, -2.0))]
    low = [-30.0, 28.0, LEAST_DAMPED, 62.0, LEAST_DAMPED, -12.0, -12.0]
    p, std = _fitted(form, level, starts, low, [30.0, 55.0, BROADEST, 100.0, 0.3, 12.0, 12.0])
    return Resonance(float(p[1]), float(std[1]), float(p[2])), Resonance(float(p[3]), float(std[3]), float(p[4]))
