"""What is known of both axles over one road: the maker's numbers, or those identified at known pressures.

Where nothing was identified, from `Car`: the body turns about its centre of gravity with pitch inertia M a b and roll
inertia M (`ROLL_GYRATION` track)^2, so that a force at one wheel moves the body over it by

    1 / m_s = l / (b M) + y^2 / I_x    (front; a for the rear)        1 / m_c = y_f y_r / I_x,    y: half the track

The identified document has besides `front`, `rear` (fields of `Quarter` without `hub_error`), `coupling` and
`wheelbase` what is left of a car that is no such model, over w tau, tau = wheelbase / v, over the mean m of ln k of
both axles above `REFERENCE`, and over speed, for each bin of `block`:

    ln |H_f| and ln |H_r|  +=  u . l        `level` (7, BINS)       u = (1, cos w tau, sin w tau,
    ln H_r                 +=  u . e        `ratio_real`, `ratio_imag`   m, m cos w tau, m sin w tau, ln v / `USUAL`)

and what no driving removes: `stiffness_std` of each ln k, `difference_std` of ln k_f - ln k_r. How well its numbers are
known it may say itself, both 0 where it does not: `told_std`, relative, of every number of both axles and the wheelbase
(`parameters`); `law_std`, relative, of the slope of the tyre's pressure law.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.axles.block import BINS, FREQUENCIES
from estimators.axles.response import Axles
from estimators.car import AXLES, Car
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.vertical_pressure.chain import Quarter
from estimators.vertical_pressure.corner import HUB_ERROR, SOFTER

REFERENCE = 250e3  # N/m, where m = 0
ROWS = 7  # of the tables
USUAL = 20.0  # m/s, where s = 0
ROLL_GYRATION = 0.39  # of the track: SUVs in NHTSA's inertia tables lie at 0.38 to 0.42
TOLD_STD, LAW_STD = 0.058, 0.115  # Declared: a drawing's numbers within 10 %, the law's slope within 20 %, uniform
MAKER_STD, MAKER_DIFFERENCE_STD = 0.06, 0.02  # Declared: what no such model tells, 15 kPa on the tuning car
QUARTER_FIELDS = tuple(name for name in Quarter._fields if name != "hub_error")
_TABLES = ("level", "ratio_real", "ratio_imag")
_NUMBERS = ("coupling", "wheelbase", "stiffness_std", "difference_std")
_SPREADS = ("told_std", "law_std")


@dataclass(frozen=True, eq=False)
class Identified:
    """level, ratio: see above, (7, BINS) each."""

    axles: Axles
    level: NDArray[np.float64]
    ratio: NDArray[np.complex128]
    stiffness_std: float
    difference_std: float
    told_std: float
    law_std: float

    def shape(self, speed: float, shift: float = 0.0) -> NDArray[np.complex128]:
        """Factors on H_f and H_r at a speed [m/s] and m = 0, (2, BINS); shift [m]: of the wheelbase."""
        return np.exp(self._logarithm(basis(0.0, speed, self.axles.wheelbase + shift)))

    def bend(self, speed: float, shift: float = 0.0) -> NDArray[np.complex128]:
        """What is added to ln H_f and ln H_r for m = 1, (2, BINS)."""
        at, none = (basis(m, speed, self.axles.wheelbase + shift) for m in (1.0, 0.0))
        return self._logarithm(at - none)

    def _logarithm(self, u: NDArray[np.float64]) -> NDArray[np.complex128]:
        common = np.sum(u * self.level, axis=0) + 0j
        return np.stack([common, common + np.sum(u * self.ratio, axis=0)])


def basis(m: float, speed: float, wheelbase: float) -> NDArray[np.float64]:
    """What the tables are multiplied by, u, (ROWS, BINS). speed [m/s]."""
    angle = 2.0 * np.pi * FREQUENCIES * wheelbase / speed
    turn = np.stack([np.ones(BINS), np.cos(angle), np.sin(angle)])
    return np.vstack([turn, m * turn, np.full((1, BINS), np.log(speed / USUAL))])


def maker_axles(car: Car) -> Identified:
    """From the car's drawing."""
    M, roll = car.chassis_mass, 0.25 / (ROLL_GYRATION**2 * car.chassis_mass)
    quarters = []
    for axle in AXLES:
        front = axle == "front"
        _, unsprung = quarter_masses(car, "fl" if front else "rl")
        opposite = car.cg_to_rear_axle if front else car.cg_to_front_axle
        quarters.append(
            Quarter(
                sprung_mass=1.0 / (car.wheelbase / (opposite * M) + roll),
                unsprung_mass=unsprung - car.tyre_belt_mass,
                belt_mass=car.tyre_belt_mass,
                spring_rate=car.front_spring_rate if front else car.rear_spring_rate,
                damping=car.front_damping if front else car.rear_damping,
                footprint=car.tyre_footprint,
                softer=SOFTER,
                hub_error=HUB_ERROR,
            )
        )
    axles = Axles(quarters[0], quarters[1], roll, car.wheelbase)
    tables = np.zeros((ROWS, BINS)), np.zeros((ROWS, BINS), complex)
    return Identified(axles, *tables, MAKER_STD, MAKER_DIFFERENCE_STD, TOLD_STD, LAW_STD)


def from_document(document: Mapping[str, Any]) -> Identified:
    """ValueError names what is wrong."""
    wanted = (*AXLES, *_NUMBERS, *_TABLES)
    for name in wanted:
        if name not in document:
            raise ValueError(f"calibration lacks {name!r}, valid: {', '.join(wanted)}, all of them")
    quarters = []
    for axle in AXLES:
        entry = document[axle]
        if not isinstance(entry, Mapping) or set(entry) != set(QUARTER_FIELDS):
            raise ValueError(f"calibration of {axle} is {entry!r}, valid: {', '.join(QUARTER_FIELDS)}, all of them")
        for name, value in entry.items():
            if not _number(value) or value <= 0.0:
                raise ValueError(f"calibration of {axle}: {name} is {value!r}, valid: a finite number above 0")
        quarters.append(Quarter(**{n: float(entry[n]) for n in QUARTER_FIELDS}, hub_error=HUB_ERROR))
    for name in _NUMBERS:
        if not _number(document[name]) or document[name] < 0.0 or (name == "wheelbase" and document[name] == 0.0):
            raise ValueError(f"calibration: {name} is {document[name]!r}, valid: a finite number from 0 on")
    spreads = {name: document.get(name, 0.0) for name in _SPREADS}
    for name, value in spreads.items():
        if not _number(value) or not 0.0 <= value < 1.0:
            raise ValueError(f"calibration: {name} is {value!r}, valid: a finite number from 0 to below 1")
    level, real, imag = (_table(name, document[name]) for name in _TABLES)
    axles = Axles(quarters[0], quarters[1], float(document["coupling"]), float(document["wheelbase"]))
    return Identified(
        axles,
        level,
        real + 1j * imag,
        float(document["stiffness_std"]),
        float(document["difference_std"]),
        float(spreads["told_std"]),
        float(spreads["law_std"]),
    )


def sound_from(entry: object) -> dict[str, tuple[float, float]]:
    """d = ln k_f - ln k_r and its std by side, as learnt on an earlier drive. ValueError names what is wrong."""
    if not isinstance(entry, Mapping) or not set(entry) <= {"left", "right"}:
        raise ValueError(f"calibration: sound is {entry!r}, valid: a difference and its std for left, right or both")
    found = {}
    for side, pair in entry.items():
        whole = isinstance(pair, (list, tuple)) and len(pair) == 2 and all(_number(v) for v in pair)
        if not whole or not pair[1] > 0.0:
            raise ValueError(f"calibration: sound of {side} is {pair!r}, valid: a difference and its std above 0")
        found[side] = (float(pair[0]), float(pair[1]))
    return found


def to_document(known: Identified) -> dict[str, Any]:
    """The inverse of `from_document`; JSON values."""
    quarters = (known.axles.front, known.axles.rear)
    return {
        **{a: {n: getattr(q, n) for n in QUARTER_FIELDS} for a, q in zip(AXLES, quarters, strict=True)},
        "coupling": known.axles.coupling,
        "wheelbase": known.axles.wheelbase,
        "stiffness_std": known.stiffness_std,
        "difference_std": known.difference_std,
        "told_std": known.told_std,
        "law_std": known.law_std,
        "level": known.level.tolist(),
        "ratio_real": known.ratio.real.tolist(),
        "ratio_imag": known.ratio.imag.tolist(),
    }


def _number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and bool(np.isfinite(value))


def _table(name: str, rows: object) -> NDArray[np.float64]:
    try:
        table = np.asarray(rows, dtype=np.float64)
    except (TypeError, ValueError):
        table = np.empty(0)
    if table.shape != (ROWS, BINS) or not np.isfinite(table).all():
        raise ValueError(f"calibration: {name} has shape {table.shape}, valid: ({ROWS}, {BINS}) finite numbers")
    return table
