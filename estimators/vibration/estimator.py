"""Estimator `vibration`: natural frequencies of the two rotational modes of each wheel (Persson, Gustafsson, Drevo,
SAE 2002-01-1250, with a Whittle fit instead of the least-squares AR(2), whose frequency noise moves).

Estimates, each second: `fl/antiphase_frequency` and `fl/in_phase_frequency` [Hz], undamped natural frequencies, see
`modes` for which is heard at which speed. The std holds the spectrum's own (at the Cramer-Rao bound), and what roads
and speeds do to the frequency; without excitation it grows to the prior's within a minute or two, and a flag says so.
What it learns of a car is its tooth rings. Pressure and alarms are not its business: frequencies of sound tyres differ
from car to car, so that needs a reference.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from estimators.car import Car
from estimators.drive_log import Signal
from estimators.estimator import Estimate, Estimator, Flag, Outputs
from estimators.vibration.vibration import READS, Vibration
from estimators.vibration.wheel_vibration import Reading

UNKNOWN = 0.5  # of the prior's std, from which a frequency counts as not heard
PATIENCE = 30.0  # s that a wheel may take until it is first heard: a batch of the published method


class VibrationEstimator(Estimator):
    name = "vibration"
    reads = READS
    requires = ()
    requires_any = READS  # each wheel speaks for itself

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._vibration = Vibration(car)
        self._heard: dict[str, bool] = {}
        self._listening: dict[str, float] = {}  # by wheel, since when [s]

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """Start from tooth rings learnt before."""
        self._vibration.use_calibration(document)

    def calibration(self) -> dict[str, Any] | None:
        """Tooth rings by wheel."""
        return self._vibration.calibration()

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        heard = self._vibration.update(samples, until)
        running = [reading for reading in heard.readings if reading.kind == "running"]
        columns: dict[str, list[Reading]] = {}
        for reading in running:
            columns.setdefault(f"{reading.wheel}/{reading.mode.name}_frequency", []).append(reading)
        estimates = {
            name: Estimate(
                np.array([r.time for r in column]),
                np.array([r.frequency for r in column]),
                np.array([_std(r) for r in column]),
                "Hz",
            )
            for name, column in columns.items()
        }
        return Outputs(estimates, (), tuple(sorted([*heard.flags, *self._unheard(running)])))

    def _unheard(self, running: list[Reading]) -> list[Flag]:
        """Wheels of which no mode is any longer, or not yet, much better known than before the drive."""
        best: dict[tuple[str, float], float] = {}
        for r in running:
            key = (r.wheel, r.time)
            best[key] = min(best.get(key, math.inf), r.ln_std / r.mode.frequency_std)
        flags = []
        for (wheel, time), share in best.items():
            since = self._listening.setdefault(wheel, time)
            heard = share <= UNKNOWN
            if wheel not in self._heard and not heard and time < since + PATIENCE:
                continue
            if not heard and self._heard.get(wheel, True):
                flags.append(Flag(time, f"{wheel}: no mode is heard"))
            self._heard[wheel] = heard
        return flags


def _std(reading: Reading) -> float:
    return reading.frequency * math.hypot(reading.ln_std, reading.mode.road_std)
