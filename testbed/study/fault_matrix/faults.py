"""Rows and columns of the matrix: every sensor of the car, every kind of fault, and how large each is.

Sizes are declared: a few times what a sound sensor of the kind may be off, and what a driver would notice or a
controller act on. {sign} is drawn, {wheel} is drawn. Units as typed (`estimators.faults.targets`). One row holds the
four sensors of a kind, since which of the wheels it is makes no difference to what watches them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from estimators.faults.kind import SIGNAL, SIGNAL_RATE, find_kind
from estimators.faults.targets import find_target

KINDS = (
    "bias", "scale", "spike", "zero", "stuck", "noise", "hiss", "sine", "drift", "delay", "dropout", "intermittent",
    "swap", "teeth",
)  # fmt: skip
ALIKE = {"delay": "0.5", "dropout": "0.5", "intermittent": "0.3,1", "zero": "", "stuck": "", "swap": "", "teeth": "44"}
SINE = 2.0  # Hz
LONG, SHORT = 20, 6  # s watched: of a sensor that speaks once a second, of others


@dataclass(frozen=True)
class Sensor:
    """name: with {wheel} for one of four; bias, spike, noise: sizes, noise also of hiss and sine; drift: per s; scale:
    a factor; unit: as typed; watch: s from the fault's beginning."""

    name: str
    bias: float
    scale: float
    spike: float
    noise: float
    drift: float
    watch: int = SHORT

    @property
    def unit(self) -> str:
        """Of the numbers."""
        return find_target(self.name.format(wheel="fl")).unit

    @property
    def corner(self) -> bool:
        """Whether every wheel has one."""
        return "{wheel}" in self.name


SENSORS = (
    *(Sensor(f"imu/accel/{axis}", 0.5, 0.5, 5.0, 0.5, 0.3) for axis in "xyz"),
    *(Sensor(f"imu/gyro/{axis}", 2.0, 0.5, 20.0, 2.0, 1.0) for axis in "xyz"),
    Sensor("steering/angle", 20.0, 0.5, 100.0, 10.0, 10.0),
    Sensor("steering/motor_angle", 50.0, 0.8, 200.0, 20.0, 20.0),
    Sensor("steering/motor_demand", 50.0, 0.8, 200.0, 20.0, 20.0),
    Sensor("steering/pinion_angle", 5.0, 0.8, 50.0, 5.0, 5.0),
    Sensor("engine/torque", 60.0, 0.5, 300.0, 50.0, 20.0),
    Sensor("driveline/torque", 500.0, 0.5, 3000.0, 500.0, 200.0),
    Sensor("body/{wheel}/accel_z", 1.0, 0.8, 20.0, 1.0, 0.5),
    Sensor("hub/{wheel}/accel_z", 2.0, 0.8, 50.0, 3.0, 1.0),
    Sensor("wheel/{wheel}", 3.0, 1.05, 10.0, 3.0, 2.0),
    Sensor("tyre/{wheel}/pressure", 40.0, 0.8, 60.0, 10.0, 2.0, LONG),
    Sensor("tyre/{wheel}/temperature", 20.0, 1.1, 40.0, 10.0, 2.0, LONG),
)
SPIKES = ",0.05"  # share of the samples


@dataclass(frozen=True)
class Cell:
    """sensor: of the row; kind: of the column; what: kind and numbers, {sign} for one that is drawn."""

    sensor: Sensor
    kind: str
    what: str

    @property
    def name(self) -> str:
        """Of its rows: `hub/WHEEL/accel_z=bias`."""
        return f"{self.sensor.name.format(wheel='WHEEL')}={self.kind}"

    @property
    def shown(self) -> str:
        """Kind and numbers with their unit, for a reader."""
        kind = find_kind(self.kind)
        units = [number.unit.replace(SIGNAL, self.sensor.unit) for number in kind.numbers]
        return " ".join((self.what.format(sign="±"), *units[:1])).strip()

    def text(self, wheel: str, sign: str, start: float) -> str:
        """The fault as it is typed. An axis whose whole message is hit gives its sensor's name."""
        name = self.sensor.name.format(wheel=wheel)
        if find_kind(self.kind).whole and find_target(name).column is not None:
            name = name.rpartition("/")[0]
        return f"{name}={self.what.format(sign=sign)}@{start:.4f}"


def cells() -> Iterator[Cell]:
    """Every fault that a sensor can have, row by row."""
    for sensor in SENSORS:
        for kind in KINDS:
            if (kind == "swap" and not sensor.corner) or (kind == "teeth" and not sensor.name.startswith("wheel/")):
                continue
            yield Cell(sensor, kind, _what(sensor, kind))


def _what(sensor: Sensor, kind: str) -> str:
    if kind in ALIKE:
        return f"{kind}:{ALIKE[kind]}".rstrip(":")
    if kind in ("hiss", "sine"):
        return f"{kind}:{sensor.noise:g}" + (f",{SINE:g}" if kind == "sine" else "")
    size = getattr(sensor, kind)
    signed = any(number.unit in (SIGNAL, SIGNAL_RATE) for number in find_kind(kind).numbers) and kind != "noise"
    return f"{kind}:{'{sign}' if signed else ''}{size:g}{SPIKES if kind == 'spike' else ''}"
