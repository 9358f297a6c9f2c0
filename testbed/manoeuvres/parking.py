"""Parking pace: round one corner after the other near the end of the rack, left and right in turn, walking on.

There is no reverse gear: it goes on forward, an S of quarter circles.
"""

from __future__ import annotations

import numpy as np

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import PATH_STEP, Manoeuvre, curvature_path, driven, speed_plan

RADIUS = 5.5  # m: a road-wheel angle of 27 deg
FASTEST = 12.0 / 3.6  # m/s: 2 m/s^2 sideways
TRANSITION, STRAIGHT, LEAD_IN = 3.0, 2.0, 1.0  # m


class Parking(Manoeuvre):
    name = "parking"
    about = "quarter circles of 5.5 m left and right in turn, up to 12 km/h"

    def plan(self, speed: float, duration: float) -> Plan:
        pace = min(speed, FASTEST)
        turn = 0.5 * np.pi * RADIUS + TRANSITION
        along = np.arange(0.0, pace * (duration + 5.0) + 100.0, PATH_STEP)
        number, place = np.divmod(along - LEAD_IN, turn + STRAIGHT)
        inside = np.clip(np.minimum(place, turn - place) / TRANSITION, 0.0, 1.0) * (number >= 0.0)
        side = np.where(number % 4 < 2, 1.0, -1.0) * np.where(number % 2 == 0, 1.0, -1.0)
        return driven(*speed_plan([0.0], [pace], duration), curvature_path(side * inside / RADIUS))
