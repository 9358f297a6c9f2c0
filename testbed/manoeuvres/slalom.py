"""Slalom: a sine about the straight with a lateral acceleration of 3 m/s^2 at the most."""

from __future__ import annotations

import numpy as np

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import (
    LATERAL_COMFORT,
    PATH_STEP,
    Manoeuvre,
    driven,
    offset_path,
    smooth_step,
    speed_plan,
)

PERIOD = 4.0  # s of one left-right cycle
WIDEST = 1.5  # m


class Slalom(Manoeuvre):
    name = "slalom"
    about = "sine about the straight, 4 s a cycle"

    def plan(self, speed: float, duration: float) -> Plan:
        wave = max(speed * PERIOD, 20.0)
        amplitude = min(WIDEST, LATERAL_COMFORT / max((2.0 * np.pi * speed / wave) ** 2, 1e-9))
        along = np.arange(0.0, speed * (duration + 5.0) + 100.0, PATH_STEP)
        offset = amplitude * smooth_step((along - 10.0) / wave) * np.sin(2.0 * np.pi * (along - 10.0) / wave)
        return driven(*speed_plan([0.0], [speed], duration), offset_path(offset))
