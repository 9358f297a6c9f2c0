"""What a drive comes to: means per wheel, estimates, alarms; as a table to read and as JSON to compute from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from rich.console import Console

from estimators.drive_log import WHEELS, Signal
from estimators.estimate_table import estimate_tables, wheel_table
from testbed.simulation import Stretch
from testbed.tyre.vertical import VerticalLaw, mean_stiffness

# JSON name, column of the trace
MEANS = (
    ("pressure_kpa", "pressure", 1e-3),
    ("temperature_c", "temperature", 1.0),
    ("rolling_radius_m", "rolling_radius", 1.0),
    ("load_n", "load", 1.0),
    ("mean_speed_rad_s", "rim_speed", 1.0),
)
KELVIN = 273.15


class Summary:
    """Running means over a drive, and the last word of every estimate. Bounded memory."""

    def __init__(self, law: VerticalLaw) -> None:
        """law: of the tyres, for the stiffness at the mean load, speed and pressure."""
        self._law = law
        self._sums = {name: np.zeros(4) for name, _, _ in MEANS}
        self._last: dict[str, np.ndarray] = {}
        self._rows = 0
        self._distance = 0.0
        self._estimates: dict[str, tuple[float, float | None, str]] = {}
        self._alarms: list[dict[str, Any]] = []
        self._flags: list[dict[str, Any]] = []

    def add(self, stretch: Stretch) -> None:
        """Another stretch of the drive."""
        for name, column, _ in MEANS:
            self._sums[name] += stretch[column].sum(axis=0)
            self._last[name] = stretch[column][-1]
        self._rows += len(stretch.rows)
        speed = np.hypot(stretch["velocity"][:, 0], stretch["velocity"][:, 1])
        self._distance += float(speed.sum()) * self._step(stretch)

    @staticmethod
    def _step(stretch: Stretch) -> float:
        time = stretch["time"]
        return float(time[1] - time[0]) if len(time) > 1 else 0.0

    def say(self, signals: Mapping[str, Signal]) -> None:
        """What the estimators said in a stretch: `est/...` and `alarm/...` signals."""
        for name, signal in signals.items():
            if not len(signal):
                continue
            if signal.value.dtype == object:
                said = self._alarms if name.startswith("alarm/") else self._flags
                for time, text in zip(signal.time, signal.value, strict=True):
                    said.append({"time_s": float(time), "method": name.split("/")[1], "text": str(text)})
            elif not name.endswith("/std"):
                std = signals.get(name + "/std")
                spread = float(np.ravel(std.value[-1])[0]) if std is not None and len(std) else None
                self._estimates[name] = (float(np.ravel(signal.value[-1])[0]), spread, signal.unit)

    def as_json(self) -> dict[str, Any]:
        """JSON values: wheels, estimates, alarms, flags (what an estimator says of itself), distance."""
        n = max(self._rows, 1)
        wheels = {}
        for i, wheel in enumerate(WHEELS):
            figures = {name: float(self._sums[name][i] / n * scale) for name, _, scale in MEANS}
            figures["temperature_c"] -= KELVIN
            figures["stiffness_n_per_m"] = mean_stiffness(
                self._law, 1e3 * figures["pressure_kpa"], figures["mean_speed_rad_s"], figures["load_n"]
            )
            figures["final_pressure_kpa"] = float(self._last["pressure_kpa"][i] * 1e-3)
            wheels[wheel] = figures
        estimates = {
            name: {"value": _finite(value), "std": _finite(std), "unit": unit}
            for name, (value, std, unit) in sorted(self._estimates.items())
        }
        return {
            "distance_m": self._distance,
            "wheels": wheels,
            "estimates": estimates,
            "alarms": self._alarms,
            "flags": self._flags,
        }


def _finite(value: float | None) -> float | None:
    return value if value is not None and np.isfinite(value) else None


def print_summary(console: Console, result: Mapping[str, Any]) -> None:
    """The table of a drive."""
    title = f"{result['road']}, {result['distance_m']:.0f} m in {result['sim_s']:.0f} s"
    table = wheel_table(title)
    rows = (
        ("true pressure (kPa)", "pressure_kpa", "{:.1f}"),
        ("  at the end", "final_pressure_kpa", "{:.1f}"),
        ("tyre temperature (C)", "temperature_c", "{:.1f}"),
        ("true stiffness (kN/m)", "stiffness_n_per_m", "{:.1f}"),
        ("true rolling radius (mm)", "rolling_radius_m", "{:.2f}"),
        ("true load (N)", "load_n", "{:.0f}"),
        ("wheel speed (rad/s)", "mean_speed_rad_s", "{:.3f}"),
    )
    scale = {"stiffness_n_per_m": 1e-3, "rolling_radius_m": 1e3}
    for label, name, form in rows:
        values = (result["wheels"][w][name] * scale.get(name, 1.0) for w in WHEELS)
        table.add_row(label, *(form.format(v) for v in values))
    console.print(table)
    for estimates in estimate_tables(_by_method(result["estimates"]), "at the end"):
        console.print(estimates)
    for flag in result["flags"]:
        console.print(f"[dim]{flag['time_s']:.1f} s  {flag['method']}: {flag['text']}[/]")
    for alarm in result["alarms"]:
        console.print(f"[bold red]alarm[/] {alarm['time_s']:.1f} s  {alarm['method']}: {alarm['text']}")
    if result["estimates"] and not result["alarms"]:
        console.print("no alarms")


def _by_method(estimates: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """`est/METHOD/quantity` -> method -> quantity."""
    methods: dict[str, dict[str, Any]] = {}
    for name, entry in estimates.items():
        _, method, quantity = name.split("/", 2)
        methods.setdefault(method, {})[quantity] = entry
    return methods
