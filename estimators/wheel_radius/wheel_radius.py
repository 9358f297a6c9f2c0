"""Estimator `wheel_radius`: relative rolling radii of the four wheels, and the pressure they lost, from bus signals
alone.

Seed method: Persson, Gustafsson, Drevo, "Indirect Tire Pressure Monitoring Using Sensor Fusion", SAE 2002, the
wheel-radius half. Signals are averaged to 10 Hz (`grid`, `motion`); static residual, longitudinal filter per side and
five-state lateral filter run side by side (`residuals`); their change against a calibration becomes a change per wheel
(`wheel_change`) and an alarm (`low_pressure`). Estimates once a second:

    static_residual, static_residual_published, delta12, delta34, delta13, delta24    raw [-]
    NAME_change         against the calibration [-], once NAME is calibrated
    inverse_stiffness_left, inverse_stiffness_right     1/k of the driven wheels [-]
    gyro_offset [rad/s]  (or accel_offset [m/s^2], where lateral acceleration stands in for a gyro)
    WHEEL/relative_radius_change [-], WHEEL/relative_pressure_change [Pa]     against the mean of the four wheels,
                        whose own change no comparison of wheels can see: one tyre that loses 60 kPa shows as -45, the
                        others as +15

What it cannot see: equal loss in all four; a payload or a tyre change looks like a loss until it is calibrated away.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from estimators.car import Car
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Alarm, Estimate, Estimator, Flag, Outputs
from estimators.grid import Cells, Grid
from estimators.wheel_radius.calibration import Calibration
from estimators.wheel_radius.low_pressure import LowPressureAlarm
from estimators.wheel_radius.motion import CHANNELS, MotionTracker
from estimators.wheel_radius.out_of_reach import REACH, UNKNOWN_RADIUS, OutOfReach
from estimators.wheel_radius.residuals import NAMES, Methods
from estimators.wheel_radius.static_residual import StaticResidual
from estimators.wheel_radius.wheel_change import per_wheel, pressure_change, wheel_change

STEP = 0.1  # [s] of a cell
CELLS_PER_SECOND = 10
SETTLING_TIME = 10.0  # [s] of readable driving before an alarm: the noise levels are measured by then
Row = tuple[float, dict[str, tuple[float, float, str]]]


class WheelRadius(Estimator):
    """The combination of the three methods."""

    name = "wheel_radius"
    requires = tuple(f"wheel/{wheel}/speed" for wheel in WHEELS)
    reads = (*requires, "imu/gyro", "imu/accel", "driveline/torque", "steering/angle")

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._grid = Grid(CHANNELS, STEP)
        self._tracker = MotionTracker(car, STEP)
        self._methods = Methods(car)
        self._published = StaticResidual(curve_corrected=False)
        self._learning: Methods | None = Methods(car, learning=True)
        self._calibration = Calibration()
        self._alarm = LowPressureAlarm(car)
        self._due: int | None = None
        self._warned: set[str] = set()
        self._unheard = set(self.requires)
        self._reach = OutOfReach(car)
        self.nearness: list[float] = []
        """How near the alarm has been to coming (1), once a second, since it may come."""

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """Start calibrated; a residual that the document lacks is still learnt."""
        self._calibration = Calibration.from_document(document)
        self._learning = None if self._calibration.done.all() else Methods(self.car, learning=True)

    def calibration(self) -> dict[str, Any] | None:
        """Reference level and std by residual name."""
        return self._calibration.document()

    def relearn(self) -> None:
        """Forget the calibration and learn anew: the driver has set the pressures."""
        self._calibration = Calibration()
        self._learning = Methods(self.car, learning=True)
        self._alarm = LowPressureAlarm(self.car)

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        flags = self._grid.add(samples)
        self._unheard -= {name for name in self.requires if name in samples and len(samples[name])}
        cells, more = self._grid.close(until)
        return self.judge(cells, [*flags, *more])

    def judge(self, cells: Cells, flags: Sequence[Flag] = ()) -> Outputs:
        """The same from cells of STEP that were made before; flags: raised in making them."""
        flags = list(flags)
        heard = np.flatnonzero(np.isfinite(cells.value[:, : len(self.requires)]).any(axis=0))
        self._unheard -= {self.requires[i] for i in heard}
        rows: list[Row] = []
        alarms: list[Alarm] = []
        for index, centre, cell in zip(cells.index.tolist(), cells.centre.tolist(), cells.value, strict=True):
            second, place = divmod(index, CELLS_PER_SECOND)
            if self._due is not None and self._due != second:
                self._conclude(self._due, rows, alarms, flags)
            self._due = second
            motion = self._tracker.motion(index, centre, cell)
            self._reach.step(motion)
            self._methods.step(motion)
            self._published.step(motion)
            if self._learning is not None:
                self._learning.step(motion)
            if place == CELLS_PER_SECOND - 1:
                self._conclude(second, rows, alarms, flags)
                self._due = None
        return Outputs(_columns(rows), tuple(alarms), tuple(sorted(flags)))

    def _conclude(self, second: int, rows: list[Row], alarms: list[Alarm], flags: list[Flag]) -> None:
        """Say where the methods stand at the end of a second that had a cell."""
        time = second + 1.0
        if self._learning is not None and not self._reach.any:
            flags += [Flag(time, text) for text in self._calibration.learn(self._learning.residuals())]
            if self._calibration.done.all():
                self._learning = None
        flags += [Flag(time, text) for text in self._doubts()]
        if not self._unheard:
            rows.append((time, self._estimates(time, alarms)))

    def _doubts(self) -> list[str]:
        """What makes the estimates less sure from now on, each told once."""
        doubts = [f"wheel/{w}/speed: the wheel stands while others roll, taken for dead" for w, dead in
                  zip(WHEELS, self._tracker.dead, strict=True) if dead]  # fmt: skip
        if self.car.driven_axle == "all":
            doubts.append("all wheels driven: no wheel rolls freely, delta13 and delta24 are less sure")
        told = f"off by over {100 * REACH:g} %: it slips, is another wheel, or its sensor errs; no pressure is told"
        doubts += [f"wheel/{wheel}/speed: {told}" for wheel in self._reach.wheels()]
        new = [text for text in doubts if text not in self._warned]
        self._warned |= set(new)
        return new

    def _estimates(self, time: float, alarms: list[Alarm]) -> dict[str, tuple[float, float, str]]:
        """Name -> (value, std, unit) at `time` [s]; appends a due alarm."""
        now, reference = self._methods.residuals(), self._calibration
        change, covariance = reference.change(now)
        said: dict[str, tuple[float, float, str]] = {}
        for i, name in enumerate(NAMES):
            if now.seconds[i] > 0.0:
                said[name] = (now.value[i], now.covariance[i, i] ** 0.5, "")
                if reference.done[i]:
                    said[f"{name}_change"] = (change[i], covariance[i, i] ** 0.5, "")
        said.update(self._side_estimates(now.seconds))
        used = reference.used() & (now.seconds > 0.0)
        if not used.any():
            return said
        contrasts, spread = wheel_change(change, covariance, used)
        radius = per_wheel(contrasts, spread)
        pressure = pressure_change(self.car, *radius)
        for i, wheel in enumerate(WHEELS):
            wide = UNKNOWN_RADIUS if self._reach.any else 0.0
            said[f"{wheel}/relative_radius_change"] = (radius[0][i], float(np.hypot(radius[1][i], wide)), "")
            told = (0.0, self.car.pressure) if self._reach.any else (pressure[0][i], pressure[1][i])
            said[f"{wheel}/relative_pressure_change"] = (*told, "Pa")
        settled = reference.done.any() and not self._reach.any and now.seconds[0] >= SETTLING_TIME
        if settled:
            if alarm := self._alarm.step(time, contrasts, spread):
                alarms.append(alarm)
            self.nearness.append(self._alarm.nearness)
        return said

    def _side_estimates(self, seconds: np.ndarray) -> dict[str, tuple[float, float, str]]:
        """What the filters learn beside the radii."""
        said: dict[str, tuple[float, float, str]] = {}
        if seconds[0] > 0.0:
            said["static_residual_published"] = (self._published.value(), self._published.std(), "")
        for side, method in zip(("left", "right"), self._methods.longitudinal, strict=True):
            if method.seconds > 0.0 and self.car.driven_axle != "all":
                said[f"inverse_stiffness_{side}"] = (*method.compliance(), "")
        if seconds[1] > 0.0:
            name, unit = ("gyro_offset", "rad/s") if self._tracker.gyro_seen else ("accel_offset", "m/s^2")
            said[name] = (*self._methods.lateral.offset(), unit)
        return said


def _columns(rows: list[Row]) -> dict[str, Estimate]:
    """Rows of a time and its estimates -> one estimate per name."""
    columns: dict[str, list[tuple[float, float, float]]] = {}
    units: dict[str, str] = {}
    for time, said in rows:
        for name, (value, std, unit) in said.items():
            columns.setdefault(name, []).append((time, value, std))
            units[name] = unit
    return {
        name: Estimate(table[:, 0], table[:, 1], table[:, 2], units[name])
        for name, table in ((name, np.array(column)) for name, column in columns.items())
    }
