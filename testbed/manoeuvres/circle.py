"""Steady circle to the left, entered from a straight through a clothoid.

The radius is the larger of 40 m and what keeps the lateral acceleration at 3 m/s^2.
"""

from __future__ import annotations

import numpy as np

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import LATERAL_COMFORT, PATH_STEP, Manoeuvre, curvature_path, driven, speed_plan

SMALLEST_RADIUS = 40.0  # m
LEAD_IN, SHORTEST_CLOTHOID = 15.0, 30.0  # m
CLOTHOID_TIME = 2.0  # s


def circle_radius(speed: float, smallest: float = SMALLEST_RADIUS) -> float:
    """Radius [m] that is driven at a speed [m/s]."""
    return max(smallest, speed**2 / LATERAL_COMFORT)


class Circle(Manoeuvre):
    name = "circle"
    about = "steady left-hand circle, radius 40 m or larger (3 m/s^2)"
    smallest, shortest_clothoid = SMALLEST_RADIUS, SHORTEST_CLOTHOID

    def plan(self, speed: float, duration: float) -> Plan:
        clothoid = max(CLOTHOID_TIME * speed, self.shortest_clothoid)
        along = np.arange(0.0, LEAD_IN + clothoid + speed * (duration + 5.0) + 100.0, PATH_STEP)
        curvature = np.clip((along - LEAD_IN) / clothoid, 0.0, 1.0) / circle_radius(speed, self.smallest)
        return driven(*speed_plan([0.0], [speed], duration), curvature_path(curvature))
