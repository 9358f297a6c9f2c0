"""Estimator `wheel_plausibility`: which wheel speeds are not the car's, and the car's speed from those that are.

The requirement that the thesis (Razavi, Lund 2006, chapter 6; seed 004) could not meet: an outlier of more than 13 km/h
found and named within 1 s, one wheel or two, without false alarms in rapid manoeuvres. Its residuals compare wheels
with wheels; here each is compared with what gyro, steering angle, accelerometer and the other wheels say (`kernel`), so
that curves are no outliers and two wrong wheels are two. Whether a sensor lies or a wheel slips, the signals do not
tell. Cells of 20 ms; estimates each SAY cells:

    vehicle_speed        forward speed of the car's middle line [m/s]
    WHEEL/speed_error    how far the wheel's speed is off it [m/s]

Alarms at one false alarm in 100 h (`thresholds`). Standing still nothing is compared but zeros. The thesis' own methods
are in `published`."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Alarm, Estimate, Estimator, Flag, Outputs
from estimators.grid import LATENCY, Channel, Grid
from estimators.wheel_plausibility.kernel import ACCUSED, ERROR, SAID, SPEED, STD, STEP, constants, follow, new_state
from estimators.wheel_plausibility.thresholds import FALSE_ALARMS_PER_HOUR, LIMITS

SAY = 5  # cells: 10 Hz
CHANNELS = (
    *(Channel(f"wheel/{wheel}/speed") for wheel in WHEELS),
    Channel("imu/accel", 0),
    Channel("imu/gyro", 2),
    Channel("steering/angle"),
)
_RATE = f"false alarms: one in {1.0 / FALSE_ALARMS_PER_HOUR:g} h"


class WheelPlausibility(Estimator):
    """See the module's text."""

    name = "wheel_plausibility"
    reads = (*(f"wheel/{wheel}/speed" for wheel in WHEELS), "imu/accel", "imu/gyro", "steering/angle")
    requires_any = reads[:4]
    requires = ()

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._grid, self._constants, self._state = Grid(CHANNELS, STEP), constants(car), new_state()
        self._was = np.zeros(4, dtype=bool)

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        flags = self._grid.add(samples)
        cells, more = self._grid.close(until)
        flags += more
        said = np.empty((len(cells.index), SAID))
        follow(self._constants, self._state, LIMITS, cells.index, np.ascontiguousarray(cells.value), said)
        alarms = self._told(cells.centre, said, flags)
        kept = np.isfinite(said[:, SPEED]) & (cells.index % SAY == SAY - 1)
        return Outputs(_estimates(cells.centre[kept], said[kept]), tuple(alarms), tuple(sorted(flags)))

    def _told(self, centre: NDArray[np.float64], said: NDArray[np.float64], flags: list[Flag]) -> list[Alarm]:
        """Alarms where a wheel is accused, flags where it is taken back."""
        accused = said[:, ACCUSED] > 0.5
        alarms = []
        for k in np.flatnonzero((accused != np.vstack([self._was, accused[:-1]])).any(axis=1)) if len(said) else ():
            now, before = accused[k], accused[k - 1] if k else self._was
            time = float(centre[k]) + 0.5 * STEP + LATENCY
            for i in np.flatnonzero(now & ~before):
                off = 3.6 * said[k, ERROR][i]
                text = f"speed {off:+.0f} km/h off the car's; {_RATE}"
                alarms.append(Alarm(time, text, (WHEELS[i],)))
            flags += [Flag(time, f"wheel/{WHEELS[i]} agrees again") for i in np.flatnonzero(before & ~now)]
        if len(said):
            self._was = accused[-1]
        return alarms


def _estimates(time: NDArray[np.float64], said: NDArray[np.float64]) -> dict[str, Estimate]:
    if not len(time):
        return {}
    std = said[:, STD].copy()
    found = {"vehicle_speed": Estimate(time.copy(), said[:, SPEED].copy(), std, "m/s")}
    for i, wheel in enumerate(WHEELS):
        off = said[:, ERROR][:, i]
        spoke = np.isfinite(off)
        if spoke.any():
            found[f"{wheel}/speed_error"] = Estimate(time[spoke], off[spoke], std[spoke], "m/s")
    return found
