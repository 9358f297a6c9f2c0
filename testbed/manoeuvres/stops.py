"""Speed profile with stops: standstill, up to the speed, cruise, down to standstill, again and again."""

from __future__ import annotations

import numpy as np

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import COMFORT, Manoeuvre, driven, pull_away, speed_plan, straight_path

STAND, CRUISE = 4.0, 12.0  # s
BRAKING = COMFORT / 1.2  # m/s^2


class Stops(Manoeuvre):
    name = "stops"
    about = "from standstill to standstill, with cruises at the speed between"

    def plan(self, speed: float, duration: float) -> Plan:
        up_time, up_speed = pull_away(0.0, speed)
        cruise_end = STAND + up_time[-1] + CRUISE
        time = np.concatenate([[0.0], STAND + up_time, [cruise_end, cruise_end + speed / BRAKING]])
        level = np.concatenate([[0.0], up_speed, [speed, 0.0]])
        rounds = int(duration / time[-1]) + 1
        starts = time[-1] * np.arange(rounds)
        all_times = (starts[:, None] + time).ravel()
        return driven(*speed_plan(all_times, np.tile(level, rounds), duration), straight_path())
