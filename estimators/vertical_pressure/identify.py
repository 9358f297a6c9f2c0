"""A corner's parameters from drives at known pressures: maximum innovation likelihood, bounded, from several starts.

Ljung, System Identification, 2nd ed., ch. 7.4. The paper (Brancati & Tufano, Machines 2022, 10, 1221, 5.2) fits the
course of both accelerations over a known road by a genetic algorithm; here the road is noise, as it is in a drive,
and each drive's level is its own, solved for in closed form: what is fitted is what the estimator will use. Searched:
m_s, m_us, k, c and the footprint, within bounds about the maker's numbers, and the model's error, whose bounds are
the point: left free, on class D it grows until the filter believes nothing (a variance of 135 was met), a false
optimum. Starts differ in damping, footprint and error; from each a part of the drives is fitted, from the best of
these optima all of them. Kept: belt mass, and how the footprint grows for softer tyres, which a drive hardly tells and
which would soak up the stiffness. Nothing depends on the road's level or on speed: freed, footprint, damping, spring
and stiffness move by less than 1 % for a factor e of level, and the likelihood by less than its own scatter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from estimators.compiled import compiled
from estimators.vertical_pressure.anti_alias import STEP, analogue
from estimators.vertical_pressure.bank import SENSOR_VARIANCE
from estimators.vertical_pressure.chain import Quarter
from estimators.vertical_pressure.innovations import filter_of, squares

SETTLE = 64  # samples before a filter that began at rest is judged
SEARCHED = ("sprung_mass", "unsprung_mass", "spring_rate", "damping", "footprint")
LOWEST = np.log([0.7, 0.8, 0.7, 0.7, 0.6, 2e-4])  # over the maker's; the last: hub_error itself
HIGHEST = np.log([1.4, 1.25, 1.4, 1.4, 1.6, 0.05])
STARTS = ((1.0, 1.0, 0.005), (1.2, 1.2, 0.02), (0.85, 0.85, 0.001))  # damping, footprint over the maker's; hub_error
PART = 4  # of so many drives one is fitted from every start
_STEP = 1e-4  # of the logarithms, for the gradient


@dataclass(frozen=True, eq=False)
class KnownDrive:
    """samples: decimated hub acceleration of one wheel (n,) [m/s^2]; tyre_stiffness by the tyre's law [N/m]; speed
    [m/s]."""

    samples: NDArray[np.float64]
    tyre_stiffness: float
    speed: float


@dataclass(frozen=True)
class Identified:
    """quarter; costs: negative log-likelihood of a part of the drives, by sample, at each start's optimum."""

    quarter: Quarter
    costs: tuple[float, ...]


@compiled
def _drive_cost(quarter, samples, tyre_stiffness, speed, level, low):
    """(negative log-likelihood less a constant, level [m^3/rad]): the level is the samples' own, near `level`."""
    A, c, K, S = filter_of(quarter, tyre_stiffness, speed, level, SENSOR_VARIANCE, low, STEP)
    n = len(samples) - SETTLE
    own = squares(A, c, K, S, samples)[SETTLE:].sum() / n
    return 0.5 * n * (np.log(own) + np.log(S)), own


def quarter_at(maker: Quarter, place: NDArray[np.float64]) -> Quarter:
    """place: ln of the SEARCHED over the maker's, and ln hub_error, (6,)."""
    scaled = {name: getattr(maker, name) * float(np.exp(a)) for name, a in zip(SEARCHED, place, strict=False)}
    return maker._replace(**scaled, hub_error=float(np.exp(place[-1])))


def levels_of(maker: Quarter, drives: Sequence[KnownDrive]) -> NDArray[np.float64]:
    """G of each drive's road as the maker's quarter car has it [m^3/rad]."""
    low, found = analogue(), []
    for drive in drives:
        level = 1e-5
        for _ in range(3):
            _, level = _drive_cost(maker, drive.samples, drive.tyre_stiffness, drive.speed, level, low)
        found.append(level)
    return np.array(found)


def identify(maker: Quarter, drives: Sequence[KnownDrive]) -> Identified:
    """The best of the starts. ValueError without drives or with too short ones."""
    if not drives or min(len(drive.samples) for drive in drives) <= 2 * SETTLE:
        raise ValueError(f"identification needs drives of more than {2 * SETTLE} decimated samples each")
    levels, best = levels_of(maker, drives), []
    for damping, footprint, error in STARTS:
        start = np.array([0.0, 0.0, 0.0, np.log(damping), np.log(footprint), np.log(error)])
        best.append(_optimum(maker, drives[::PART], levels[::PART], start))
    _, nearest = min(best, key=lambda pair: pair[0])
    _, found = _optimum(maker, drives, levels, nearest)
    return Identified(quarter_at(maker, found), tuple(value for value, _ in best))


def _optimum(
    maker: Quarter, drives: Sequence[KnownDrive], levels: NDArray[np.float64], start: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64]]:
    """(cost, place) of the nearest optimum to a place."""
    low = analogue()
    total = sum(len(drive.samples) - SETTLE for drive in drives)

    def cost(place: NDArray[np.float64]) -> float:
        quarter = quarter_at(maker, place)
        parts = [
            _drive_cost(quarter, d.samples, d.tyre_stiffness, d.speed, level, low)[0]
            for d, level in zip(drives, levels, strict=True)
        ]
        return float(np.sum(parts)) / total

    def gradient(place: NDArray[np.float64]) -> NDArray[np.float64]:
        steps = _STEP * np.eye(len(place))
        return np.array([(cost(place + e) - cost(place - e)) / (2.0 * _STEP) for e in steps])

    bounds = list(zip(LOWEST, HIGHEST, strict=True))
    found = minimize(cost, start, jac=gradient, method="L-BFGS-B", bounds=bounds, options={"maxiter": 60, "ftol": 1e-9})
    return float(found.fun), found.x
