"""The study's tasks: scenarios as JSON values, by kind.

    classes     Table 4: road class A to D, speed 40 to 80 km/h, each tyre 130 to 230 kPa, 60 s
    levels      the same with the road's level anywhere from the lower limit of class A to the upper one of D; the
                estimators also listen with wrong knowledge
    short       as `levels`, one drive in each class, as long as the bias is asked after; estimators alone, not the
                published filters
    switch      class A for 5 s, then class D (Figure 9)
    drop        class B, all tyres from 230 to 180 kPa in 1.5 s (Figure 10)
    mass        class B, payload 0, +8 % and +24 % of the body's mass, on one road (Figure 11)
    waviness    roads of one slope that is not -2, 30 s; estimators alone
    measured    the measured road (Figures 12 and 13)
    show        class A and class D (Figures 7 and 8); only in the first repetition
    fit         one drive for Figure 5; only in the first repetition

Changes and what follows from them need fewer drives than errors do: every EACH-th repetition has them, every
ALARM_EACH-th the drives of the alarm (`axle_alarm`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from estimators.drive_log import WHEELS
from estimators.quarter_car.road_shape import class_spectrum
from estimators.quarter_car.roughness import REFERENCE
from testbed.roads.iso8608 import class_gd
from testbed.scenario import Scenario
from testbed.study.study import Task, run_seed
from testbed.study.vertical_pressure.axle_alarm import alarm_task
from testbed.study.vertical_pressure.told import CLASSES, HIGHEST, LOWEST
from testbed.tyre.inflation import PressureSet

SPEEDS = (40.0 / 3.6, 80.0 / 3.6)  # m/s, Table 4
LEVELS = (0.5 * class_spectrum("A"), 2.0 * class_spectrum("D"))  # G at 1 rad/m [m^3/rad]: the limits of A and D
LONG, SHORT = 60.0, 10.6  # s; the short form ends when what was heard in 10 s has been said
EACH, ALARM_EACH = 5, 4
SHOWN_SPEED, SHOWN_PRESSURE = 60.0 / 3.6, 180e3
SWITCH_AT, SWITCH_LONG = 5.0, 20.0
DROP_AT, DROP_WITHIN, DROP_LONG = 15.0, 1.5, 60.0
BEFORE_DROP, AFTER_DROP = 230e3, 180e3
MASSES = {"0": 0.0, "8": 140.0, "24": 430.0}  # kg: 1928 and 2218 kg in place of 1788, as published
MASS_LONG = 30.0
MEASURED_LONG = 30.0  # s: 500 m of the 544 at 60 km/h
WAVINESSES, WAVY_LONG = (1.8, 2.2, 2.5, 3.0), 30.0  # -, s
SMALL = 0.2  # of the durations
KINDS = ("classes", "levels", "short", "switch", "drop", "mass", "waviness", "measured", "show", "fit")


def gd_road(spectrum: float) -> str:
    """The scenario's word for a level G at 1 rad/m [m^3/rad]."""
    return f"gd={spectrum / (2.0 * math.pi * 0.01):.6g}"


def wavy_road(waviness: float) -> str:
    """Of one slope, as rough as class B at `roughness.REFERENCE` rad/m, where level and slope part."""
    reference = REFERENCE / (2.0 * math.pi)  # cycle/m
    return f"gd={class_gd('B') * (reference / 0.1) ** (waviness - 2.0):.6g}^{waviness:g}"


def nearest_class(spectrum: float) -> str:
    """ISO 8608 class of a level [m^3/rad], A and D with what lies beyond."""
    place = round(math.log(spectrum / class_spectrum("A")) / math.log(4.0))
    return CLASSES[min(max(place, 0), len(CLASSES) - 1)]


def tasks(seed: int, number: int, small: bool, measured: Path | None) -> list[Task]:
    """Of repetition `number`; measured: file of the measured road."""
    alarm = [alarm_task(seed, number, small)] if number % ALARM_EACH == 0 else []
    return [*_Repetition(seed, number, small).tasks(measured), *alarm]


class _Repetition:
    def __init__(self, seed: int, number: int, small: bool) -> None:
        self._seed, self._number, self._small = seed, number, small

    def _one(self, kind: str, purpose: int, road: str, spectrum: float, duration: float, **fields: Any) -> Task:
        """The measured road's level is not drawn: spectrum NaN is null."""
        seed = run_seed(self._seed, self._number, purpose)
        rng = np.random.default_rng(seed)
        drawn: dict[str, Any] = {
            "speed": float(rng.uniform(*SPEEDS)),
            "pressures": dict(zip(WHEELS, rng.uniform(LOWEST, HIGHEST, len(WHEELS)).tolist(), strict=True)),
        }
        length = max(SMALL * duration, 3.0) if self._small else duration
        scenario = Scenario(road=road, duration=length, seed=seed, **(drawn | fields))
        return {
            "kind": kind, "number": self._number, "seed": seed, "scenario": scenario.as_notes(),
            "spectrum": None if math.isnan(spectrum) else spectrum,
        }  # fmt: skip

    def tasks(self, measured: Path | None) -> Iterator[Task]:
        rng = np.random.default_rng(run_seed(self._seed, self._number))
        road = CLASSES[int(rng.integers(len(CLASSES)))]
        yield self._one("classes", 1, road, class_spectrum(road), LONG)
        level = float(np.exp(rng.uniform(*np.log(LEVELS))))
        yield self._one("levels", 2, gd_road(level), level, LONG)
        for i, name in enumerate(CLASSES[: 1 if self._small else None]):
            level = class_spectrum(name) * float(np.exp(rng.uniform(-math.log(2.0), math.log(2.0))))
            yield self._one("short", 10 + i, gd_road(level), level, SHORT)
        if self._number % EACH == 0:
            yield from self._changes(measured)
        if self._number == 0:
            shown = {"speed": SHOWN_SPEED, "pressures": dict.fromkeys(WHEELS, SHOWN_PRESSURE)}
            for i, name in enumerate("AD"):
                yield self._one("show", 30 + i, name, class_spectrum(name), 10.0, **shown)
            yield self._one("fit", 40, "B", class_spectrum("B"), 8.0, **shown)

    def _changes(self, measured: Path | None) -> Iterator[Task]:
        scale = SMALL if self._small else 1.0
        shown: dict[str, Any] = {"speed": SHOWN_SPEED}
        first = scale * SWITCH_AT * SHOWN_SPEED
        yield self._one("switch", 20, f"A:{first:.6g},D:2000", class_spectrum("D"), SWITCH_LONG, **shown)
        change = {wheel: PressureSet(AFTER_DROP, scale * DROP_AT, DROP_WITHIN) for wheel in WHEELS}
        start = dict.fromkeys(WHEELS, BEFORE_DROP)
        yield self._one("drop", 21, "B", class_spectrum("B"), DROP_LONG, **shown, pressures=start, pressure_sets=change)
        for percent, payload in MASSES.items():
            heavy = self._one(
                "mass", 22, "B", class_spectrum("B"), MASS_LONG, **shown, payload=payload,
                payload_position=(0.0, 0.0, 0.0),
            )  # fmt: skip
            yield heavy | {"percent": percent}
        for i, waviness in enumerate(WAVINESSES[: 1 if self._small else None]):
            yield self._one("waviness", 50 + i, wavy_road(waviness), math.nan, WAVY_LONG) | {"waviness": waviness}
        if measured is not None:
            yield self._one("measured", 25, str(measured), math.nan, MEASURED_LONG, **shown)
