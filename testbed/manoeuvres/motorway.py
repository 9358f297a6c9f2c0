"""Motorway mix: speed wanders between 65 and 115 % of the given one (200 km/h at the most), a lane change every half
minute."""

from __future__ import annotations

import numpy as np

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import PATH_STEP, Manoeuvre, driven, offset_path, pull_away, smooth_step, speed_plan

LEVELS = (1.0, 1.15, 0.9, 1.05, 0.65, 0.85, 1.1, 0.8)  # shares of the speed
FASTEST = 200.0 / 3.6  # m/s
HOLD, CHANGE = 14.0, 12.0  # s, a change takes longer where the engine's reserve is small
LANE = 3.5  # m


class Motorway(Manoeuvre):
    name = "motorway"
    about = "65 to 115 % of the speed, lane changes"

    def plan(self, speed: float, duration: float) -> Plan:
        time, level, now, i = [0.0], [speed], 0.0, 0
        while now < duration:
            coming = min(speed * LEVELS[(i + 1) % len(LEVELS)], FASTEST)
            change = CHANGE if coming <= level[-1] else max(CHANGE, pull_away(level[-1], coming)[0][-1])
            time += [now + HOLD, now + HOLD + change]
            level += [level[-1], coming]
            now, i = now + HOLD + change, i + 1
        profile = speed_plan(time, level, duration)
        spacing = max(30.0 * speed, 100.0)
        along = np.arange(0.0, 1.2 * speed * (duration + 5.0) + 100.0, PATH_STEP)
        cycle = np.mod(along / spacing, 2.0)
        width = max(5.0 * speed, 30.0) / spacing
        offset = LANE * (smooth_step((cycle - 0.5) / width) - smooth_step((cycle - 1.5) / width))
        return driven(*profile, offset_path(offset))
