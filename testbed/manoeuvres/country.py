"""Country road: speed wanders between 70 and 105 % of the given one (200 km/h at the most), through curves left and
right.

Between straights lie curves entered and left over clothoids, as wide as makes their lateral acceleration at the given
speed one of LATERAL, and TURN long in time. A curve to the left is followed by the same one to the right, so the road
goes on along x.
"""

from __future__ import annotations

import numpy as np

from testbed.driver import Plan
from testbed.manoeuvres.manoeuvre import PATH_STEP, Manoeuvre, curvature_path, driven, wandering_speed

LEVELS = (1.0, 0.85, 0.95, 0.7, 0.9, 1.05, 0.8)  # shares of the speed
HOLD, CHANGE = 9.0, 7.0  # s, a change takes longer where the engine's reserve is small
LATERAL = (0.8, 1.6, 0.5, 1.2)  # m/s^2
TURN, CLOTHOID, STRAIGHT = 6.0, 2.5, 7.0  # s at the given speed
SMALLEST_RADIUS = 25.0  # m
SHORTEST = 10.0  # m, of a clothoid


class Country(Manoeuvre):
    name = "country"
    about = "70 to 105 % of the speed, curves left and right"

    def plan(self, speed: float, duration: float) -> Plan:
        along = np.arange(0.0, 1.1 * speed * (duration + 5.0) + 100.0, PATH_STEP)
        clothoid = max(CLOTHOID * speed, SHORTEST)
        straight, turn = max(STRAIGHT * speed, 30.0), max(TURN * speed, SHORTEST)
        lap = straight + 2.0 * clothoid + turn
        number, place = np.divmod(along, lap)
        inside = np.clip(np.minimum(place - straight, lap - place) / clothoid, 0.0, 1.0)
        radius = np.array([max(speed**2 / a, SMALLEST_RADIUS) for a in LATERAL])
        side = np.where(number % 2 == 0, 1.0, -1.0)
        curvature = side * inside / radius[number.astype(int) // 2 % len(LATERAL)]
        return driven(*wandering_speed(speed, duration, LEVELS, HOLD, CHANGE), curvature_path(curvature))
