"""What the estimators said of a log, as a JSON document and as tables.

The document holds SI values at the end of the log; see `estimate_table` for the tables. It also
holds the calibration that was learnt, which `Bank` takes back for the next drive of the same car.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from estimators.car import Car
from estimators.drive_log import DriveLog, Signal
from estimators.estimate_table import estimate_tables
from estimators.runner import Bank

RADIUS_PAIRS = {"delta12": ("fl", "fr"), "delta34": ("rl", "rr"), "delta13": ("rl", "fl"), "delta24": ("rr", "fr")}
Z95 = 1.959964  # standard normal quantile of a two-sided 95 % interval


def document(path: str, log: DriveLog, car: Car, bank: Bank, said: Mapping[str, Signal]) -> dict[str, Any]:
    """Last estimates, alarms, flags and calibrations by estimator; JSON values, SI."""
    missing = bank.missing(usable_signals(log))
    methods = {
        name: {
            "missing_signals": missing.get(name, []),
            "estimates": _last_estimates(name, said),
            "alarms": [{"time_s": a.time, "wheels": list(a.wheels), "text": a.text} for a in bank.alarms[name]],
            "flags": [{"time_s": f.time, "text": f.text} for f in bank.flags[name]],
        }
        for name in bank.names
    }
    told = "car" in log.notes
    return {
        "log": path,
        "car": asdict(car),
        "car_is_of_the_log": told,
        "estimators": methods,
        "calibration": bank.calibrations(),
        "rows": radius_rows(methods),
    }


def radius_rows(methods: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """ln(radius of one wheel / radius of another) as rows of the studies' form, `ci95` two-sided and Gaussian; none
    where `wheel_radius` does not know it."""
    estimates = methods.get("wheel_radius", {}).get("estimates", {})
    rows = []
    for delta, (over, under) in RADIUS_PAIRS.items():
        if delta not in estimates:
            continue
        ratio, std = estimates[delta]["value"], estimates[delta]["std"]
        here, std = math.log1p(ratio), std / (1.0 + ratio)
        ci95 = [here - Z95 * std, here + Z95 * std]
        name = f"ln_radius_{over}_over_{under}"
        rows.append({"name": name, "unit": "-", "paper": None, "here": here, "ci95": ci95, "limit": None})
    return rows


def usable_signals(log: DriveLog) -> list[str]:
    """Signals that an estimator may see and that hold at least one sample."""
    return [name for name, signal in log.visible().items() if len(signal)]


def _last_estimates(name: str, said: Mapping[str, Signal]) -> dict[str, dict[str, Any]]:
    prefix = f"est/{name}/"
    last = {}
    for path, signal in said.items():
        if path.startswith(prefix) and f"{path}/std" in said:
            std = said[f"{path}/std"]
            last[path.removeprefix(prefix)] = {
                "time_s": float(signal.time[-1]),
                "value": float(signal.value[-1]),
                "std": float(std.value[-1]),
                "unit": signal.unit,
            }
    return last


def print_report(console: Console, result: Mapping[str, Any]) -> None:
    """What car is assumed; a table per estimator, then its alarms and flags."""
    car = result["car"]
    whose = "the log's" if result["car_is_of_the_log"] else "the log names none, so the default is assumed (--car FILE)"
    known = (
        f"{car['driven_axle']} axle driven, {car['pressure'] * 1e-3:g} kPa, radius {car['rolling_radius'] * 1e3:g} mm"
    )
    console.print(f"car: {whose}: {known}", highlight=False, soft_wrap=True)
    for name, method in result["estimators"].items():
        if method["missing_signals"]:
            console.print(f"{name}: unavailable, no {', '.join(method['missing_signals'])}", highlight=False)
            continue
        for table in estimate_tables({name: method["estimates"]}, f"at the end of {Path(result['log']).name}"):
            console.print(table)
        if not method["estimates"]:
            console.print(f"{name}: nothing estimated")
        for row in result["rows"] if name == "wheel_radius" else ():
            low, high = (1e3 * end for end in row["ci95"])
            console.print(
                f"{row['name']} {1e3 * row['here']:+.2f}e-3, 95 % {low:+.2f}e-3 to {high:+.2f}e-3", highlight=False
            )
        for flag in method["flags"]:
            console.print(f"flag  {flag['time_s']:9.1f} s  {flag['text']}", highlight=False, markup=False)
        for alarm in method["alarms"]:
            wheels = " ".join(alarm["wheels"])
            console.print(f"ALARM {alarm['time_s']:9.1f} s  {wheels}: {alarm['text']}", highlight=False, markup=False)
        if not method["alarms"]:
            console.print("no alarms")


def read_json_object(path: Path) -> dict[str, Any]:
    """A JSON object from a file. ValueError in one line if there is none."""
    try:
        content = json.loads(path.read_text())
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise ValueError(f"{path}: no JSON ({error})") from None
    if not isinstance(content, dict):
        raise ValueError(f"{path}: holds {type(content).__name__}, want a JSON object")
    return content


def read_calibration(path: Path) -> dict[str, Any]:
    """The calibrations in a file that `write_json` wrote. ValueError in one line if it holds none."""
    found = read_json_object(path).get("calibration")
    if not isinstance(found, dict) or not found or not all(isinstance(entry, dict) for entry in found.values()):
        raise ValueError(f"{path}: holds no calibration, want the --json output of a drive on which one was learnt")
    return found
