"""What a curve does to the two wheels of an axle besides their paths: load moves, and radii and slip follow.

A lateral acceleration a (felt, so a bank counts; left turn positive) moves q = m a h / (t_f + t_r) of load from each
left wheel to the right one, on both axles alike. To first order it adds to r_left / r_right - 1 of an axle

    -2 RADIUS_LOAD q     the lighter inner wheel rolls on a larger radius; 8e-4 at 1 m/s^2, as 20 % of pressure do
    -2 (q / F) s         an open differential, or the brakes, give both wheels the same force: the inner one, of load F
                         less q, slips more. s = INNER_SLIP pull, the slip of the axle's pull; 2e-3 at 1 m/s^2 and pull
                         0.2, so a driven axle that pulls hard reads the other way round

Both were found in drives on country roads and slaloms (sound cars of seed 101, told rightly): they explain 0.95 of the
first at free axles and 1.45 of 0.047, the true 1/k, at driven ones. Over ten drives r.m.s. of what 8 s of delta follow
a curve by fell from 0.9e-3 to 0.3e-3. Left out: how anti-roll bars share the load between the axles, camber, side slip.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.wheel_radius.traction import axle_loads

RADIUS_LOAD = -1.1e-6  # d ln(rolling radius) / d load [1/N]: published Magic Formula sets, 0.5 mm per kN of real tyres
INNER_SLIP = 0.068  # -d ln(slip) / d ln(load) times 1/k [-]
BODY_ROLL = 0.93  # of what the accelerometer feels, which the body rolls with in a curve, is across the road


def curve_shift(car: Car, lateral: float, pull: NDArray[np.float64]) -> NDArray[np.float64]:
    """What is added to r_left / r_right - 1 of front and rear axle, shape (2,) [-].

    lateral: specific force to the left [m/s^2], 0 where unknown; pull: force over load of front and rear axle, (2,).
    """
    moved = BODY_ROLL * lateral * car.mass * car.cg_height / (car.front_track + car.rear_track)
    wheel_loads = 0.5 * np.array(axle_loads(car, 0.0))
    return -2.0 * moved * (RADIUS_LOAD + INNER_SLIP * pull / wheel_loads)
