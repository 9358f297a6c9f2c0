"""International Roughness Index [m/km]: the golden quarter car's mean suspension travel over the road at 80 km/h.

ASTM E1926, Sayers 1995 (TRR 1501), per sprung mass: K1 = 653 1/s^2 (tyre), K2 = 63.3 1/s^2 (spring), mu = 0.15 (mass
ratio), C = 6.0 1/s (damper). State x = (z_s', z_s'', z_u', z_u''): slopes and their time derivatives, driven by the
road's slope smoothed over 250 mm; the state is carried over each sample by the exact transition matrix; IRI = mean
|z_s' - z_u'|. It starts from the mean slope of the first 11 m.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from estimators.compiled import compiled
from testbed.roads.road import Array, Road

SPEED = 80.0 / 3.6  # [m/s]
K1, K2, MU, C = 653.0, 63.3, 0.15, 6.0
BASE_LENGTH = 0.25  # [m] moving average
START_LENGTH = 11.0  # [m]

A = np.array(
    [[0.0, 1.0, 0.0, 0.0], [-K2, -C, K2, C], [0.0, 0.0, 0.0, 1.0], [K2 / MU, C / MU, -(K1 + K2) / MU, -C / MU]]
)
B = np.array([0.0, 0.0, 0.0, K1 / MU])


@compiled
def _mean_travel(slope, transition, response, state):
    total = 0.0
    new = np.empty(4)
    for i in range(len(slope)):
        for r in range(4):
            value = response[r] * slope[i]
            for c in range(4):
                value += transition[r, c] * state[c]
            new[r] = value
        state[:] = new
        total += abs(state[0] - state[2])
    return total / len(slope)


def iri(heights: Array, spacing: float) -> float:
    """IRI [m/km] of a profile z [m], shape (n,), at a uniform spacing [m] of at most 0.3 m and longer than 11 m."""
    z = np.asarray(heights, dtype=np.float64)
    if not 0.0 < spacing <= 0.3:
        raise ValueError(f"IRI needs a spacing above 0 and at most 0.3 m, not {spacing}")
    if z.ndim != 1 or not np.isfinite(z).all() or (z.size - 1) * spacing < START_LENGTH:
        raise ValueError(
            f"IRI needs a finite profile longer than {START_LENGTH:g} m, not {z.size} points at {spacing} m"
        )
    base = max(round(BASE_LENGTH / spacing), 1)
    slope = (z[base:] - z[:-base]) / (base * spacing)
    start = round(START_LENGTH / spacing)
    mean_slope = (z[start] - z[0]) / (start * spacing)
    transition = expm(A * spacing / SPEED)
    response = np.linalg.solve(A, (transition - np.eye(4)) @ B)
    state = np.array([mean_slope, 0.0, mean_slope, 0.0])
    return 1000.0 * float(_mean_travel(slope, transition, response, state))


def iri_of_road(road: Road, length: float, y: float) -> float:
    """IRI [m/km] of the line at y [m] over x = 0..length [m], sampled at the road's own spacing."""
    x = road.spacing * np.arange(round(length / road.spacing) + 1, dtype=np.float64)
    return iri(road.heights(x, np.array([round(y / road.spacing) * road.spacing]))[0], road.spacing)
