"""The superposition gear and the rack: angles of steering wheel, motor and pinion, and of the road wheels.

    delta_S / i_S + delta_M / i_M = delta_G         planetary gear (Razavi, Lund 2006, eq. 1.1)
    delta_F = F_SG(delta_G) = asin(delta_G / i_R)   rack (eq. 1.2), here a steering arm that stands across the car when
                                                    the wheels point ahead, on a long tie rod along the rack
    delta_G = i_R sin(delta_F)                      its inverse

i_R: rack_ratio = arm / pinion radius. The steering becomes more direct as it turns: d delta_G / d delta_F = i_R cos
delta_F. The rack ends at +-rack_stop. All angles [rad], positive to the left; delta_F is the mean of both front wheels.
Left out: elasticity and backlash of gear and column.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from estimators.compiled import inlined


class Gear(NamedTuple):
    """wheel_ratio i_S, motor_ratio i_M, rack_ratio i_R [-]; rack_stop [rad] of the road wheels."""

    wheel_ratio: float
    motor_ratio: float
    rack_ratio: float
    rack_stop: float


@inlined
def pinion_of(gear, wheel, motor):
    """delta_G of the steering wheel's and the motor's angle."""
    return wheel / gear.wheel_ratio + motor / gear.motor_ratio


@inlined
def steering_wheel_of(gear, pinion, motor):
    """delta_S that turns the pinion to `pinion` while the motor stands at `motor`."""
    return gear.wheel_ratio * (pinion - motor / gear.motor_ratio)


@inlined
def road_wheels_of(gear, pinion):
    """F_SG: delta_F of delta_G, held at the end of the rack."""
    end = math.sin(gear.rack_stop)
    return math.asin(min(max(pinion / gear.rack_ratio, -end), end))


@inlined
def pinion_for(gear, road_wheels):
    """The inverse of F_SG within the rack's ends."""
    return gear.rack_ratio * math.sin(min(max(road_wheels, -gear.rack_stop), gear.rack_stop))
