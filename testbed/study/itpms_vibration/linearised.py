"""Natural frequencies and damping ratios of the rotational modes at three pressures, from the linearised car."""

from __future__ import annotations

from functools import cache

import numpy as np

from estimators.drive_log import WHEELS
from testbed.modes import rotational_modes
from testbed.scenario import Scenario
from testbed.simulation import Simulation


@cache
def mode_at(speed: float, ratio: float, nominal: float = 250e3) -> dict[str, dict[str, tuple[float, float]]]:
    """(frequency [Hz], damping ratio) by axle and `in_phase`, `antiphase`; speed [km/h], ratio of nominal pressure."""
    pressures = dict.fromkeys(WHEELS, ratio * nominal)
    car = Simulation(Scenario(road="flat", speed=speed / 3.6, duration=1.0, pressures=pressures))
    return {
        axle: {kind: (mode.frequency, mode.damping) for kind, mode in kinds.items()}
        for axle, kinds in rotational_modes(car).items()
    }


def sensitivity(kind: str, speed: float, low: float) -> float:
    """d ln f / d ln p of a mode between nominal pressure and `low` of it, mean of the axles, at a speed [km/h]."""
    change = [
        np.log(mode_at(speed, low)[axle][kind][0] / mode_at(speed, 1.0)[axle][kind][0]) for axle in ("front", "rear")
    ]
    return float(np.mean(change) / np.log(low))
