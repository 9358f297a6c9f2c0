"""A scenario: everything that decides a drive. Frozen, checked, saved with the result; the same scenario gives the same
bytes.

SI throughout. Field names are those of the saved JSON.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from estimators.drive_log import WHEELS
from estimators.faults import parse_fault
from testbed.brake_pull import BrakePull
from testbed.tyre.inflation import Leak, PressureSet

FASTEST = 200.0 / 3.6  # m/s
LONGEST = 24.0 * 3600.0  # s
ACTIVE_STEERING_SENSORS = ("steering/motor_angle", "steering/motor_demand", "steering/pinion_angle")
DRIVEN = ("front", "rear", "all")

# field, lowest, highest, unit: each must be a finite number within
RANGES = (
    ("speed", 0.0, FASTEST, "m/s"),
    ("duration", 0.01, LONGEST, "s"),
    ("payload", 0.0, 1000.0, "kg"),
    ("grade", -0.3, 0.3, "-"),
    ("bank", -0.2, 0.2, "-"),
    ("wind", 0.0, 40.0, "m/s"),
    ("wind_from", -2.0 * math.pi, 2.0 * math.pi, "rad"),
    ("gusts", 0.0, 1.0, "-"),
    ("ambient", 233.15, 333.15, "K"),
    ("step", 1e-5, 1e-3, "s"),
)
PRESSURE_RANGE = (0.0, 500e3)  # Pa, gauge
FARTHEST_LOAD = 3.0  # m from the chassis' centre of gravity, along each axis
SENSOR_STEP = 1e-3  # s of the grid on which the sensors are fed: a whole number of steps
Entry = TypeVar("Entry", Leak, PressureSet, BrakePull)
ENTRIES: dict[str, type] = {"leaks": Leak, "pressure_sets": PressureSet, "brake_pulls": BrakePull}
TEXTS = ("road", "manoeuvre", "tyre", "friction", "driven")
TUPLES = ("payload_position", "obstacles", "faults")
MAPPINGS = ("pressures", "leaks", "pressure_sets", "radius_factor", "brake_pulls", "sensors")


def _number(value: object) -> bool:
    """Whether it is a number of a size that any field could have."""
    return isinstance(value, int | float) and not isinstance(value, bool) and not abs(value) > 1e15


def _entries(name: str, kind: type[Entry], given: object) -> object:
    """Leaks, pressure sets or brake pulls of saved notes; what is no mapping is left for the scenario's own check."""
    if not isinstance(given, Mapping):
        return given
    wanted = {f.name for f in dataclasses.fields(kind)}
    for wheel, entry in given.items():
        if not isinstance(entry, Mapping) or not set(entry) <= wanted:
            raise ValueError(f"{name} of {wheel} is {entry!r}, want {', '.join(sorted(wanted))}")
    return {wheel: kind(**entry) for wheel, entry in given.items()}


@dataclass(frozen=True)
class Scenario:
    """road, manoeuvre, tyre: as on the command line. speed [m/s], duration [s], payload [kg] at payload_position [m]
    from the chassis' centre of gravity, pressures [Pa gauge] and radius_factor [-] by wheel, ambient [K], grade and
    bank [-]. wind: mean speed [m/s], wind_from: where it comes from [rad], 0 against a car that drives along x, a
    quarter turn from the left; gusts: their std over the mean [-]. brake_pulls: by wheel. faults: of sensors, as on the
    command line. seed: of road and sensors; car_seed: of what differs from one sensor to the next of its kind, None: as
    seed. active_steering: whether the car has it; steering_lock: when its motor is locked [s], None: never;
    faults_in_loop: whether its control works on the faulty motor_angle, or only the log shows the fault."""

    road: str = "C"
    speed: float = 80.0 / 3.6
    duration: float = 60.0
    manoeuvre: str = "constant"
    tyre: str = "suv-235-60r18"
    seed: int = 0
    car_seed: int | None = None
    pressures: Mapping[str, float] = field(default_factory=dict)
    leaks: Mapping[str, Leak] = field(default_factory=dict)
    pressure_sets: Mapping[str, PressureSet] = field(default_factory=dict)
    radius_factor: Mapping[str, float] = field(default_factory=dict)
    brake_pulls: Mapping[str, BrakePull] = field(default_factory=dict)
    payload: float = 0.0
    payload_position: tuple[float, float, float] = (-0.6, 0.0, 0.0)
    friction: str = "1.0"
    grade: float = 0.0
    bank: float = 0.0
    wind: float = 0.0
    wind_from: float = 0.0
    gusts: float = 0.15
    obstacles: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    driven: str = "front"
    ambient: float = 293.15
    sensors: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    step: float = 1e-3
    active_steering: bool = False
    steering_lock: float | None = None
    faults_in_loop: bool = False

    def _check_kinds(self) -> None:
        """ValueError where a field does not hold what it should: only a scenario from a file can be so wrong."""
        for name in TEXTS:
            if not isinstance(getattr(self, name), str):
                raise ValueError(f"{name} {getattr(self, name)!r} is not a text")
        for name in MAPPINGS:
            if not isinstance(getattr(self, name), Mapping):
                raise ValueError(f"{name} {getattr(self, name)!r} is not a mapping")
        for text in self.obstacles:
            if not isinstance(text, str):
                raise ValueError(f"obstacle {text!r} is not a text")
        self._check_steering()
        timed: list[Leak | PressureSet | BrakePull] = [
            entry for name in ENTRIES for entry in getattr(self, name).values()
        ]
        by_wheel = (*self.pressures.values(), *self.radius_factor.values())
        for value in (*by_wheel, *(v for entry in timed for v in dataclasses.astuple(entry))):
            if not _number(value):
                raise ValueError(f"{value!r} of a wheel is not a number")
        for name, seed in (("seed", self.seed), ("car_seed", self.seed if self.car_seed is None else self.car_seed)):
            if not isinstance(seed, int) or isinstance(seed, bool) or not 0 <= seed < 2**63:
                raise ValueError(f"{name} {seed!r} is not valid; want a whole number from 0 to 2^63 - 1")
        place = self.payload_position
        if len(place) != 3 or not all(_number(v) and abs(v) <= FARTHEST_LOAD for v in place):
            raise ValueError(f"payload position {list(place)} m: want x, y, z, each within +-{FARTHEST_LOAD:g} m")

    def _check_steering(self) -> None:
        """ValueError for active steering that is no choice, or sensors of it in a car without."""
        for name in ("active_steering", "faults_in_loop"):
            if not isinstance(getattr(self, name), bool):
                raise ValueError(f"{name} {getattr(self, name)!r} is not valid; want true or false")
        names = [name for text in self.faults for name in parse_fault(text).target.signals]
        if not self.active_steering:
            if lacking := [name for name in names if name in ACTIVE_STEERING_SENSORS]:
                raise ValueError(f"fault of {lacking[0]}: the car has no active steering (--active-steering)")
            if self.faults_in_loop:
                raise ValueError("faults in the loop: the car has no active steering (--active-steering)")
            if self.steering_lock is not None:
                raise ValueError(f"lock of the steering at {self.steering_lock} s: the car has no active steering")
        elif self.steering_lock is not None and not (_number(self.steering_lock) and self.steering_lock >= 0.0):
            raise ValueError(f"lock of the steering at {self.steering_lock} s; valid: a time of 0 s or later")

    def __post_init__(self) -> None:
        self._check_kinds()
        for name, low, high, unit in RANGES:
            value = getattr(self, name)
            if not (_number(value) and math.isfinite(value) and low <= value <= high):
                raise ValueError(f"{name} {value} {unit} is out of range; valid: {low:g} to {high:g} {unit}")
        if abs(SENSOR_STEP / self.step - round(SENSOR_STEP / self.step)) > 1e-9:
            raise ValueError(f"step {self.step:g} s does not divide {SENSOR_STEP:g} s; valid: 1e-3, 5e-4, 2.5e-4 ...")
        if self.driven not in DRIVEN:
            raise ValueError(f"unknown driven axle {self.driven!r}; valid: {', '.join(DRIVEN)}")
        for names in (getattr(self, name) for name in MAPPINGS if name != "sensors"):
            for wheel in names:
                if wheel not in WHEELS:
                    raise ValueError(f"unknown wheel {wheel!r}; valid: {', '.join(WHEELS)}")
        low, high = PRESSURE_RANGE
        wanted = [*self.pressures.items(), *((w, s.pressure) for w, s in self.pressure_sets.items())]
        for wheel, pressure in wanted:
            if not low <= pressure <= high:
                raise ValueError(
                    f"pressure {wheel}={pressure / 1e3:g} kPa is out of range; valid: 0 to {high / 1e3:g} kPa"
                )
        for wheel, leak in self.leaks.items():
            if not (0.0 < leak.rate <= 1e6 and 0.0 <= leak.start < math.inf):
                raise ValueError(
                    f"leak {wheel}={leak.rate / 1e3:g}@{leak.start:g} is out of range; valid: a rate above 0 up to "
                    "1000 kPa/s and a start of 0 s or later"
                )
        for wheel, change in self.pressure_sets.items():
            if not (0.0 <= change.start < math.inf and 0.0 < change.duration < math.inf):
                raise ValueError(
                    f"set {wheel} at {change.start:g} s within {change.duration:g} s is out of range; "
                    "valid: a start of 0 s or later and a duration above 0 s"
                )
        for wheel, pull in self.brake_pulls.items():
            pull.check(wheel)
        for wheel, factor in self.radius_factor.items():
            if not 0.9 <= factor <= 1.1:
                raise ValueError(f"radius {wheel}={100 * (factor - 1):g} % is out of range; valid: -10 to 10 %")

    def as_notes(self) -> dict[str, Any]:
        """JSON values; `from_notes` gives the scenario back."""
        notes = dataclasses.asdict(self)
        for name in TUPLES:
            notes[name] = list(getattr(self, name))
        return notes

    @staticmethod
    def from_notes(notes: Mapping[str, Any]) -> Scenario:
        """The scenario of saved notes. ValueError names an unknown field."""
        known = {f.name for f in dataclasses.fields(Scenario)}
        odd = sorted(set(notes) - known)
        if odd:
            raise ValueError(f"unknown scenario field {odd[0]!r}; valid: {', '.join(sorted(known))}")
        values = dict(notes)
        for name in TUPLES:
            if name in values:
                if not isinstance(values[name], Sequence) or isinstance(values[name], str):
                    raise ValueError(f"{name} is {values[name]!r}, want a list")
                values[name] = tuple(values[name])
        for name, kind in ENTRIES.items():
            values[name] = _entries(name, kind, values.get(name, {}))
        return Scenario(**values)
