"""Which sensors stand accused in a drive: by whom, since when, how sure; as lanes and as what is drawn red.

est/verdict/SENSOR    text: who accuses it since when and how often that is false; "" once all believe it again

A sensor's samples are red (`accused`) from its first accusation on until it is believed again."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from estimators.accusation import LOW, of_alarm, rate_of, taken_back, withdrawn
from estimators.drive_log import Signal
from estimators.faults.targets import find_target
from estimators.runner import Bank
from testbed.recording.series import VERDICT

EVERY = 0.01  # s between two red samples at least


class Verdicts:
    """Of one drive's bank."""

    def __init__(self, bank: Bank) -> None:
        self._bank = bank
        self._seen = {name: [0, 0] for name in bank.names}  # alarms, flags
        self._standing: dict[str, dict[str, tuple[float, str]]] = {}  # sensor -> monitor -> since, how sure
        self._spans: dict[str, list[tuple[float, float]]] = {}  # sensor -> from, to [s]

    def update(self) -> dict[str, Signal]:
        """Lanes of what the bank has said since the last call."""
        events: list[tuple[float, str, str, str | None]] = []
        for name in self._bank.names:
            alarms, flags = self._bank.alarms[name], self._bank.flags[name]
            first, after = self._seen[name]
            self._seen[name] = [len(alarms), len(flags)]
            for alarm in alarms[first:]:
                events += [(a.time, a.accused, name, rate_of(alarm)) for a in of_alarm(name, alarm)]
                events += [(alarm.time, sensor, name, None) for sensor in withdrawn(name, alarm)]
            for flag in flags[after:]:
                events += [(flag.time, sensor, name, None) for sensor in taken_back(name, flag)]
        lanes: dict[str, list[tuple[float, str]]] = {}
        for time, sensor, monitor, rate in sorted(events, key=lambda e: (e[0], e[1], e[2], e[3] or "")):
            standing = self._standing.setdefault(sensor, {})
            if sensor.startswith(LOW) or (rate is None and monitor not in standing):
                continue
            if rate is not None:
                standing.setdefault(monitor, (time, rate))
            else:
                del standing[monitor]
            self._mark(sensor, time, bool(standing))
            lanes.setdefault(sensor, []).append((time, _text(standing)))
        return {VERDICT + sensor: Signal([t for t, _ in said], [text for _, text in said])
                for sensor, said in lanes.items()}  # fmt: skip

    def _mark(self, sensor: str, time: float, accused: bool) -> None:
        spans = self._spans.setdefault(sensor, [])
        if accused and not (spans and spans[-1][1] == np.inf):
            spans.append((time, np.inf))
        elif not accused and spans:
            spans[-1] = (spans[-1][0], time)

    def accused(self, sensed: Mapping[str, Signal]) -> dict[str, Signal]:
        """The samples of accused sensors, by the name of the signal, of an axis with the axis."""
        found: dict[str, Signal] = {}
        for sensor, spans in self._spans.items():
            target = find_target(sensor)
            for name in target.signals:
                signal = sensed.get(name)
                if signal is None or name.endswith("/edges") or signal.value.dtype.kind != "f" or not len(signal):
                    continue
                red = np.zeros(len(signal), dtype=bool)
                for start, end in spans:
                    red |= (signal.time >= start) & (signal.time < end)
                if not red.any():
                    continue
                time, value = signal.time[red], signal.value[red]
                if value.ndim == 2:
                    kept = slice(None) if target.column is None else [target.column]
                    value = value[:, kept]
                _, first = np.unique(np.floor(time / EVERY), return_index=True)
                found[_overlay(name, sensor)] = Signal(time[first], value[first], signal.unit, signal.frame)
        return found


def _overlay(name: str, sensor: str) -> str:
    """`imu/accel/x` of an axis, else the signal itself."""
    return sensor if sensor.startswith(f"{name}/") else name


def _text(standing: Mapping[str, tuple[float, str]]) -> str:
    said = (f"{name} since {since:.2f} s" + (f" (false: {rate})" if rate else "")
            for name, (since, rate) in standing.items())  # fmt: skip
    return ", ".join(said)
