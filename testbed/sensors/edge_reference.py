"""Edge times of a toothed ring once more, in plain Python by another way, to test the compiled kernel against.

Each step's Hermite polynomial is walked in small strides; the Schmitt trigger looks at both ends of a stride, and a
switching found there is located by bisection. Two crossings within one stride are missed, which takes a turning point
within a stride of a threshold.
"""

from __future__ import annotations

import math

from testbed.sensors.motion import FloatArray

_STRIDES = 64  # a step
_BISECTIONS = 60


def reference_edge_times(time: FloatArray, angle: FloatArray, speed: FloatArray, ring: FloatArray, hysteresis: float):
    """Times [s] of the edges between the first and the last row, as a list.

    time [s], angle [rad], speed [rad/s]: shape (n,). ring: place of each edge against the even ring, in pitches, shape
    (teeth,). hysteresis [rad].
    """
    teeth = len(ring)

    def place(edge: int) -> float:
        return 2.0 * math.pi / teeth * (edge + float(ring[edge % teeth]))

    edge = math.floor(float(angle[0]) * teeth / (2.0 * math.pi)) - teeth
    while place(edge + 1) <= angle[0]:
        edge += 1
    times: list[float] = []
    for i in range(len(time) - 1):
        step = float(time[i + 1] - time[i])

        def turned(s: float, i: int = i, step: float = step) -> float:
            """Hermite polynomial on its four base functions."""
            return (
                angle[i] * (1.0 + 2.0 * s) * (1.0 - s) ** 2
                + angle[i + 1] * s * s * (3.0 - 2.0 * s)
                + step * (speed[i] * s * (1.0 - s) ** 2 - speed[i + 1] * s * s * (1.0 - s))
            )

        for stride in range(_STRIDES):
            low, high = stride / _STRIDES, (stride + 1) / _STRIDES
            here = turned(high)
            while here >= place(edge + 1) or here < place(edge) - hysteresis:
                forward = here >= place(edge + 1)
                level = place(edge + 1) if forward else place(edge) - hysteresis
                times.append(float(time[i]) + step * _bisect(turned, level, low, high, forward))
                edge += 1 if forward else -1
    return times


def _bisect(turned, level: float, low: float, high: float, forward: bool) -> float:
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if (turned(middle) >= level) == forward:
            high = middle
        else:
            low = middle
    return high
