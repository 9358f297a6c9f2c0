"""Evasion: a double lane change as hard as a dry road allows, 7 m/s^2 sideways."""

from __future__ import annotations

from testbed.manoeuvres.double_lane_change import DoubleLaneChange


class Evasion(DoubleLaneChange):
    name = "evasion"
    about = "double lane change at up to 7 m/s^2, every 250 m"
    largest_lateral = 7.0  # m/s^2
