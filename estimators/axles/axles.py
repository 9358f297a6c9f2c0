"""Estimator `axles`: stiffness and pressure of both tyres of a side from the road that they share.

The rear wheel meets the front wheel's road one wheelbase later (`delay`), so the road's level and shape, which bound
what one wheel can tell (`quarter_car.bound`), fall out of the comparison of the two: ln k_f - ln k_r is known to 2.5 %
after 2 s and to 1 % after 10 s (`bound`). How much the two have in common is measured (`likelihood`: nu) and, off the
straight line, known (`off_tracking`): where nothing is common, the standard deviations are those of two single wheels.
Estimates every `SAY` blocks (half a second):

    WHEEL/stiffness       at the load that it has and the present speed [N/m]
    WHEEL/pressure        by the maker's tyre law at the load that is heard (`parameters`), the law's slope as uncertain
                          as declared (`calibration`) [Pa]
    left/difference, right/difference     ln k_front - ln k_rear [-]
    left/coherence, right/coherence       share of the road that both wheels have in common, mean over the band [-]
    left/statistic, right/statistic       of the CUSUM behind the alarm (`watch`), in its own units

An alarm names a tyre that has lost pressure against the other one of its side, in this drive or since the drive of the
calibration, at one false alarm in 100 h. Each side for itself. An equal loss front and rear on one side shows only as
well as in two single wheels. Below `SLOWEST` nothing is learnt.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.axles.block import spectrum
from estimators.axles.calibration import Identified, from_document, maker_axles, sound_from, to_document
from estimators.axles.intake import BLOCKS, SideIntake
from estimators.axles.motion import Motion, stretch
from estimators.axles.off_tracking import coherency, offset
from estimators.axles.side import Side
from estimators.axles.watch import FRONT_LOST, LARGEST, Watch
from estimators.car import GRAVITY, Car
from estimators.detectors import CusumMean, Monitor
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Alarm, Estimate, Estimator, Flag, Outputs
from estimators.grid import Channel
from estimators.grid_blocks import GridBlocks
from estimators.quarter_car.gravity import GravityCheck, not_gravity
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.vertical_pressure.bank import QUIET
from estimators.vertical_pressure.corner import TYRES, expected_pressure
from estimators.vertical_pressure.intake import BLOCK

SAY = 2  # blocks from one estimate to the next
SLOWEST, FASTEST = 7.0, 90.0  # m/s
USUAL_SPEED = 20.0  # m/s of the prior
SIDES = ("left", "right")
SOUND = "sound"  # of a calibration: d and its std by side
ALARM_TEXT = "against the other tyre of its side; false alarms: one in 100 h"
PATIENCE = 3.0  # s
REOPENED = 0.12  # of ln k: what is forgotten once something has changed
COMMON_DRIFT, COMMON_THRESHOLD = 0.5, 15.0  # CUSUM of the mean ln k of a side, for nothing but `REOPENED`
_MS = 1e-3
_SECONDS = BLOCK * _MS
CHANNELS = (
    *(Channel(f"hub/{wheel}/accel_z") for wheel in WHEELS),
    *(Channel(f"wheel/{wheel}/speed") for wheel in WHEELS),
    Channel("imu/gyro", 2),
)
_NEEDED = len(WHEELS) * 2
Rows = dict[str, list[tuple[float, float, float]]]


class Axles(Estimator):
    """Both sides."""

    name = "axles"
    requires = tuple(channel.signal for channel in CHANNELS[:_NEEDED])
    reads = (*requires, "imu/gyro")

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._law = TyreLaw.of(car)
        self._loads = [sum(quarter_masses(car, wheel)) * GRAVITY for wheel in WHEELS]
        self._blocks = GridBlocks(CHANNELS, _MS, BLOCK)
        self._heard = np.zeros(len(CHANNELS), dtype=bool)
        self._next: int | None = None
        self._identified: Identified | None = None
        self._told: dict[str, Any] = {}
        self._start(maker_axles(car), {}, expected_pressure(car, {}))

    def _start(
        self, known: Identified, sound: Mapping[str, tuple[float, float]], expected: tuple[float, float]
    ) -> None:
        self._known, self._sound = known, sound
        car = self.car  # a load e^x on the front's m_s is on all wheels' static load:
        self._heavier = car.chassis_mass / known.axles.front.sprung_mass * car.chassis_mass / car.mass
        pressure, pressure_std = expected
        usual = np.array([self._law.stiffness_at(pressure, USUAL_SPEED, load) for load in self._loads])
        slopes = [self._law.pressure_std(k, USUAL_SPEED, load) for k, load in zip(usual, self._loads, strict=True)]
        self._expected = np.log(usual), pressure_std / np.array(slopes)
        self._commons = [Monitor(CusumMean(COMMON_DRIFT, COMMON_THRESHOLD, "both"), "restart") for _ in SIDES]
        self._moved = [False, False]
        self._waits: dict[int, tuple[str, float]] = {}  # alarms by side, and the time [s] after which they wait no more
        self._sides, self._watches = [self._side(s) for s in range(2)], [self._watch(s) for s in range(2)]
        self._intakes = [SideIntake(known.axles.wheelbase) for _ in range(2)]
        self._gravity = [GravityCheck(_SECONDS) for _ in WHEELS]
        self._motions: list[Motion] = []

    def _side(self, s: int) -> Side:
        """One that has heard nothing."""
        mean, std = self._expected
        return Side(self._known, mean[s::2], std[s::2], self._law.per_load * self._heavier)

    def _watch(self, s: int) -> Watch:
        return Watch(self._sound.get(SIDES[s]))

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """The identified axles, see `calibration`, under `sound` what this car's differences were, and under `tyres`
        what is expected of them, see `vertical_pressure.corner`."""
        sound, expected = sound_from(document.get(SOUND, {})), expected_pressure(self.car, document)
        self._identified = from_document(document)
        self._told = {TYRES: dict(document[TYRES])} if TYRES in document else {}
        self._start(self._identified, sound, expected)

    def calibration(self) -> dict[str, Any] | None:
        """The axles it was given, which are identified at known pressures, and the differences that it has learnt, of
        sides without an alarm; None without identified axles."""
        if self._identified is None:
            return None
        known = {name: watch.learnt for name, watch in zip(SIDES, self._watches, strict=True)}
        learnt = {name: list(pair) for name, pair in known.items() if pair is not None}
        return to_document(self._identified) | self._told | ({SOUND: learnt} if learnt else {})

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        blocks, flags = self._blocks.add(samples, until)
        rows: Rows = {}
        alarms: list[Alarm] = []
        for block, values in blocks:
            self._step(block, values, alarms, flags)
            if block % SAY == SAY - 1 and self._heard[:_NEEDED].all():
                self._say((block + 1) * _SECONDS, rows)
        return Outputs({name: _estimate(name, row) for name, row in rows.items()}, tuple(alarms), tuple(sorted(flags)))

    def _believed(self, s: int, values: NDArray[np.float64], time: float, flags: list[Flag]) -> bool:
        """Whether both hubs of a side tell gravity. As soon as one does not, the side is forgotten: what it said lately
        was wrong, and cannot be told from what it said before."""
        fine = True
        for w in (s, 2 + s):
            before = self._gravity[w].believed
            fine &= self._gravity[w].block(values[:, w])
            if before and not self._gravity[w].believed:
                flags.append(not_gravity(CHANNELS[w].signal, time, self._gravity[w].mean))
                self._sides[s], self._watches[s] = self._side(s), self._watch(s)
        return fine

    def _warn(self, s: int, fine: bool, time: float, alarms: list[Alarm]) -> None:
        """An alarm that is due, unless a hub's sensor is in doubt: then it waits, and falls with the sensor."""
        if (due := self._waits.pop(s, None)) is None or not fine:
            return
        if (self._gravity[s].doubted or self._gravity[2 + s].doubted) and time < due[1]:
            self._waits[s] = due
        else:
            alarms.append(Alarm(time, f"low pressure {ALARM_TEXT}", (due[0],)))

    def _step(self, block: int, values: NDArray[np.float64], alarms: list[Alarm], flags: list[Flag]) -> None:
        missed = 0 if self._next is None else block - self._next
        self._next = block + 1
        self._heard |= np.isfinite(values).any(axis=0)
        motion = Motion(self.car, values[:, 4:8], values[:, 8])
        self._motions = [motion] if missed else [*self._motions[1 - BLOCKS :], motion]
        for s in range(2):
            self._sides[s].pass_time((missed + 1) * _SECONDS)
            if missed:
                self._intakes[s].skip()
            speed = motion.speed[s]
            fine = self._believed(s, values, (block + 1) * _SECONDS, flags)
            if not fine or not SLOWEST <= float(speed.min()) <= float(speed.max()) <= FASTEST:
                self._intakes[s].skip()
                self._warn(s, fine, (block + 1) * _SECONDS, alarms)
                continue
            window = self._intakes[s].block(values[:, s], values[:, 2 + s], speed)
            if window is not None and np.mean(window**2, axis=0).min() > QUIET:  # else the sensors hear themselves
                self._take(s, window, (block + 1) * _SECONDS)
            self._warn(s, fine, (block + 1) * _SECONDS, alarms)

    def _take(self, s: int, window: NDArray[np.float64], time: float) -> None:
        wheelbase, side, watch = self._known.axles.wheelbase, self._sides[s], self._watches[s]
        speed = float(np.mean([m.speed[s].mean() for m in self._motions]))
        acceleration = float(np.mean([m.acceleration for m in self._motions]))
        turn = max(abs(m.yaw_rate) for m in self._motions)
        mean = side.mean()
        gamma = coherency(offset(turn, speed, wheelbase), speed)
        alone = side.take(spectrum(window), speed, stretch(speed, acceleration, wheelbase), gamma)
        lost = watch.step(*alone.difference, acceleration, _SECONDS)
        if lost is not None:
            self._waits[s] = (WHEELS[s if lost == FRONT_LOST else 2 + s], time + PATIENCE)
        if watch.moved and not self._moved[s]:
            side.forget(REOPENED)
        self._moved[s] = watch.moved
        common = (alone.mean[0] - mean) / np.sqrt(alone.mean[1])
        if self._commons[s].step(float(np.clip(common, -LARGEST, LARGEST))).alarm:
            side.forget(REOPENED)

    def _say(self, time: float, rows: Rows) -> None:
        known, now = self._known, self._motions[-1].mean
        rolling = now if SLOWEST <= now <= FASTEST else SLOWEST
        for s, name in enumerate(SIDES):
            side = self._sides[s]
            relative = np.hypot(np.sqrt(side.stiffness_variance()), known.stiffness_std)
            unloaded = np.hypot(np.sqrt(side.unloaded_variance()), known.stiffness_std)
            heavier = np.exp(self._heavier * side.load())
            for place, k in enumerate(np.exp(side.log_stiffness()).tolist()):
                w, std = 2 * place + s, k * float(unloaded[place])
                rows.setdefault(f"{WHEELS[w]}/stiffness", []).append((time, k, k * float(relative[place])))
                load = self._loads[w] * heavier
                pressure = float(self._law.pressure_of(k, rolling, load))
                law = known.law_std * (pressure - self._law.pressure)  # p_Fz1 turns about nominal pressure
                pressure_std = float(np.hypot(self._law.pressure_std(std, rolling, load), law))
                rows.setdefault(f"{WHEELS[w]}/pressure", []).append((time, pressure, pressure_std))
            std = float(np.hypot(np.sqrt(side.difference_variance()), known.difference_std))
            rows.setdefault(f"{name}/difference", []).append((time, side.difference(), std))
            rows.setdefault(f"{name}/statistic", []).append((time, self._watches[s].statistic, 0.0))
            spread = min(float(side.coherence_std().mean()), 1.0)
            rows.setdefault(f"{name}/coherence", []).append((time, float(side.coherence().mean()), spread))


_UNITS = {"stiffness": "N/m", "pressure": "Pa"}


def _estimate(name: str, rows: list[tuple[float, float, float]]) -> Estimate:
    table = np.array(rows)
    return Estimate(table[:, 0].copy(), table[:, 1].copy(), table[:, 2].copy(), _UNITS.get(name.rsplit("/", 1)[-1], ""))
