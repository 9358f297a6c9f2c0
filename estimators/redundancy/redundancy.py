"""Estimator `redundancy`: can the car trust its inertial unit, wheel speeds, steering angle and torque?

After seed 003 (analytical redundancy): yaw rate and longitudinal acceleration, each from several sources, each source
against the others. The seed's own method is in `published`; what it lacks is here: nuisances are learnt (`comparison`),
the threshold has a stated false-alarm rate (`numbers`), grade and bank are no faults (`sources`), the single wheel is
named (`monitor`), repetition gives a stuck wheel away (`frozen`). Cells of 50 ms; estimates each cell:

    yaw_rate         [rad/s], of the sources that are not accused; offset of the gyro taken out as far as it is learnt
    acceleration     dv/dt [m/s^2], the specific force less the grade's share

Where no source is left the estimate stays and its std is as wide as any car's motion; a flag says so. Two sources that
differ cannot be judged. An accused source that agrees with the rest again is taken back, with a flag. Alarms name the
sensor; `wheels` holds a wheel whose speed sensor it is (or which skids: the signals do not tell)."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Alarm, Estimate, Estimator, Flag, Outputs
from estimators.grid import LATENCY, REPEAT, Grid
from estimators.redundancy import monitor
from estimators.redundancy.frozen import Change, FrozenWatch
from estimators.redundancy.numbers import HOURS, LIMITS
from estimators.redundancy.sources import CHANNELS, FORCE, STEP, YAW, constants

SENSORS = {
    "gyro": "imu/gyro/z",
    "accelerometer": "imu/accel/x",
    "steering": "steering/angle",
    "torque": "driveline/torque",
}
WIDEST_YAW, WIDEST_ACCELERATION = 2.0, 10.0  # std where nothing is known
RATE = f"designed for one false alarm in {HOURS:g} h"


class Redundancy(Estimator):
    """See the module's text."""

    name = "redundancy"
    opt_in = True  # the designed rate is not shown yet: too few hours
    requires = ("imu/gyro", "imu/accel", *(f"wheel/{wheel}/speed" for wheel in WHEELS))
    reads = (*requires, "driveline/torque", "steering/angle")

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._grid = Grid(CHANNELS, STEP)
        self._constants = constants(car)
        self._state = monitor.new_state()
        self._watch = {wheel: FrozenWatch(2.0 * math.pi / car.ring_teeth) for wheel in WHEELS}
        self._changes: list[tuple[float, int, bool]] = []  # (time, wheel, stuck) that no cell has reached yet
        self._stuck = np.zeros(4)
        self._last = np.zeros(2)  # estimates, for when nothing is known
        self._heard: set[str] = set()
        self._raised: dict[str, float] = {}

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        alarms, flags = list[Alarm](), self._grid.add(samples)
        for number, wheel in enumerate(WHEELS):
            if f"wheel/{wheel}/speed" in samples:
                for change in self._watch[wheel].add(samples[f"wheel/{wheel}/speed"]):
                    self._changes.append((change.time, number, change.stuck))
                    self._tell_frozen(wheel, change, alarms, flags)
        cells, more = self._grid.close(until)
        flags += more
        if not len(cells.index):
            return Outputs({}, tuple(sorted(alarms)), tuple(sorted(flags)))
        self._heard |= {channel.signal for channel, column in zip(CHANNELS, cells.value.T, strict=True)
                        if np.isfinite(column).any()}  # fmt: skip
        said = np.empty((len(cells.index), monitor.SAID))
        values = np.ascontiguousarray(cells.value)
        monitor.follow(self._constants, self._state, LIMITS, cells.index, values, self._stuck_in(cells.centre), said)
        self._tell(cells.centre, said, alarms, flags)
        estimates = self._estimates(cells.centre, said) if self._heard.issuperset(self.requires) else {}
        return Outputs(estimates, tuple(sorted(alarms)), tuple(sorted(flags)))

    def _stuck_in(self, centre: NDArray[np.float64]) -> NDArray[np.float64]:
        """1 where a wheel's sensor is known to be stuck in a cell, shape (n, 4)."""
        stuck = np.empty((len(centre), 4))
        self._changes.sort()
        for k, time in enumerate(centre.tolist()):
            while self._changes and self._changes[0][0] <= time:
                _, wheel, now = self._changes.pop(0)
                self._stuck[wheel] = float(now)
            stuck[k] = self._stuck
        return stuck

    def _tell_frozen(self, wheel: str, change: Change, alarms: list[Alarm], flags: list[Flag]) -> None:
        if change.stuck:
            text = f"wheel/{wheel} is stuck at its value since {change.since:.2f} s; {RATE}"
            alarms.append(Alarm(change.time, text, (wheel,)))
        else:
            flags.append(Flag(change.time, f"wheel/{wheel} moves again"))

    def _tell(
        self, centre: NDArray[np.float64], said: NDArray[np.float64], alarms: list[Alarm], flags: list[Flag]
    ) -> None:
        """Alarms, recoveries and what cannot be judged."""
        events = ((monitor.YAW_EVENT, YAW, monitor.YAW_USED, "yaw rate"),
                  (monitor.FORCE_EVENT, FORCE, monitor.FORCE_USED, "acceleration"))  # fmt: skip
        for column, names, used, quantity in events:
            for k in np.flatnonzero(said[:, column] != -1.0):
                now, event = float(centre[k]) + 0.5 * STEP + LATENCY, int(said[k, column])
                if event >= 0:
                    wheel = WHEELS[int(said[k, monitor.WHEEL])] if names[event] in ("front", "rear") else ""
                    if names[event] == "torque":  # brakes, a clutch: no sensor's fault
                        flags.append(Flag(now, "driveline/torque does not tell the acceleration: brakes, perhaps"))
                        continue
                    sensor = f"wheel/{wheel}" if wheel else SENSORS[names[event]]
                    text = f"{sensor} does not fit the other sensors ({quantity}); {RATE}"
                    alarms.append(Alarm(now, text, (wheel,) if wheel else ()))
                else:
                    flags.append(Flag(now, f"{quantity}: {names[-2 - event]} agrees again"))
            for count, text in ((0.0, "no source is left"), (1.0, "one source is left, unchecked")):
                for k in np.flatnonzero(said[:, used] == count):
                    self._flag(float(centre[k]), f"{quantity}: {text}", flags)

    def _flag(self, time: float, text: str, flags: list[Flag]) -> None:
        """The same text at most once in `REPEAT` seconds."""
        if time - self._raised.get(text, -np.inf) >= REPEAT:
            self._raised[text] = time
            flags.append(Flag(time, text))

    def _estimates(self, centre: NDArray[np.float64], said: NDArray[np.float64]) -> dict[str, Estimate]:
        rows = said.copy()
        turn, turn_std = rows[:, monitor.YAW_VALUE], np.sqrt(rows[:, monitor.YAW_VARIANCE])
        push = rows[:, monitor.FORCE_VALUE] - rows[:, monitor.GRADE]
        push_std = np.sqrt(rows[:, monitor.FORCE_VARIANCE] + rows[:, monitor.GRADE_VARIANCE])
        found = {}
        for i, (name, value, std, widest, unit) in enumerate((
            ("yaw_rate", turn, turn_std, WIDEST_YAW, "rad/s"),
            ("acceleration", push, push_std, WIDEST_ACCELERATION, "m/s^2"),
        )):  # fmt: skip
            for k in range(len(value)):
                if not (math.isfinite(value[k]) and std[k] <= widest):
                    value[k], std[k] = self._last[i], widest
                self._last[i] = value[k]
            found[name] = Estimate(centre.copy(), value.copy(), std.copy(), unit)
        return found
