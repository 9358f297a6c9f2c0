"""Coast-down: from a speed, clutch open, no brakes, straight on."""

from __future__ import annotations

import numpy as np

from testbed.driver import COAST, Plan
from testbed.manoeuvres.manoeuvre import Manoeuvre, driven, speed_plan, straight_path


class Coast(Manoeuvre):
    name = "coast"
    about = "coast down from the speed, clutch open"

    def plan(self, speed: float, duration: float) -> Plan:
        plan = driven(*speed_plan([0.0], [speed], duration), straight_path())
        return plan._replace(mode=np.full(len(plan.speed), COAST, np.int64))
