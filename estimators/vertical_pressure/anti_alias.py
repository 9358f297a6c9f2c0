"""From 1 kHz to 62.5 Hz: a steep low-pass at 28 Hz, a slow high-pass, every sixteenth sample.

Elliptic low-pass of order 5 (0.1 dB ripple to 28 Hz, 45 dB down from 45 Hz). The edge stands close to half the new
rate on purpose: noise that the filters believe to be white must not have an empty band (at 100 Hz with this edge, 44
% of the band held nothing, and k_t came out 30 % high). Above 28 Hz there is little to learn: the bound for unknown
road level is 5.59 % after 10 s with 28 Hz, 5.49 % with 36, 5.44 % with 50, while footprint and belt are known the
less the shorter the waves. A first-order high-pass at 0.25 Hz takes gravity, bias and slopes of the road out. Both
run at the sensors' rate and are begun at rest, under gravity alone: begun on the first sample, what the road did in
that instant would take seconds to be forgotten, and look like a soft tyre on a rough road. `analogue` is the low-pass
as the filters' model has it; the discrete one is its bilinear image, prewarped at its edge. The high-pass is in the
model's road (`chain`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bilinear_zpk, ellip, zpk2sos, zpk2ss

from estimators.car import GRAVITY
from estimators.compiled import compiled

RATE = 1000  # Hz of the sensors
EVERY = 16
STEP = EVERY / RATE  # s of a decimated sample
_ORDER, _RIPPLE, _DOWN, _EDGE = 5, 0.1, 45.0, 28.0  # dB, dB, Hz
HIGH_PASS = 0.25  # Hz
_KEEPS = math.exp(-2.0 * math.pi * HIGH_PASS / RATE)


def _analogue() -> tuple[NDArray, NDArray, float]:
    warped = 2.0 * RATE * math.tan(math.pi * _EDGE / RATE)
    z, p, k = ellip(_ORDER, _RIPPLE, _DOWN, warped, analog=True, output="zpk")
    return z, p, float(k)


def analogue() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The low-pass as dx/dt = A x + B u, y = C x: A (5, 5), B (5,), C (5,); balanced in scale."""
    A, B, C, _ = zpk2ss(*_analogue())
    scale = (2.0 * math.pi * _EDGE) ** -np.arange(1.0, _ORDER + 1.0)  # each state is the integral of the one before
    A, B, C = A * scale[None, :] / scale[:, None], B[:, 0] / scale, C[0] * scale
    return np.ascontiguousarray(A), np.ascontiguousarray(B), np.ascontiguousarray(C)


def sections() -> NDArray[np.float64]:
    """The low-pass at RATE as second-order sections, (3, 6)."""
    return np.ascontiguousarray(zpk2sos(*bilinear_zpk(*_analogue(), RATE)))


@compiled
def decimate(sos, value, phase, begun, level, memory, out):
    """Filters value (n, channels), writes each tenth sample to out (m, channels); m.

    phase (1,): samples since the last one kept; begun (channels,): 0 before the first sample; level (channels,):
    high-pass state; memory (channels, sections, 2): of the sections. All move on.
    """
    taken = 0
    for t in range(value.shape[0]):
        phase[0] += 1
        keep = phase[0] == EVERY
        if keep:
            phase[0] = 0
        for c in range(value.shape[1]):
            x = value[t, c]
            if begun[c] == 0.0:
                begun[c], level[c] = 1.0, GRAVITY
            level[c] = _KEEPS * level[c] + (1.0 - _KEEPS) * x
            y = x - level[c]
            for s in range(sos.shape[0]):
                u = y
                y = sos[s, 0] * u + memory[c, s, 0]
                memory[c, s, 0] = sos[s, 1] * u - sos[s, 4] * y + memory[c, s, 1]
                memory[c, s, 1] = sos[s, 2] * u - sos[s, 5] * y
            if keep:
                out[taken, c] = y
        if keep:
            taken += 1
    return taken
