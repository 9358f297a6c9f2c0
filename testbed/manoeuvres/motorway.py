"""Motorway mix: speed wanders between 65 and 115 % of the given one (200 km/h at the most), a lane change every half
minute."""

from __future__ import annotations

import numpy as np

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import PATH_STEP, Manoeuvre, driven, offset_path, smooth_step, wandering_speed

LEVELS = (1.0, 1.15, 0.9, 1.05, 0.65, 0.85, 1.1, 0.8)  # shares of the speed
HOLD, CHANGE = 14.0, 12.0  # s, a change takes longer where the engine's reserve is small
LANE = 3.5  # m


class Motorway(Manoeuvre):
    name = "motorway"
    about = "65 to 115 % of the speed, lane changes"

    def plan(self, speed: float, duration: float) -> Plan:
        profile = wandering_speed(speed, duration, LEVELS, HOLD, CHANGE)
        spacing = max(30.0 * speed, 100.0)
        along = np.arange(0.0, 1.2 * speed * (duration + 5.0) + 100.0, PATH_STEP)
        cycle = np.mod(along / spacing, 2.0)
        width = max(5.0 * speed, 30.0) / spacing
        offset = LANE * (smooth_step((cycle - 0.5) / width) - smooth_step((cycle - 1.5) / width))
        return driven(*profile, offset_path(offset))
