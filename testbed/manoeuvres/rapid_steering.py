"""Rapid steering: from lock to the left to lock to the right and back, as fast as the hands go.

The path's curvature swings once to the tightest that the speed allows, left and right, every EVERY seconds, with
transitions so short that the driver cannot follow them and turns the wheel at his fastest. What he can drive through
them he does; the rest he cuts.
"""

from __future__ import annotations

import numpy as np

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import PATH_STEP, Manoeuvre, curvature_path, driven, speed_plan

PERIOD, EVERY = 2.4, 5.0  # s of one left-right cycle, and from one to the next
LARGEST_LATERAL = 4.0  # m/s^2
TIGHTEST = 8.0  # m: a road-wheel angle of 19 deg
LEAD_IN = 5.0  # m
FINENESS = 15  # steps of the path in a transition
TRANSITION = 0.2  # s from one curvature to the other


class RapidSteering(Manoeuvre):
    name = "rapid-steering"
    about = "left and right in turn, as fast as the hands go"

    def plan(self, speed: float, duration: float) -> Plan:
        way = max(speed, 1.0)
        step = min(TRANSITION * way / FINENESS, PATH_STEP)
        along = np.arange(0.0, speed * (duration + 5.0) + 100.0, step)
        cycle = np.minimum(np.mod(np.maximum(along - LEAD_IN, 0.0), EVERY * way) / (PERIOD * way), 1.0)
        swing = np.clip(np.sin(2.0 * np.pi * cycle) * PERIOD / (np.pi * TRANSITION), -1.0, 1.0)
        radius = max(speed**2 / LARGEST_LATERAL, TIGHTEST)
        plan = driven(*speed_plan([0.0], [speed], duration), curvature_path(swing / radius, step))
        return plan._replace(path_step=step)
