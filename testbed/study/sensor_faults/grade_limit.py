"""What one second can tell of an accelerometer's bias on a road of unknown grade: a limit beside the measured rate.

A bias b and a grade that begins differ in what the pitch gyro says; so the residual

    e = f_x + r v_y - dv/dt - g integral of the pitch rate,      dv/dt from both wheel pairs (mean)

holds neither grade nor motion, only b, an unknown level and the gyro's offset (a slope), slip, quantisation, vibration.
Of Gaussian e with covariance C over PAST + 1 s in cells of CELL, level and slope unknown, the best detector of a step s
in the last second has the signal-to-noise ratio sqrt(s' C^-1 s), and finds Phi(ratio - z) of the steps if its
threshold z is passed by chance once in the stated hours (one independent look a second, two-sided). C is measured on
sound drives, one for each road class, so the limit is of detectors that know how rough the road is, and optimistic by
the few windows it is measured on. Source: own; Neyman-Pearson, Van Trees, Detection, Estimation, and Modulation
Theory I, section 4.3. Not in it: torque (silent where brakes may act), and that only what is alike in all windows of a
class is known."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from estimators.car import GRAVITY, Car
from estimators.drive_log import WHEELS
from estimators.grid import LATENCY, Channel, Grid
from estimators.redundancy.sources import V_SLIP
from testbed.study.sensed import Stretch

CELL = 0.2  # s
PAST, NOW = 25, 5  # cells: 5 s before, and the second after
SLOWEST = 3.0  # m/s
UNKNOWN = 1e4  # variance of level and slope
CHANNELS = (
    *(Channel(f"wheel/{wheel}/speed") for wheel in WHEELS),
    Channel("imu/accel", 0), Channel("imu/accel", 1), Channel("imu/gyro", 1), Channel("imu/gyro", 2),
)  # fmt: skip
_FINE = 0.02  # s, in which speeds are differenced


def windows(stretches: Sequence[Stretch], car: Car) -> NDArray[np.float64]:
    """e of a sound drive [m/s^2], one window a second while it moves, shape (n, PAST + NOW)."""
    grid, parts, index = Grid(CHANNELS, _FINE), [], []
    for number, stretch in enumerate(stretches):
        grid.add(stretch)
        cells, _ = grid.close(number + 1.0 + LATENCY)
        parts.append(cells.value)
        index.append(cells.index)
    table = np.concatenate(parts)
    if not (np.diff(np.concatenate(index)) == 1).all():
        return np.empty((0, PAST + NOW))
    wheels = table[:, :4] * car.rolling_radius
    forward, lateral, nod, turn = table[:, 4:8].T
    v = wheels.mean(axis=1)
    sideways = turn * car.cg_to_rear_axle * (1.0 - (v / V_SLIP) ** 2)
    roll = np.clip((lateral - v * turn) / GRAVITY, -0.3, 0.3)
    pitch = -np.cumsum(np.nan_to_num(nod - turn * roll)) * _FINE
    e = forward + turn * sideways - np.gradient(v, _FINE) - GRAVITY * pitch
    each = round(CELL / _FINE)
    n = len(e) // each
    means, speed = e[: n * each].reshape(n, each).mean(axis=1), v[: n * each].reshape(n, each).min(axis=1)
    found = [
        means[k : k + PAST + NOW]
        for k in range(0, n - PAST - NOW + 1, NOW)
        if (speed[k : k + PAST + NOW] > SLOWEST).all() and np.isfinite(means[k : k + PAST + NOW]).all()
    ]
    return np.array(found).reshape(-1, PAST + NOW)


def ratio(covariance: NDArray[np.float64], bias: float, cells: int = NOW) -> float:
    """Signal-to-noise ratio of the best detector. covariance: of a window, (PAST + NOW, PAST + NOW); cells: of the step
    that it hears."""
    steps = np.arange(PAST + NOW) - (PAST + NOW - cells)
    basis = np.stack([np.ones(PAST + NOW), steps / (PAST + NOW)])
    total = covariance + UNKNOWN * basis.T @ basis
    signal = bias * (steps >= 0)
    return float(math.sqrt(signal @ np.linalg.solve(total, signal)))


def limit(by_class: Mapping[str, NDArray[np.float64]], bias: float, hours: float, cells: int = NOW) -> float | None:
    """Share [-] of steps that the best detector finds within the second, over all windows; None without enough of them.
    by_class: windows (n, PAST + NOW) of each road class; hours: between its false alarms."""
    threshold = float(norm.isf(0.5 / (hours * 3600.0)))
    found = []
    for w in by_class.values():
        if len(w) > 2 * (PAST + NOW):
            covariance = np.cov(w - w.mean(axis=1, keepdims=True), rowvar=False)
            found.append((len(w), float(norm.cdf(ratio(covariance, bias, cells) - threshold))))
    total = sum(n for n, _ in found)
    return sum(n * share for n, share in found) / total if total else None
