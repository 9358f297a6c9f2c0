"""Estimator `sensor_checks`: motion sensors that are dead, stuck, lose messages, or do not fit their neighbours.

Three kinds of checks (fault detection by limits, by repetition and by parity, as in Isermann, Fault-Diagnosis Systems,
Springer 2006, chapters 7 and 10); what `redundancy` and `wheel_plausibility` compare is left to them:

    repetition   each axis of each sensor alone: stuck at a number, or dead at zero     (`repetition`)
    messages     each sensor alone: messages that are lost, or none at all              (`messages`)
    the body     four body accelerometers, f_z, roll and pitch gyro are one rigid body;
                 a hub stays at its corner; f_y is what speed and yaw rate ask for      (`kernel`)

Estimates, every SAY: how far each accelerometer's mean over the last second is off what the others ask of it, less
its usual offset [m/s^2]. Alarms begin with the sensor's name; an accused sensor that is sound again is a flag."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from estimators.arrival import Intake
from estimators.car import Car
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Alarm, Estimate, Estimator, Flag, Outputs
from estimators.grid import LATENCY, Channel, Grid
from estimators.sensor_checks import kernel
from estimators.sensor_checks.kernel import EVENT, MEMORY, OFF, SAID, STD, STEP
from estimators.sensor_checks.messages import MessageWatch
from estimators.sensor_checks.numbers import ALONE, FASTEST, HOURS, JUDGEMENTS, LIMITS
from estimators.sensor_checks.repetition import RepetitionWatch

BODIES = tuple(f"body/{wheel}/accel_z" for wheel in WHEELS)
HUBS = tuple(f"hub/{wheel}/accel_z" for wheel in WHEELS)
SPEEDS = tuple(f"wheel/{wheel}/speed" for wheel in WHEELS)
CHANNELS = (
    *(Channel("imu/accel", i) for i in range(3)), *(Channel("imu/gyro", i) for i in range(3)),
    *(Channel(name) for name in (*BODIES, *HUBS, *SPEEDS)),
)  # fmt: skip
TORQUES = ("driveline/torque", "engine/torque")
ALONES = ("imu/accel", "imu/gyro", *BODIES, *HUBS, *TORQUES, "steering/angle")
NEVER_STUCK = ("steering/angle",)  # coarse and at rest most of the time
AXES = {"imu/accel": "xyz", "imu/gyro": "xyz"}
CULPRITS = (*BODIES, "imu/accel/z", "imu/gyro/x", "imu/gyro/y", *HUBS, "imu/accel/y")
SAY = 25  # cells: 2 Hz
KEPT = 20.0  # s for which it is remembered who spoke
TICK = 0.005  # s
BETWEEN = 16.0 * FASTEST * 3600.0 * ALONE
RATE = f"false alarms: one in {HOURS:g} h"
RATE_ALONE = f"false alarms: one in {ALONE:g} h"
assert JUDGEMENTS == 6


class SensorChecks(Estimator):
    """See the module's text."""

    name = "sensor_checks"
    opt_in = True  # the designed rate is not shown yet: too few hours
    reads = ("imu/accel", "imu/gyro", *BODIES, *HUBS, *SPEEDS, *TORQUES, "steering/angle")
    requires = ()
    requires_any = (*BODIES, *HUBS)

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._grid = Grid(CHANNELS + tuple(Channel(name) for name in (*TORQUES, "steering/angle")), STEP)
        self._constants, self._state = kernel.constants(car), kernel.new_state()
        self._intake = {name: Intake() for name in ALONES}
        self._messages = {name: MessageWatch(BETWEEN) for name in ALONES}
        self._runs = {
            (name, axis): RepetitionWatch(BETWEEN)
            for name in ALONES if name not in NEVER_STUCK for axis in AXES.get(name, "-")
        }  # fmt: skip
        self._spoken = {name: np.empty(0, np.int64) for name in ALONES}  # ticks at which a signal spoke

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        flags, alarms = self._grid.add(samples), list[Alarm]()
        self._alone(samples, until, alarms, flags)
        cells, more = self._grid.close(until)
        flags += more
        if not len(cells.index):
            return Outputs({}, tuple(sorted(alarms)), tuple(sorted(flags)))
        said = np.empty((len(cells.index), SAID))
        values = np.ascontiguousarray(cells.value[:, :18])
        kernel.follow(self._constants, self._state, LIMITS, cells.index, values, said)
        self._compared(cells.centre, said, alarms, flags)
        kept = cells.index % SAY == SAY - 1
        return Outputs(_estimates(cells.centre[kept], said[kept]), tuple(sorted(alarms)), tuple(sorted(flags)))

    def _alone(self, samples: Mapping[str, Signal], until: float, alarms: list[Alarm], flags: list[Flag]) -> None:
        """Repetition and lost messages of each sensor."""
        stamps: dict[str, NDArray[np.float64]] = {}
        for name in ALONES:
            signal = samples.get(name)
            if signal is None or signal.value.dtype.kind != "f":
                continue
            good, _ = self._intake[name].accept(signal.time)
            stamps[name] = signal.time[good]
            ticks = np.unique(np.floor(stamps[name] / TICK).astype(np.int64))
            self._spoken[name] = np.concatenate([self._spoken[name], ticks[~np.isin(ticks, self._spoken[name][-1:])]])
            columns = signal.value[good] if signal.value.ndim == 2 else signal.value[good][:, None]
            for i, axis in enumerate(AXES.get(name, "-")):
                watch = self._runs.get((name, axis))
                if watch is None or i >= columns.shape[1]:
                    continue
                finite = np.isfinite(columns[:, i])
                sensor = name if axis == "-" else f"{name}/{axis}"
                for change in watch.add(stamps[name][finite], columns[finite, i]):
                    if change.stuck:
                        text = f"{sensor} says the same number since {change.since:.2f} s; {RATE_ALONE}"
                        alarms.append(Alarm(change.time, text))
                    else:
                        flags.append(Flag(change.time, f"{sensor} moves again"))
        horizon = until - LATENCY
        for name in ALONES:
            others = cache(partial(self._others, name))
            changes = self._messages[name].add(stamps.get(name, np.empty(0)), others)
            for time, lost in changes + self._messages[name].silent(horizon, others):
                text = f"{name} loses messages; {RATE_ALONE}"
                alarms.append(Alarm(time, text)) if lost else flags.append(Flag(time, f"{name} is complete again"))
        for name, ticks in self._spoken.items():
            self._spoken[name] = ticks[ticks >= int((until - KEPT) / TICK)]

    def _others(self, name: str) -> NDArray[np.float64]:
        """[s] at which any other sensor spoke lately, sorted."""
        every = [ticks for other, ticks in self._spoken.items() if other != name]
        return np.asarray(np.unique(np.concatenate(every)) * TICK, dtype=np.float64)

    def _compared(
        self, centre: NDArray[np.float64], said: NDArray[np.float64], alarms: list[Alarm], flags: list[Flag]
    ) -> None:
        events = said[:, EVENT]
        for k, j in np.argwhere(events != -1.0):
            time, event = float(centre[k]) + 0.5 * STEP + LATENCY, int(events[k, j])
            if event >= 0:
                alarms.append(Alarm(time, f"{CULPRITS[event]} does not fit the other sensors; {RATE}"))
            else:
                flags.append(Flag(time, f"{CULPRITS[-2 - event]} agrees again"))


def _estimates(time: NDArray[np.float64], said: NDArray[np.float64]) -> dict[str, Estimate]:
    """Residuals as accelerations: R over MEMORY, D over its square."""
    found = {}
    off, std = said[:, OFF], said[:, STD]
    names = (*(f"{w}/body_accel_error" for w in WHEELS), *(f"{w}/hub_accel_error" for w in WHEELS))
    for i, name in enumerate(names):
        spoke = np.isfinite(off[:, i])
        if spoke.any():
            by = MEMORY if i < len(WHEELS) else MEMORY**2
            found[name] = Estimate(time[spoke], off[spoke, i] / by, std[spoke, i] / by, "m/s^2")
    return found
