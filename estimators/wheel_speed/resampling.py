"""Wheel speed on an even clock from angles known at uneven times, without aliasing.

The angle is known exactly at the edges. Between them it is taken as linear, so the speed is constant from edge to edge;
that speed, as a function of continuous time, is convolved with a smooth low-pass h and read at t_k = k / RATE:

    y_k = sum over intervals of w_m [H(t_{m+1} - t_k) - H(t_m - t_k)],   w_m = (phi_{m+1} - phi_m) / (t_{m+1} - t_m)

with H the integral of h: no sample is taken before the filter, so the output clock aliases nothing but what h lets
through above RATE / 2: at least STOP_DB below. h is a sinc in a Kaiser window, 6 dB down at CUTOFF, flat to PASS and
stopped from STOP on, cut at +-REACH seconds. What the teeth themselves sample stays: motion above half the tooth rate
appears below it, as with every edge sensor, so a spectrum is used up to USABLE of the tooth rate. The linear angle
costs a known (sin(pi f / f_teeth) / (pi f / f_teeth))^2 of the amplitude, see `droop`.
"""

from __future__ import annotations

import math

import numpy as np

from estimators.compiled import compiled

RATE = 400.0  # Hz
PASS, STOP = 165.0, 235.0  # Hz
CUTOFF = 0.5 * (PASS + STOP)
STOP_DB = 75.0
USABLE = 0.45  # of the tooth rate
_BETA = 0.1102 * (STOP_DB + 3.0 - 8.7)
REACH = math.ceil(1e4 * 0.5 * (STOP_DB + 3.0 - 7.95) / (2.285 * 2.0 * math.pi * (STOP - PASS))) / 1e4  # s
_TABLE = 20000  # steps of the table of H over 2 REACH; linear in between


def _integral() -> np.ndarray:
    """H at -REACH + i 2 REACH / _TABLE, from 0 to 1."""
    edge = np.linspace(-REACH, REACH, _TABLE + 1)
    centre = 0.5 * (edge[:-1] + edge[1:])
    h = np.sinc(2.0 * CUTOFF * centre) * np.i0(_BETA * np.sqrt(1.0 - (centre / REACH) ** 2))
    return np.concatenate([[0.0], np.cumsum(h) / h.sum()])


INTEGRAL = _integral()


@compiled
def _read(table, x):
    """H at x [s]."""
    place = (x + REACH) * (table.size - 1) / (2.0 * REACH)
    if place <= 0.0:
        return 0.0
    if place >= table.size - 1:
        return 1.0
    i = int(place)
    return table[i] + (place - i) * (table[i + 1] - table[i])


@compiled
def resample(time, angle, whole, first, out, table):
    """Speed [rad/s] at (first + i) / RATE into out, shape (n,); NaN where the filter reaches over a break or an end.

    time [s], angle [rad]: edges in order, shape (m,). whole: shape (m,), 0 where the way from the edge before is not
    known. table: INTEGRAL.
    """
    start = 0
    for i in range(out.size):
        t = (first + i) / RATE
        while start + 1 < time.size and time[start + 1] <= t - REACH:
            start += 1
        out[i] = math.nan
        if start >= time.size or time[start] > t - REACH:
            continue
        low, total, m = 0.0, 0.0, start
        while m + 1 < time.size and time[m] < t + REACH:
            m += 1
            if whole[m] == 0:
                break
            high = _read(table, time[m] - t)
            total += (angle[m] - angle[m - 1]) / (time[m] - time[m - 1]) * (high - low)
            low = high
        if time[m] >= t + REACH and whole[m] != 0:
            out[i] = total


def droop(frequency: np.ndarray, tooth_rate: float) -> np.ndarray:
    """Amplitude at `frequency` [Hz], shape (n,), after the linear angle between teeth that come at tooth_rate [Hz]."""
    return np.sinc(frequency / tooth_rate) ** 2
