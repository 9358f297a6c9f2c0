"""Estimator `vertical_pressure`: vertical stiffness and pressure of each tyre from its hub's acceleration, on any road.

Seed: Brancati & Tufano, Machines 2022, 10, 1221. Their filters are given a road that no car knows (`unscented_imm`);
here the road is noise of unknown level and unknown slopes (`quarter_car.roughness`), and a bank of linear filters over
stiffness and road is weighted by likelihood (`bank`, `posterior`), which reaches the Cramer-Rao bound
(`quarter_car.bound`). Estimates each `SAY` blocks (half a second):

    WHEEL/stiffness    at the present static load and speed [N/m]
    AXLE/load          sprung mass that front or rear bears, over the empty car's [-] (`payload`)
    WHEEL/pressure     by the maker's tyre law, taken for exact [Pa]
    WHEEL/pressure_bound  the least std of the pressure that any method could state by now (`limit`) [Pa]
    WHEEL/road_level   log4 of G(1 rad/m) over 1e-6 m^3/rad: 0 is the middle of ISO 8608 class A, 1 of B, 3 of D [-]
    WHEEL/waviness     how steeply the road's spectrum falls for waves below 6 m: 2 by ISO 8608 [-]
    road/A ... road/D  probability of each class, mean of the wheels; A and D with what lies beyond [-]

The std holds a relative share that no driving removes (`corner`). Says nothing below `SLOWEST`, where the road's short
waves are shorter than the footprint, and learns nothing where the hub hears no road (`bank.QUIET`). Of the body's
acceleration comes the load, without it the car counts as empty, with a std that says so; it tells nothing of the
stiffness (`innovations`). What it cannot see: a load on one side; the sensor's scale error does not matter.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import AXLES, GRAVITY, Car
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Estimate, Estimator, Flag, Outputs
from estimators.grid import Channel
from estimators.grid_blocks import GridBlocks
from estimators.quarter_car.gravity import GravityCheck, not_gravity
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.roughness import WAVINESS
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.vertical_pressure.bank import QUIET, AxleBank, heard_by
from estimators.vertical_pressure.corner import (
    TYRES,
    Corner,
    beside,
    expected_pressure,
    from_document,
    maker_corner,
    to_document,
)
from estimators.vertical_pressure.intake import BLOCK, HubIntake
from estimators.vertical_pressure.limit import Limit
from estimators.vertical_pressure.payload import Payload
from estimators.vertical_pressure.posterior import FINE_SHORT, LOG_LEVEL, LOG_STIFFNESS, Posterior, moments
from estimators.vertical_pressure.prediction import MEMORY

SAY = 2  # blocks from one estimate to the next
SLOWEST, FASTEST = 7.0, 90.0  # m/s
CLASSES = "ABCD"
PER_LOAD = 0.27  # ln k_t, and what the law adds, per ln of load that is not known: measured with none known
USUAL_SPEED = 20.0  # m/s of the prior
_MS = 1e-3
# log4 of G(1 rad/m), (shorts, levels): w_s - 2 more than that of lambda (`quarter_car.roughness`)
_LEVEL = (LOG_LEVEL - np.log(1e-6)) / np.log(4.0) + (FINE_SHORT[:, None] - WAVINESS)
_CLASS = np.clip(np.rint(_LEVEL), 0, len(CLASSES) - 1).astype(int)
CHANNELS = (
    *(Channel(f"hub/{wheel}/accel_z") for wheel in WHEELS),
    *(Channel(f"wheel/{wheel}/speed") for wheel in WHEELS),
    *(Channel(f"body/{wheel}/accel_z") for wheel in WHEELS),
)
NEEDED = 8  # of them; the rest tell the load


class _Wheel:
    """One tyre: its samples, filters and what they are believed."""

    def __init__(self, car: Car, name: str, expected: tuple[float, float]) -> None:
        """expected: mean and std of the pressure before anything was heard [Pa]."""
        self.name = name
        self._masses = quarter_masses(car, name)
        prior = _prior(car, self.load(1.0), *expected)
        self.intake, self.posterior = HubIntake(), Posterior(prior)
        self.limit = Limit(prior)
        self._past = np.zeros(MEMORY)

    def load(self, laden: float) -> float:
        """Static, on the ground [N]; laden: sprung mass over the empty car's."""
        sprung, unsprung = self._masses
        return (laden * sprung + unsprung) * GRAVITY

    def step(self, value: NDArray[np.float64], bank: AxleBank, speed: float, load: float) -> None:
        """A block of 1 kHz samples; speed [m/s], NaN or out of range: only time passes; load: of the sprung mass."""
        self.pass_time(BLOCK * _MS)
        samples = self.intake.block(value)
        if samples is None or not SLOWEST <= speed <= FASTEST:
            self.intake.restart()
            return
        heard = np.concatenate([self._past, samples])
        self._past = heard[len(samples) :]
        if self.intake.settling > 0:
            self.intake.settling -= len(samples)
            return
        if np.mean(samples**2) < QUIET:
            return
        filters, log_variance = bank.at(speed, load)
        self.posterior.take(heard_by(filters, heard), log_variance, len(samples))
        self.limit.hear(BLOCK * _MS, bank.quarter, float(self.posterior.stiffness() @ LOG_STIFFNESS))

    def pass_time(self, seconds: float) -> None:
        """Unheard."""
        self.posterior.pass_time(seconds)
        self.limit.pass_time(seconds)


class VerticalPressure(Estimator):
    """Four wheels side by side."""

    name = "vertical_pressure"
    reads = tuple(channel.signal for channel in CHANNELS)
    requires = reads[:NEEDED]

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._law = TyreLaw.of(car)
        self._blocks = GridBlocks(CHANNELS, _MS, BLOCK)
        self._heard = np.zeros(NEEDED, dtype=bool)
        self._next: int | None = None
        self._identified: dict[str, Any] | None = None
        self._use({axle: maker_corner(car, axle) for axle in AXLES}, expected_pressure(car, {}))

    def _use(self, corners: Mapping[str, Corner], expected: tuple[float, float]) -> None:
        self._corners = corners
        self._expected = expected
        self._wheels = [_Wheel(self.car, name, expected) for name in WHEELS]
        self._gravity = [GravityCheck(BLOCK * _MS) for _ in WHEELS]
        self._payload = Payload(self.car)
        self._banks = {
            axle: AxleBank(corner.quarter, beside(self.car, corners, axle)) for axle, corner in corners.items()
        }

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """The identified corners and what is expected of the tyres, see `corner`; forgets what was heard."""
        corners, expected = from_document(document), expected_pressure(self.car, document)
        self._identified = to_document(corners) | ({TYRES: dict(document[TYRES])} if TYRES in document else {})
        self._use(corners, expected)

    def calibration(self) -> dict[str, Any] | None:
        """What it was given: corners are identified at known pressures, not on any drive."""
        return self._identified

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        blocks, flags = self._blocks.add(samples, until)
        rows: dict[str, list[tuple[float, float, float]]] = {}
        for block, values in blocks:
            self._step(block, values, flags)
            if block % SAY == SAY - 1 and self._heard.all():
                self._say((block + 1) * BLOCK * _MS, self._speed(values), rows)
        return Outputs({name: _estimate(name, row) for name, row in rows.items()}, (), tuple(sorted(flags)))

    def _step(self, block: int, values: NDArray[np.float64], flags: list[Flag]) -> None:
        missed = 0 if self._next is None else block - self._next
        self._next = block + 1
        self._heard |= np.isfinite(values[:, :NEEDED]).any(axis=0)
        speed = self._speed(values)
        if missed > 0 or not SLOWEST <= speed <= FASTEST:
            self._payload.skip()
        self._payload.block(values[:, :4], values[:, NEEDED:])
        for i, wheel in enumerate(self._wheels):
            if missed > 0:
                wheel.intake.skip()
                wheel.pass_time(missed * BLOCK * _MS)
            before = self._gravity[i].believed
            if self._gravity[i].block(values[:, i]):
                wheel.step(values[:, i], self._banks[AXLES[i // 2]], speed, self._payload.load[i // 2])
                continue
            if before:  # what it has said lately was wrong, and cannot be told from what it said before
                flags.append(not_gravity(CHANNELS[i].signal, (block + 1) * BLOCK * _MS, self._gravity[i].mean))
                self._wheels[i] = _Wheel(self.car, wheel.name, self._expected)
            self._wheels[i].intake.skip()

    def _speed(self, values: NDArray[np.float64]) -> float:
        """Of the car in a block [m/s], NaN if no wheel tells: the median of the wheels, which no single one moves."""
        wheels = values[:, 4:NEEDED]
        means = [float(np.mean(w[np.isfinite(w)])) for w in wheels.T if np.isfinite(w).any()]
        return float(np.median(means)) * self.car.rolling_radius if means else float("nan")

    def _say(self, time: float, speed: float, rows: dict[str, list[tuple[float, float, float]]]) -> None:
        rolling = speed if SLOWEST <= speed <= FASTEST else SLOWEST
        for i, wheel in enumerate(self._wheels):
            believed = wheel.posterior.stiffness()
            share = math.hypot(self._corners[AXLES[i // 2]].stiffness_std, PER_LOAD * self._payload.std)
            load = wheel.load(self._payload.load[i // 2])
            stiffness = np.exp(LOG_STIFFNESS)
            mean, std = moments(believed, stiffness)
            rows.setdefault(f"{wheel.name}/stiffness", []).append((time, mean, float(np.hypot(std, share * mean))))
            pressure = self._law.pressure_of(stiffness, rolling, load)
            mean_p, std_p = moments(believed, pressure)
            systematic = float(self._law.pressure_std(share * mean, rolling, load))
            rows.setdefault(f"{wheel.name}/pressure", []).append((time, mean_p, float(np.hypot(std_p, systematic))))
            bound = float(self._law.pressure_std(wheel.limit.std() * mean, rolling, load))
            rows.setdefault(f"{wheel.name}/pressure_bound", []).append((time, bound, 0.0))
            road = wheel.posterior.road()
            rows.setdefault(f"{wheel.name}/road_level", []).append((time, *moments(road.ravel(), _LEVEL.ravel())))
            rows.setdefault(f"{wheel.name}/waviness", []).append((time, *moments(road.sum(axis=1), FINE_SHORT)))
        for axle, load in zip(AXLES, self._payload.load, strict=True):
            rows.setdefault(f"{axle}/load", []).append((time, load, load * self._payload.std))
        road = np.mean([wheel.posterior.road() for wheel in self._wheels], axis=0)
        for k, name in enumerate(CLASSES):
            p = float(min(road[k == _CLASS].sum(), 1.0))
            rows.setdefault(f"road/{name}", []).append((time, p, float(np.sqrt(p * (1.0 - p)))))


def _prior(car: Car, load: float, mean: float, std: float) -> NDArray[np.float64]:
    """Of each exp(LOG_STIFFNESS): pressure Gaussian; cells are even in ln k, so p(k) k counts."""
    stiffness = np.exp(LOG_STIFFNESS)
    pressure = TyreLaw.of(car).pressure_of(stiffness, USUAL_SPEED, load)
    return stiffness * np.exp(-0.5 * ((pressure - mean) / std) ** 2)


_UNITS = {"stiffness": "N/m", "pressure": "Pa", "pressure_bound": "Pa"}


def _estimate(name: str, rows: list[tuple[float, float, float]]) -> Estimate:
    table = np.array(rows)
    return Estimate(table[:, 0].copy(), table[:, 1].copy(), table[:, 2].copy(), _UNITS.get(name.rsplit("/", 1)[-1], ""))
