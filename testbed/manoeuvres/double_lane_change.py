"""Double lane change after the proportions of ISO 3888-1, one every 250 m.

3.5 m to the left over 30 m, 25 m there, back over 25 m; the transitions are stretched where the speed would need more
than 4 m/s^2 sideways.
"""

from __future__ import annotations

import numpy as np

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import PATH_STEP, Manoeuvre, driven, offset_path, smooth_step, speed_plan

LANE, STAY, EVERY = 3.5, 25.0, 250.0  # m
LARGEST_LATERAL = 4.0  # m/s^2
PEAK = 5.774  # largest second derivative of smooth_step


class DoubleLaneChange(Manoeuvre):
    name = "double-lane-change"
    about = "ISO 3888-1 proportions, every 250 m"
    largest_lateral = LARGEST_LATERAL

    def plan(self, speed: float, duration: float) -> Plan:
        need = speed * np.sqrt(PEAK * LANE / self.largest_lateral)
        out, back = max(30.0, need), max(25.0, need)
        along = np.arange(0.0, speed * (duration + 5.0) + 100.0, PATH_STEP)
        at = np.mod(along - 40.0, max(EVERY, out + back + 100.0))
        at[along < 40.0] = 0.0
        offset = LANE * (smooth_step(at / out) - smooth_step((at - out - STAY) / back))
        return driven(*speed_plan([0.0], [speed], duration), offset_path(offset))
