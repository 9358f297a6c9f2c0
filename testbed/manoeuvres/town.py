"""Town mix: stops, stretches at the speed, and right-angle turns of 12 m radius at walking-on speed, left and right.

Speed and path are laid out together: each block is stand, pull away, cruise, slow down, turn, and slow to a stop.
"""

from __future__ import annotations

import numpy as np

from testbed.driver import PLAN_STEP, Plan
from testbed.manoeuvres.manoeuvre import COMFORT, PATH_STEP, Manoeuvre, curvature_path, driven, speed_plan

RADIUS, TRANSITION = 12.0, 6.0  # m
TURN_SPEED = 4.5  # m/s
SLOWEST = 1.0 / 3.6  # m/s: below it a turn would take a minute and more
STAND, CRUISE = 3.0, 8.0  # s


class Town(Manoeuvre):
    name = "town"
    about = "stops, cruises at the speed (up to 60 km/h), right-angle turns"

    def plan(self, speed: float, duration: float) -> Plan:
        if speed < SLOWEST:
            raise ValueError(
                f"speed {3.6 * speed:g} km/h is too low for the manoeuvre town; valid: {3.6 * SLOWEST:g} to 200 km/h"
            )
        top = min(speed, 60.0 / 3.6)
        slow = min(TURN_SPEED, top)
        turn_length = 0.5 * np.pi * RADIUS + TRANSITION
        time, level, middles, now = [0.0], [0.0], [], 0.0
        while now < duration + 5.0:
            for span, target in ((STAND, 0.0), (top / COMFORT + 0.5, top), (CRUISE, top),
                                 ((top - slow) / COMFORT + 0.5, slow)):  # fmt: skip
                now += span
                time.append(now)
                level.append(target)
            turning = (turn_length + 6.0) / slow
            middles.append(now + 0.5 * turning)
            for span, target in ((turning, slow), (slow / COMFORT + 1.0, 0.0)):
                now += span
                time.append(now)
                level.append(target)
        profile = speed_plan(time, level, max(duration, now))
        station = np.concatenate([[0.0], np.cumsum(profile[0]) * PLAN_STEP])
        along = np.arange(0.0, station[-1] + 100.0, PATH_STEP)
        curvature = np.zeros_like(along)
        for k, middle in enumerate(middles):
            centre = np.interp(middle, np.arange(len(station)) * PLAN_STEP, station)
            inside = np.clip((0.5 * turn_length - np.abs(along - centre)) / TRANSITION, 0.0, 1.0)
            curvature += inside * (1.0 if k % 2 == 0 else -1.0)
        # a trapezium of this length and transition turns by a right angle at 1/RADIUS
        return driven(*profile, curvature_path(curvature / RADIUS))
