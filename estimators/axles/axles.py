"""Estimator `axles`: stiffness and pressure of both tyres of a side from the road that they share.

The rear wheel meets the front wheel's road one wheelbase later (`delay`), so the road's level and shape, which bound what
one wheel can tell (`quarter_car.bound`), fall out of the comparison of the two: ln k_f - ln k_r is known to 2 % after 2 s
and below 1 % after 10 s, and each stiffness better than alone (`bound`). How much the two have in common is measured
(`likelihood`: nu) and, off the straight line, known (`off_tracking`): where nothing is common, the standard deviations
are those of two single wheels. Estimates every `SAY` blocks (half a second):

    WHEEL/stiffness       at the mean static load and the present speed [N/m]
    WHEEL/pressure        by the maker's tyre law, taken for exact [Pa]
    left/difference, right/difference     ln k_front - ln k_rear [-]
    left/coherence, right/coherence       share of the road that both wheels have in common, mean over the band [-]

Each side for itself. An equal loss front and rear on one side shows only as well as in two single wheels. Nothing is
said of it below `SLOWEST`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.axles.block import spectrum
from estimators.axles.calibration import Identified, from_document, maker_axles, to_document
from estimators.axles.intake import BLOCKS, SideIntake
from estimators.axles.likelihood import FRONT, LOSS, REAR
from estimators.axles.motion import Motion
from estimators.axles.off_tracking import coherency, offset
from estimators.axles.side import Side
from estimators.car import GRAVITY, Car
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Estimate, Estimator, Outputs
from estimators.grid import LATENCY, Cells, Channel, Grid
from estimators.quarter_car.quarter_car import quarter_masses
from estimators.quarter_car.tyre_law import TyreLaw
from estimators.vertical_pressure.intake import BLOCK

SAY = 2  # blocks from one estimate to the next
SLOWEST, FASTEST = 7.0, 90.0  # m/s
PRIOR_STD, USUAL_SPEED = 0.18, 20.0  # of ln k, m/s. Declared: tyres in use, leaks among them
SIDES = ("left", "right")
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
        self._grid = Grid(CHANNELS, _MS)
        self._heard = np.zeros(len(CHANNELS), dtype=bool)
        self._waiting: list[Cells] = []
        self._next: int | None = None
        self._identified: Identified | None = None
        self._start(maker_axles(car))

    def _start(self, known: Identified) -> None:
        self._known = known
        usual = [float(np.log(self._law.stiffness_at(self.car.pressure, USUAL_SPEED, load))) for load in self._loads]
        self._sides = [Side(known.axles, np.array([usual[s], usual[2 + s]]), PRIOR_STD) for s in range(2)]
        self._intakes = [SideIntake(self.car.wheelbase) for _ in range(2)]
        self._motions: list[Motion] = []

    def use_calibration(self, document: Mapping[str, Any]) -> None:
        """The identified axles, see `calibration`."""
        self._identified = from_document(document, self.car.wheelbase)
        self._start(self._identified)

    def calibration(self) -> dict[str, Any] | None:
        """What it was given: axles are identified at known pressures, not on any drive."""
        return None if self._identified is None else to_document(self._identified)

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        flags = self._grid.add(samples)
        cells, more = self._grid.close(until)
        if len(cells.index):
            self._waiting.append(cells)
        closed = int(np.floor((until - LATENCY) / _MS + 1e-6)) // BLOCK
        rows: Rows = {}
        for block, values in self._blocks(closed):
            self._step(block, values)
            if block % SAY == SAY - 1 and self._heard[:_NEEDED].all():
                self._say((block + 1) * _SECONDS, rows)
        return Outputs({name: _estimate(name, row) for name, row in rows.items()}, (), tuple(sorted([*flags, *more])))

    def _blocks(self, closed: int) -> list[tuple[int, NDArray[np.float64]]]:
        """Whole blocks before `closed` that hold samples: number, values (BLOCK, channels)."""
        if not self._waiting:
            return []
        index = np.concatenate([cells.index for cells in self._waiting])
        value = np.concatenate([cells.value for cells in self._waiting])
        number = index // BLOCK
        ready = number < closed
        self._waiting = [Cells(index[~ready], index[~ready] * _MS, value[~ready])] if (~ready).any() else []
        found = []
        for block in np.unique(number[ready]).tolist():
            inside = number == block
            values = np.full((BLOCK, len(CHANNELS)), np.nan)
            values[index[inside] - block * BLOCK] = value[inside]
            found.append((block, values))
        return found

    def _step(self, block: int, values: NDArray[np.float64]) -> None:
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
            if not SLOWEST <= float(speed.min()) <= float(speed.max()) <= FASTEST:
                self._intakes[s].skip()
                continue
            window = self._intakes[s].block(values[:, s], values[:, 2 + s], speed)
            if window is not None:
                self._take(s, window)

    def _take(self, s: int, window: NDArray[np.float64]) -> None:
        speed = float(np.mean([m.speed[s].mean() for m in self._motions]))
        turn = max(abs(m.yaw_rate) for m in self._motions)
        gamma = coherency(offset(turn, speed, self.car.wheelbase), speed)
        self._sides[s].take(spectrum(window), speed, self._known.shape(speed), gamma)

    def _say(self, time: float, rows: Rows) -> None:
        known, now = self._known, self._motions[-1].mean
        rolling = now if SLOWEST <= now <= FASTEST else SLOWEST
        for s, name in enumerate(SIDES):
            side = self._sides[s]
            variance = np.diag(side.P)
            for state in (FRONT, REAR):
                w = 2 * state + s
                k = float(np.exp(side.theta[state]))
                std = k * float(np.hypot(np.sqrt(variance[state]), known.stiffness_std))
                rows.setdefault(f"{WHEELS[w]}/stiffness", []).append((time, k, std))
                pressure = float(self._law.pressure_of(k, rolling, self._loads[w]))
                pressure_std = float(self._law.pressure_std(std, rolling, self._loads[w]))
                rows.setdefault(f"{WHEELS[w]}/pressure", []).append((time, pressure, pressure_std))
            std = float(np.hypot(np.sqrt(side.difference_variance()), known.difference_std))
            rows.setdefault(f"{name}/difference", []).append((time, float(side.theta[FRONT] - side.theta[REAR]), std))
            lost = np.exp(side.theta[LOSS:])
            spread = float(np.mean(lost * np.sqrt(variance[LOSS:])))
            rows.setdefault(f"{name}/coherence", []).append((time, float(np.mean(1.0 - lost)), min(spread, 1.0)))


_UNITS = {"stiffness": "N/m", "pressure": "Pa"}


def _estimate(name: str, rows: list[tuple[float, float, float]]) -> Estimate:
    table = np.array(rows)
    return Estimate(table[:, 0].copy(), table[:, 1].copy(), table[:, 2].copy(), _UNITS.get(name.rsplit("/", 1)[-1], ""))
