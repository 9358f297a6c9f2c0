"""Full braking: from a speed, after one second, at the limit of friction to standstill."""

from __future__ import annotations

import numpy as np

from testbed.driver import PLAN_STEP, STOP, Plan
from testbed.manoeuvres.manoeuvre import Manoeuvre, driven, speed_plan, straight_path

START = 1.0  # s


class Brake(Manoeuvre):
    name = "brake"
    about = "full braking to standstill, from 1 s on"

    def plan(self, speed: float, duration: float) -> Plan:
        plan = driven(*speed_plan([0.0], [speed], duration), straight_path())
        mode = plan.mode.copy()
        mode[int(START / PLAN_STEP) :] = STOP
        return plan._replace(mode=np.ascontiguousarray(mode))
