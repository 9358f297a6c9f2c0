"""The variable steering ratio: how far the motor is to turn, over the speed of the car.

    delta_G* = delta_S g(v),  g = i_R / i(v)        i(v): steering wheel per road-wheel angle, straight ahead
    delta_Md = i_M (g(v) - 1 / i_S) delta_S         the motor's share (eq. 1.1)

i(v) is linear between the nodes of `ratio_speeds` and constant beyond them: direct when slow, indirect when fast
(10 to 20 about a mechanical 18; Automobile Magazine, Technology of the Year 2004). The control unit hears delta_S in
steps of STEP every millisecond and smooths it, and v, by first-order lags.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined

STEP = math.radians(0.1)  # rad, usual steering angle sensor


class Ratio(NamedTuple):
    """speeds [m/s] and ratios i [-] at them, shape (n,); lags [s] of the steering-wheel angle and the speed."""

    speeds: NDArray[np.float64]
    ratios: NDArray[np.float64]
    demand_lag: float
    speed_lag: float


@inlined
def ratio_at(ratio, speed):
    """i(v)."""
    last = ratio.speeds.size - 1
    if speed <= ratio.speeds[0]:
        return ratio.ratios[0]
    for k in range(last):
        if speed < ratio.speeds[k + 1]:
            part = (speed - ratio.speeds[k]) / (ratio.speeds[k + 1] - ratio.speeds[k])
            return ratio.ratios[k] + part * (ratio.ratios[k + 1] - ratio.ratios[k])
    return ratio.ratios[last]


@inlined
def pinion_gain(gear, ratio, speed):
    """g(v): pinion per steering-wheel angle that is demanded."""
    return gear.rack_ratio / ratio_at(ratio, speed)


@inlined
def heard(angle):
    """The steering-wheel angle in the sensor's steps."""
    return STEP * math.floor(angle / STEP + 0.5)


@inlined
def motor_demand(gear, ratio, speed, wheel):
    """delta_Md of a speed [m/s] and a steering-wheel angle."""
    return gear.motor_ratio * (pinion_gain(gear, ratio, speed) - 1.0 / gear.wheel_ratio) * wheel
