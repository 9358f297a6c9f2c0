"""Wind along and across the road: a mean and gusts, as the air's velocity over time, from a declared spectrum.

Both components of the gusts are first-order Markov with the standard deviation and the correlation that the Dryden
model gives the longitudinal one [MIL-F-8785C 3.7.1.2, near the ground], as a car meets frozen turbulence:

    S(f) = 4 s^2 T / (1 + (2 pi f T)^2)      one-sided, per component; s = intensity * mean wind, T = LENGTH / V

V is the speed through the air at the plan's mean speed. Declared: LENGTH (open country, bumper height; Dryden's 200 ft
are those of an aircraft), the isotropy, and that the wind is the same over the whole car. The series is drawn
once for a drive, every STEP, and is linear between; the drive's loop only looks it up. Left out: the wind's own slow
turning, passing lorries, gaps in a hedge.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import inlined

STEP = 0.1  # s between the values of the series
LENGTH = 40.0  # m
_STREAM = 0x77696E64  # separates these draws from a seed's other uses


def wind_series(
    speed: float, coming_from: float, intensity: float, car_speed: float, duration: float, seed: int
) -> NDArray[np.float64]:
    """Velocity of the air in the world, x and y [m/s], every STEP from time 0 on, shape (n, 2).

    speed [m/s] and coming_from [rad] of the mean: 0 blows against a car that drives along x, a quarter turn is from
    the left. intensity: std of the gusts over the mean [-]. car_speed: mean of the drive [m/s]. duration [s].
    """
    along, across = -speed * math.cos(coming_from), -speed * math.sin(coming_from)
    series = np.empty((int(duration / STEP) + 2, 2))
    series[:] = along, across
    if speed == 0.0 or intensity == 0.0:
        return series[:2] if speed == 0.0 else series
    through = max(math.hypot(car_speed - along, across), 0.5 * speed)
    decay = math.exp(-STEP * through / LENGTH)
    draws = np.random.default_rng([seed, _STREAM]).standard_normal(series.shape) * intensity * speed
    gust, fresh = draws[0], math.sqrt(1.0 - decay * decay)
    for k in range(len(series)):
        gust = decay * gust + fresh * draws[k] if k else gust
        series[k] += gust
    return series


@inlined
def air_velocity(series, time):
    """x and y of the air's velocity [m/s] at a time [s], its ends held before the first value and after the last."""
    at = min(max(time / STEP, 0.0), series.shape[0] - 1.0)
    i = min(int(at), series.shape[0] - 2)
    part = at - i
    return (
        series[i, 0] + part * (series[i + 1, 0] - series[i, 0]),
        series[i, 1] + part * (series[i + 1, 1] - series[i, 1]),
    )


@inlined
def air_force(series, time, drag_area, side_area, vx, vy, cos_heading, sin_heading):
    """Force of the air in the world, x and y, and the part of it that the wind adds across the body, to the left [N].

    Drag against the car's velocity through the air (vx, vy over ground [m/s]), half rho cd A = drag_area; across the
    body the wind's own component w pushes with half rho (side-force slope - cd) A = side_area times stream times w.
    """
    wind_x, wind_y = air_velocity(series, time)
    through_x, through_y = vx - wind_x, vy - wind_y
    stream = math.hypot(through_x, through_y)
    cross = side_area * stream * (wind_y * cos_heading - wind_x * sin_heading)
    force_x = -drag_area * stream * through_x - cross * sin_heading
    return force_x, -drag_area * stream * through_y + cross * cos_heading, cross
