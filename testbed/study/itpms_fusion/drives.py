"""The drives of a repetition, each a name and what happens in it.

    calibration      LEARNING seconds on sound tyres
    sound            SOUND seconds on sound tyres
    15x2_leak, ...   after BEFORE seconds (give or take JITTER) tyres lose that share of their pressure of the moment,
                     in SUDDEN seconds or LEAK seconds; watched for WATCH seconds once it is lost
    r141_puncture, r141_diffusion, fmvss_138     tyres low from the start of the drive, for as long as the rule allows
    other_speed, worn, fast, four_at_once        the same for cases in which production systems failed on the road

A drive from the start on low tyres is on the day of the calibration (same radii), as the rules' procedures are.
Regulations and off-calibration cases take turns over the repetitions.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimators.drive_log import WHEELS
from models.tyre_properties import load_tyre
from testbed.scenario import Scenario
from testbed.study.itpms_fusion.cars import RepetitionCar, own_seed
from testbed.tyre.inflation import PressureSet
from testbed.tyre.wear import worn_factors

LEARNING, SOUND = 600.0, 600.0  # s
BEFORE, JITTER = 180.0, 30.0  # s
SUDDEN, LEAK = 1.0, 120.0  # s
WATCH = 180.0  # s
ENDURANCE = 600.0  # s for the off-calibration cases
LOSSES = (
    *((0.15, tyres, kind) for tyres in (1, 2, 3, 4) for kind in ("sudden", "leak")),
    (0.10, 1, "sudden"), (0.25, 1, "sudden"), (0.25, 2, "sudden"), (0.25, 3, "sudden"),
)  # fmt: skip
# name: tyres, loss, s allowed
REGULATIONS = {
    "r141_puncture": (1, 0.20, 600.0), "r141_diffusion": (4, 0.20, 3600.0), "fmvss_138": (1, 0.25, 1200.0),
}  # fmt: skip
OFF_CALIBRATION = {"other_speed": 1, "worn": 1, "fast": 1, "four_at_once": 4}  # tyres, of which each has lost:
OFF_LOSS = 0.20
SLOW, QUICK, FAST = 55.0 / 3.6, 110.0 / 3.6, 140.0 / 3.6  # m/s
WORN = 2.5e-3  # m of tread left
SMALL = 0.3  # of the times of the small form


@dataclass(frozen=True)
class Drive:
    """share: of the pressure at `onset` [s] that `wheels` lose within `within` [s]; onset 0: low from the start. tyre:
    factors on the tyre's properties; calibration: name of the drive that the estimator learns on."""

    name: str
    scenario: Scenario
    wheels: tuple[str, ...] = ()
    share: float = 0.0
    onset: float = 0.0
    within: float = 0.0
    tyre: dict[str, float] = dataclasses.field(default_factory=dict)
    calibration: str = "calibration"

    def as_json(self) -> dict[str, Any]:
        """JSON values; `from_json` gives it back."""
        return dataclasses.asdict(self) | {"scenario": self.scenario.as_notes(), "wheels": list(self.wheels)}

    @classmethod
    def from_json(cls, values: dict[str, Any]) -> Drive:
        known = {"scenario": Scenario.from_notes(values["scenario"]), "wheels": tuple(values["wheels"])}
        return cls(**(values | known))


def name_of(share: float, tyres: int, kind: str) -> str:
    """`15x2_leak`."""
    return f"{100 * share:.0f}x{tyres}_{kind}"


def drives(seed: int, number: int, small: bool) -> list[Drive]:
    """All of repetition `number`, each after the calibration it needs."""
    car = RepetitionCar(seed, number)
    rng = np.random.default_rng(own_seed(seed, number, 10_000))
    scale = SMALL if small else 1.0
    first = car.day(0, 180.0, manoeuvre="motorway", speed=QUICK) if small else car.day(0, LEARNING)
    found = [Drive("calibration", first, tyre=car.tyre), Drive("sound", car.day(1, scale * SOUND), tyre=car.tyre)]
    for place, (share, tyres, kind) in enumerate(LOSSES[::9] if small else LOSSES):
        onset = float(round(scale * (BEFORE + rng.uniform(-JITTER, JITTER))))
        within = SUDDEN if kind == "sudden" else scale * LEAK
        scenario = car.day(2 + place, onset + within + scale * WATCH)
        found.append(_lost(name_of(share, tyres, kind), scenario, car, rng, tyres, share, onset, within))
    if not small:
        found += _regulation(car, first, number, rng)
        found += _off_calibration(car, number, rng)
    return found


def _lost(
    name: str, scenario: Scenario, car: RepetitionCar, rng: np.random.Generator, tyres: int, share: float,
    onset: float, within: float,
) -> Drive:  # fmt: skip
    wheels = tuple(WHEELS[w] for w in sorted(rng.choice(4, tyres, replace=False).tolist()))
    sets = {wheel: PressureSet((1.0 - share) * scenario.pressures[wheel], onset, within) for wheel in wheels}
    lossy = dataclasses.replace(scenario, pressure_sets=sets)
    return Drive(name, lossy, wheels, share, onset, within, car.tyre)


def _low_from_start(
    name: str, scenario: Scenario, tyres: int, share: float, rng: np.random.Generator, tyre: dict[str, float],
    calibration: str = "calibration",
) -> Drive:  # fmt: skip
    wheels = tuple(WHEELS[w] for w in sorted(rng.choice(4, tyres, replace=False).tolist()))
    low = {w: (1.0 - share) * p if w in wheels else p for w, p in scenario.pressures.items()}
    return Drive(name, dataclasses.replace(scenario, pressures=low), wheels, share, tyre=tyre, calibration=calibration)


def _same_day(car: RepetitionCar, purpose: int, duration: float, first: Scenario, **fields: Any) -> Scenario:
    """Another road on the day of `first`: its radii, its load, its weather."""
    kept = ("radius_factor", "pressures", "ambient", "payload", "payload_position", "wind")
    return car.day(purpose, duration, **({name: getattr(first, name) for name in kept} | fields))


def _regulation(car: RepetitionCar, first: Scenario, number: int, rng: np.random.Generator) -> Iterator[Drive]:
    name = list(REGULATIONS)[number % len(REGULATIONS)]
    tyres, share, allowed = REGULATIONS[name]
    yield _low_from_start(name, _same_day(car, 40, allowed, first), tyres, share, rng, car.tyre)


def _off_calibration(car: RepetitionCar, number: int, rng: np.random.Generator) -> Iterator[Drive]:
    name = list(OFF_CALIBRATION)[number % len(OFF_CALIBRATION)]
    tyres, tyre, radii = OFF_CALIBRATION[name], dict(car.tyre), car.radii
    if name == "worn":
        factors, radius = worn_factors(load_tyre(), WORN)
        tyre |= factors
        radii = radii * radius
    same = {"radius_factor": dict(zip(WHEELS, radii.tolist(), strict=True)), "manoeuvre": "motorway"}
    slow = car.day(50, LEARNING, speed=QUICK if name == "worn" else SLOW, **same)
    yield Drive(f"{name}_calibration", slow, tyre=tyre)
    quick = _same_day(car, 51, ENDURANCE, slow, speed=FAST if name == "fast" else QUICK, manoeuvre="motorway")
    yield _low_from_start(name, quick, tyres, OFF_LOSS, rng, tyre, f"{name}_calibration")
