"""Where the linearised car, rolling on a flat road, has the frequencies that a drive's spectra show."""

from __future__ import annotations

from functools import cache

import numpy as np

from estimators.drive_log import WHEELS
from testbed.modes import Mode, modes
from testbed.scenario import Scenario
from testbed.simulation import Simulation

MOSTLY = 0.6  # share of a wheel hop's kinetic energy in the travel of its axle's wheels
TURNING = 0.5  # share of a rotational mode's in the rims and belts of its axle
AXLES = (("front", (0, 1)), ("rear", (2, 3)))


@cache
def frequencies(speed: float, pressure: float) -> dict[str, float]:
    """Undamped natural frequencies [Hz] by `hop/AXLE`, `in_phase/AXLE`, `antiphase/AXLE` at a speed [km/h] and pressure
    [kPa]. Of the two of an axle, the hop in which both wheels move together, as a sum of hubs shows it, and the lower
    rotation: the driven wheels' other one turns the engine along, above the band of the spectrum.
    """
    pressures = dict.fromkeys(WHEELS, 1e3 * pressure)
    car = Simulation(Scenario(road="flat", speed=speed / 3.6, duration=1.0, pressures=pressures))
    found: dict[str, float] = {}
    for mode in modes(car):  # slowest first
        for axle, wheels in AXLES:
            kind = _hop(mode, _velocities(car, wheels, "travel")) or _rotation(
                mode, _velocities(car, wheels, "spin"), _velocities(car, wheels, "belt_spin")
            )
            if kind:
                found.setdefault(f"{kind}/{axle}", float(mode.frequency))
    return found


def _velocities(car: Simulation, wheels: tuple[int, int], joint: str) -> list[int]:
    """Places of an axle's joints among the velocities."""
    return [int(car.model.joint(f"{WHEELS[w]}/{joint}").dofadr[0]) for w in wheels]


def _hop(mode: Mode, travels: list[int]) -> str | None:
    left, right = mode.shape[travels]
    together = mode.shares[travels].sum() > MOSTLY and np.real(left * np.conj(right)) > 0.0
    return "hop" if together else None


def _rotation(mode: Mode, spins: list[int], belts: list[int]) -> str | None:
    if mode.frequency < 5.0 or mode.shares[spins].sum() + mode.shares[belts].sum() < TURNING:
        return None
    return "in_phase" if np.sum(np.real(mode.shape[spins] * np.conj(mode.shape[belts]))) > 0.0 else "antiphase"
