"""Inflation: the gas in each tyre, its leaks and its warmth.

Ideal gas at constant volume: absolute pressure P = n T with n = m R_s / V [Pa/K], the amount of gas, as the state.
    leak    (the linear orifice of direct-TPMS papers)  dP/dt = -rate0 (P - Patm) / (P0 - Patm) at constant T: it starts
    at
            rate0 and dies out as the tyre goes flat
    set     from a given time on, the amount runs in a straight line to that of a target gauge pressure (a burst, or a
    pump) warmth  C dT/dt = share * drag power - (C / tau) (T - T_ambient)
Pressures are gauge outside this file. Volume change with load is left out (below 0.5 %).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from estimators.compiled import compiled
from estimators.drive_log import WHEELS
from models.tyre_properties import TyreProperties

ATMOSPHERE = 101325.0  # Pa

AMOUNT, TEMPERATURE, PRESSURE = range(3)  # columns of the gas state, shape (4, 3); PRESSURE is gauge


@dataclass(frozen=True)
class Leak:
    """A leak of one tyre: rate of pressure loss when it begins [Pa/s], and when it begins [s]."""

    rate: float
    start: float = 0.0


@dataclass(frozen=True)
class PressureSet:
    """One tyre brought to a gauge pressure [Pa], from `start` [s] on, within `duration` [s]."""

    pressure: float
    start: float
    duration: float = 0.1


class Inflation(NamedTuple):
    """Schedules, shape (4,) each, and thermal constants; SI. Times are inf where nothing happens."""

    leak_rate: NDArray[np.float64]
    leak_start: NDArray[np.float64]
    set_pressure: NDArray[np.float64]
    set_start: NDArray[np.float64]
    set_duration: NDArray[np.float64]
    ambient: float
    heat_capacity: float
    time_constant: float
    heat_share: float


def inflation(
    tyre: TyreProperties, leaks: Mapping[str, Leak], sets: Mapping[str, PressureSet], ambient: float
) -> Inflation:
    """The schedules of a drive. leaks, sets: by wheel name; ambient: [K]."""
    none = Leak(0.0, np.inf), PressureSet(0.0, np.inf)
    leak = [leaks.get(w, none[0]) for w in WHEELS]
    change = [sets.get(w, none[1]) for w in WHEELS]
    return Inflation(
        np.array([x.rate for x in leak]), np.array([x.start for x in leak]),
        np.array([x.pressure for x in change]), np.array([x.start for x in change]),
        np.array([x.duration for x in change]),
        ambient, tyre.heat_capacity, tyre.thermal_time_constant, tyre.heat_share,
    )  # fmt: skip


def initial_gas(pressure: NDArray[np.float64], ambient: float) -> NDArray[np.float64]:
    """Gas state of cold tyres at gauge pressures [Pa], shape (4,) -> (4, 3)."""
    gas = np.empty((4, 3))
    gas[:, AMOUNT] = (pressure + ATMOSPHERE) / ambient
    gas[:, TEMPERATURE] = ambient
    gas[:, PRESSURE] = pressure
    return gas


@compiled
def inflate(plan, gas, leak_span, drag_power, time, step):
    """Gas state one step on. leak_span: gauge pressure at each leak's start [Pa], shape (4,), kept here from step to
    step; drag_power: [W], shape (4,); time, step: [s]."""
    for w in range(4):
        if time >= plan.leak_start[w] and plan.leak_rate[w] > 0.0:
            if leak_span[w] <= 0.0:
                leak_span[w] = max(gas[w, PRESSURE], 1.0)
            gas[w, AMOUNT] -= plan.leak_rate[w] * gas[w, PRESSURE] / leak_span[w] * step / gas[w, TEMPERATURE]
        left = plan.set_start[w] + plan.set_duration[w] - time
        if time >= plan.set_start[w] and left > -step:
            target = (plan.set_pressure[w] + ATMOSPHERE) / gas[w, TEMPERATURE]
            gas[w, AMOUNT] += (target - gas[w, AMOUNT]) * min(1.0, step / max(left, step))
        warming = plan.heat_share * drag_power[w] / plan.heat_capacity
        cooling = (gas[w, TEMPERATURE] - plan.ambient) / plan.time_constant
        gas[w, TEMPERATURE] += step * (warming - cooling)
        gas[w, PRESSURE] = max(gas[w, AMOUNT] * gas[w, TEMPERATURE] - ATMOSPHERE, 0.0)
