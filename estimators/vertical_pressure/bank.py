"""The bank of linear filters over stiffness and road, for the present speed and load, of one axle's two
wheels.

Nodes: `STIFFNESSES` (13 % apart), the road's two slopes (`quarter_car.roughness`), and levels lambda (`LEVELS`, a
factor 16 apart: only the sensor's noise, which is not in proportion to the level, makes a filter of one level unfit for
another; what lies between all nodes is `posterior`'s). Each filter is the best linear prediction of a sample from those
of the last second (`prediction`). Filters depend on speed through the waves that it makes of the road and the
footprint's delay; they are designed when the speed has moved by `SPEED_STEP` and kept for when it comes back. All of
them hear every sample, whatever they are believed.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.vertical_pressure.anti_alias import RATE, STEP
from estimators.vertical_pressure.chain import Quarter
from estimators.vertical_pressure.hub_spectrum import Beside, autocovariance
from estimators.vertical_pressure.innovations import ERROR_UNIT
from estimators.vertical_pressure.prediction import MEMORY, predictors

STIFFNESSES = np.exp(np.linspace(math.log(95e3), math.log(370e3), 12))  # N/m
LONG = np.array([1.4, 2.0, 2.6])  # w_l: what it does to the stiffness is little
SHORT = np.linspace(1.0, 3.8, 8)  # w_s
LEVELS = 0.0625e-6 * 16.0 ** np.arange(4.0)  # lambda [m^3/rad]; above the last one the sensor is silent
NODES = (len(STIFFNESSES), len(LONG), len(SHORT), len(LEVELS))  # in this order
SPEED_STEP = 0.03  # of ln speed: the other axle is a fiftieth of a wheelbase wrong at most
LOAD_STEP = 0.05  # of ln of the load: 1 % of stiffness
_KEPT = 96  # designs, 600 kB each
SENSOR_STD = 0.5  # m/s^2 at 1 kHz: the paper's data sheet
SENSOR_VARIANCE = SENSOR_STD**2 / (RATE * STEP)  # of a decimated sample: the same density over its narrower band
# (m/s^2)^2: below it the sensor hears itself and no road; the lowest level at the slowest speed makes twice as much
QUIET = 3.0 * SENSOR_VARIANCE
_MEMORY = MEMORY


def design(quarter: Quarter, beside: Beside, speed: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Filters (MEMORY + 1, all nodes), over their innovations' standard deviation for lambda = 1, and ln of its square,
    NODES. Speed [m/s]."""
    covariance = autocovariance(quarter, beside, STIFFNESSES, speed, LONG, SHORT, MEMORY)
    white = quarter.hub_error * ERROR_UNIT * speed + SENSOR_VARIANCE / LEVELS
    flat = covariance.reshape(-1, MEMORY + 1)
    filters, log_variance = np.empty((len(flat), len(white), MEMORY + 1)), np.empty((len(flat), len(white)))
    predictors(flat, white, filters, log_variance)
    return np.ascontiguousarray(filters.reshape(-1, MEMORY + 1).T), log_variance.reshape(NODES)


@compiled
def hear(filters, heard, summed):
    """Sums of nu^2 / S over the samples of heard (MEMORY + n,) after the first MEMORY, n a multiple of 4, into summed
    (m,); filters (MEMORY + 1, m). Filters run side by side, four samples at a time, which a processor's vectors like.
    """
    m = filters.shape[1]
    nu0, nu1, nu2, nu3 = np.empty(m), np.empty(m), np.empty(m), np.empty(m)
    summed[:] = 0.0
    for t in range(_MEMORY, len(heard), 4):
        nu0[:] = 0.0
        nu1[:] = 0.0
        nu2[:] = 0.0
        nu3[:] = 0.0
        for j in range(_MEMORY + 1):
            row = filters[j]
            y0, y1, y2, y3 = heard[t - j], heard[t - j + 1], heard[t - j + 2], heard[t - j + 3]
            for i in range(m):
                a = row[i]
                nu0[i] += a * y0
                nu1[i] += a * y1
                nu2[i] += a * y2
                nu3[i] += a * y3
        for i in range(m):
            summed[i] += nu0[i] * nu0[i] + nu1[i] * nu1[i] + nu2[i] * nu2[i] + nu3[i] * nu3[i]


def heard_by(filters: NDArray[np.float64], heard: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same, by node, NODES; filters of `design`."""
    summed = np.empty(filters.shape[1])
    hear(filters, heard, summed)
    return summed.reshape(NODES)


def laden(quarter: Quarter, beside: Beside, load: float) -> tuple[Quarter, Beside]:
    """Both with `load` times the sprung mass: contact is as much longer as it is for a tyre softer by that share."""
    unsprung = quarter.unsprung_mass + quarter.belt_mass
    wheel = (load * quarter.sprung_mass + unsprung) / (quarter.sprung_mass + unsprung)
    heavy = quarter._replace(
        sprung_mass=load * quarter.sprung_mass, footprint=quarter.footprint * wheel**quarter.softer
    )
    other = beside.quarter._replace(sprung_mass=load * beside.quarter.sprung_mass)
    return heavy, beside._replace(quarter=other, coupling=beside.coupling / load)


@lru_cache(maxsize=_KEPT)
def _designed(
    quarter: Quarter, beside: Beside, place: int, load: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return design(*laden(quarter, beside, math.exp(load * LOAD_STEP)), math.exp(place * SPEED_STEP))


class AxleBank:
    """Filters of one axle by speed and load, each rounded to a grid, the last place kept while it is near."""

    def __init__(self, quarter: Quarter, beside: Beside) -> None:
        self.quarter, self.beside = quarter, beside
        self._place: int | None = None
        self._load = 0

    def at(self, speed: float, load: float = 1.0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """`design` for a speed [m/s] and sprung masses `load` times the quarter's; shared, not to be written to."""
        exact = math.log(speed) / SPEED_STEP
        if self._place is None or abs(exact - self._place) > 0.75:
            self._place = round(exact)
        exact = math.log(load) / LOAD_STEP
        if abs(exact - self._load) > 0.75:
            self._load = round(exact)
        return _designed(self.quarter, self.beside, self._place, self._load)
