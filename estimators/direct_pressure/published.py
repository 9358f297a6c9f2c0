"""The seed's leak detector as published: scalar Kalman filter, two-sided CUSUM, slope of the innovations.

Javaid, "How a tire pressure monitoring system works and how to use Kalman filters in Matlab to simulate leak
detection". State p [psi], known input u [psi/s], sampling time dt:
    predict   p = p + u dt,  P = P + Q
    correct   nu = z - p,  K = P / (P + R),  p = p + K nu,  P = (1 - K) P
    CUSUM     x = nu / sqrt(P + R),  g+ = max(g+ + x - d, 0),  g- = max(g- - x - d, 0);  an alarm above h resets both
    slope     least-squares line through the last 50 innovations, taken for the leak rate
with Q = 0.01, R = 0.25 psi^2, P(0) = 1 psi^2, d = 0.2, h = 3.5, dt = 0.05 s.

Its mistakes, kept here:
- d and h mean a false alarm every 22.5 samples, 1.12 s, on a sound tyre whose process noise is Q. Its "detection after
  2.5 s" is one of those.
- Its filter's std of 0.15 psi is impossible with its Q and R: the stationary std is 0.2127 psi filtered, 0.2351
  predicted.
- The slope of the innovations is not the leak rate: a ramp shifts their mean and leaves no slope in them.
- No rate in the state, no false-alarm rate of the alarm, and an upward crossing is called a leak too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled

Array = NDArray[np.float64]


class Published(NamedTuple):
    """The paper's numbers; psi, s."""

    step: float = 0.05
    start: float = 32.0
    variance: float = 1.0
    process: float = 0.01
    measurement: float = 0.25
    drift: float = 0.2
    threshold: float = 3.5
    window: int = 50


PUBLISHED = Published()


def stationary_std(numbers: Published = PUBLISHED) -> tuple[float, float]:
    """Std of the filter when it has settled [psi], after and before a measurement: P- solves P-^2 - Q P- - Q R = 0."""
    q, r = numbers.process, numbers.measurement
    before = 0.5 * (q + np.sqrt(q * q + 4.0 * q * r))
    return float(np.sqrt(before * r / (before + r))), float(np.sqrt(before))


@compiled
def follow_published(numbers, z, inputs):
    """Measurements z [psi] and inputs [psi/s], shape (n,) -> shape (n, 7): estimate and std [psi], innovation [psi], g+
    and g- before a reset [-], alarm (0 or 1), slope of the last innovations [psi/s] (0 until there are enough)."""
    out = np.zeros((len(z), 7))
    p, variance, up, down = numbers.start, numbers.variance, 0.0, 0.0
    for i in range(len(z)):
        p += inputs[i] * numbers.step
        variance += numbers.process
        innovation = z[i] - p
        x = innovation / np.sqrt(variance + numbers.measurement)
        gain = variance / (variance + numbers.measurement)
        p += gain * innovation
        variance *= 1.0 - gain
        up, down = max(up + x - numbers.drift, 0.0), max(down - x - numbers.drift, 0.0)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4] = p, np.sqrt(variance), innovation, up, down
        if max(up, down) > numbers.threshold:
            out[i, 5], up, down = 1.0, 0.0, 0.0
        if i + 1 >= numbers.window:
            middle, above, below = 0.5 * (numbers.window - 1), 0.0, 0.0
            for k in range(numbers.window):
                above += (k - middle) * out[i + 1 - numbers.window + k, 2]
                below += (k - middle) ** 2
            out[i, 6] = above / below / numbers.step
    return out
