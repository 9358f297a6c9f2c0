"""Estimator `direct_pressure`: pressure, leak rate and leak alarm of each tyre from the sensors inside the tyres.

What the seed's method (`published`) should have been. Per wheel the amount of gas, as the pressure at a reference
temperature, so that the ideal gas law takes warming out; the wheel's speed says when the load can change, which moves
the pressure too; measured intervals (20 Hz or a sample a minute), measured noise. A bank of CUSUMs on the quiet tyre's
whitened innovation raises the alarm, designed for one false alarm in 100 h over four wheels; it is latched until the
tyre is filled. See `monitor`, `onsets`, `numbers`. Estimates about once a second:

    WHEEL/pressure     gauge, at the present temperature [Pa]; the std holds the sensor's constant error
    WHEEL/leak_rate    loss at the present temperature [Pa/s]

Each wheel stands alone: one whose pressure sensor is dead is flagged and not watched, the others are. Without a
temperature signal warming is noise, and only leaks faster than warming and cooling (about 25 Pa/s) are found soon.
Without a wheel speed a load change after a stop looks like a lost 0.1 % of pressure per 75 kg on the wheel: slow leaks
take longer, and above that false alarms are more frequent. A deliberate release of air is a leak.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from estimators.car import Car
from estimators.direct_pressure import numbers
from estimators.direct_pressure.low_pressure import LowPressure
from estimators.direct_pressure.monitor import (
    LEAK,
    PRESSURE,
    REFILL,
    SAID,
    SINCE,
    SPEED,
    TEMPERATURE,
    follow,
    new_memory,
)
from estimators.direct_pressure.noise import INTERVAL
from estimators.direct_pressure.samples import Complaint, Source, Turning, horizon_of, merged
from estimators.direct_pressure.standing import SLOWEST
from estimators.drive_log import WHEELS, Signal
from estimators.estimator import Alarm, Estimate, Estimator, Flag, Outputs
from estimators.grid import REPEAT

SIGNALS = ("tyre/{}/pressure", "tyre/{}/temperature", "wheel/{}/speed")


class _Wheel:
    """One tyre's sensors, memory and warnings."""

    def __init__(self, name: str, car: Car) -> None:
        self.name = name
        self.pressure = Source(
            f"tyre/{name}/pressure", numbers.LOWEST_PRESSURE, numbers.HIGHEST_PRESSURE, f"{name} is not watched"
        )
        self.warmth = Source(
            f"tyre/{name}/temperature", numbers.LOWEST_TEMPERATURE, numbers.HIGHEST_TEMPERATURE,
            steepest=(numbers.TEMPERATURE_STEP, numbers.TEMPERATURE_RATE),
        )  # fmt: skip
        self.speed = Source(f"wheel/{name}/speed", -numbers.FASTEST_WHEEL, numbers.FASTEST_WHEEL)
        self.turning = Turning(SLOWEST)
        self.memory = new_memory()
        self.low = LowPressure(car.pressure)
        self.second: int | None = None

    @property
    def sources(self) -> tuple[Source, ...]:
        return self.pressure, self.warmth, self.speed

    def step(self, horizon: float, alarms: list[Alarm]) -> tuple[np.ndarray, list[Complaint]]:
        """Rows of `SAID` to tell, one a second, and complaints; appends due alarms."""
        (time, value, complaints), warmth, speed = (source.take(horizon) for source in self.sources)
        complaints += warmth[2] + speed[2]
        events = merged((SPEED, *self.turning.thinned(*speed[:2])), (TEMPERATURE, *warmth[:2]), (PRESSURE, time, value))
        row, told = np.empty((1, len(SAID))), []
        for i in range(len(events.time)):  # one at a time: an alarm's text is of its own moment
            if not follow(self.memory, events.time[i : i + 1], events.kind[i : i + 1], events.value[i : i + 1], row):
                continue
            now = float(row[0, 0])
            if row[0, 6] == REFILL:
                self.low.reset()
                complaints.append((now, f"{self.pressure.name}: pressure rose at once, taken for filled"))
            if row[0, 6] == LEAK:
                alarms.append(Alarm(now, self._leak(*row[0, :5].tolist()), (self.name,)))
            if warning := self.low.step(float(row[0, 1]), float(row[0, 2]), self.memory.noise[INTERVAL]):
                alarms.append(Alarm(now, warning, (self.name,)))
            if self.second != int(np.floor(now)):
                self.second = int(np.floor(now))
                told.append(row[0].copy())
        return np.array(told).reshape(-1, len(SAID)), complaints

    def _leak(self, time: float, pressure: float, _: float, rate: float, std: float) -> str:
        hours = numbers.BETWEEN_FALSE_ALARMS / 3600.0
        return (
            f"leak: {1e-3 * rate:.3g} kPa/s (std {1e-3 * std:.2g}) since about {self.memory.status[SINCE]:.0f} s, "
            f"{1e-3 * pressure:.0f} kPa left; false alarms: one in {hours:.0f} h"
        )


class DirectPressure(Estimator):
    """Four wheels side by side."""

    name = "direct_pressure"
    requires = ()
    requires_any = tuple(f"tyre/{wheel}/pressure" for wheel in WHEELS)
    reads = tuple(name.format(wheel) for name in SIGNALS for wheel in WHEELS)

    def __init__(self, car: Car) -> None:
        super().__init__(car)
        self._wheels = tuple(_Wheel(wheel, car) for wheel in WHEELS)
        self._raised: dict[str, float] = {}

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        """See `Estimator.update`."""
        complaints: list[Complaint] = []
        for source in self._sources():
            if source.name in samples:
                complaints += source.add(samples[source.name])
        horizon, alarms = horizon_of(until), list[Alarm]()
        self._expect(horizon)
        rows = {}
        for wheel in self._wheels:
            rows[wheel.name], more = wheel.step(horizon, alarms)
            complaints += more
        estimates: dict[str, Estimate] = {}
        for name, table in rows.items():
            if len(table):
                time, std = table[:, 0].copy(), np.hypot(table[:, 2], numbers.TOLERANCE)
                estimates[f"{name}/pressure"] = Estimate(time, table[:, 1].copy(), std, "Pa")
                estimates[f"{name}/leak_rate"] = Estimate(time.copy(), table[:, 3].copy(), table[:, 4].copy(), "Pa/s")
        return Outputs(estimates, tuple(sorted(alarms)), self._flags(complaints))

    def _sources(self) -> list[Source]:
        return [source for wheel in self._wheels for source in wheel.sources]

    def _expect(self, horizon: float) -> None:
        """Once one sensor speaks the others should."""
        first = min((source.first_waiting() for source in self._sources()), default=np.inf)
        if first <= horizon:
            for source in self._sources():
                source.expect(first)

    def _flags(self, complaints: list[Complaint]) -> tuple[Flag, ...]:
        """In time order, the same text at most once in `REPEAT` seconds."""
        flags = []
        for time, text in sorted(complaints):
            if time - self._raised.get(text, -np.inf) >= REPEAT:
                self._raised[text] = time
                flags.append(Flag(time, text))
        return tuple(flags)
