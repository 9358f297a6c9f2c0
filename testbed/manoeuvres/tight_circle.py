"""Steady circle of 10 m to the left, as far as 3 m/s^2 allow (20 km/h); a faster car takes a larger one."""

from __future__ import annotations

from testbed.manoeuvres.circle import Circle


class TightCircle(Circle):
    name = "tight-circle"
    about = "steady left-hand circle, radius 10 m or larger (3 m/s^2)"
    smallest, shortest_clothoid = 10.0, 12.0  # m
