"""Constant speed on a straight."""

from __future__ import annotations

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import Manoeuvre, driven, speed_plan, straight_path


class Constant(Manoeuvre):
    name = "constant"
    about = "constant speed, straight on"

    def plan(self, speed: float, duration: float) -> Plan:
        return driven(*speed_plan([0.0], [speed], duration), straight_path())
