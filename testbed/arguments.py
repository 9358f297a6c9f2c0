"""The command line of a drive: options with their units, and the scenario they mean.

Whatever is typed in km/h, kPa, kPa/s, Celsius or per cent becomes SI here and nowhere else.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import NoReturn

from estimators.drive_log import WHEELS
from estimators.faults import FORM, fault_kinds
from testbed.brake_pull import BrakePull
from testbed.manoeuvres.manoeuvre import manoeuvres
from testbed.scenario import DRIVEN, Scenario
from testbed.tyre.inflation import Leak, PressureSet

KELVIN = 273.15
RECORDINGS = Path("recordings")


# option -> lowest, highest value and unit, as typed
LIMITS = {
    "--speed": (0.0, 200.0, "km/h"),
    "--duration": (0.01, 86400.0, "s"),
    "--load": (0.0, 1000.0, "kg"),
    "--grade": (-30.0, 30.0, "%"),
    "--bank": (-20.0, 20.0, "%"),
    "--wind": (0.0, 140.0, "km/h"),
    "--wind direction": (-360.0, 360.0, "deg"),
    "--wind gusts": (0.0, 100.0, "%"),
    "--ambient": (-40.0, 60.0, "Celsius"),
}


class Parser(argparse.ArgumentParser):
    """argparse whose complaint is one line."""

    def parse_args(self, args=None, namespace=None):
        """As argparse, but a value may begin with a minus: `--load-position -0.8,0,0`."""
        words = list(sys.argv[1:] if args is None else args)
        for i in range(len(words) - 1, 0, -1):
            if re.match(r"-[\d.]", words[i]) and re.fullmatch(r"--[a-z-]+", words[i - 1]):
                words[i - 1 : i + 1] = [f"{words[i - 1]}={words[i]}"]
        return super().parse_args(words, namespace)

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}\n")


def _number(text: str, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"{what}: {text!r} is not a number") from None
    if not math.isfinite(value):
        raise ValueError(f"{what}: {text!r} is not a finite number")
    return value


def _quantity(option: str, text: str) -> float:
    """A number as typed, within its limits."""
    value = _number(text, option)
    low, high, unit = LIMITS[option]
    if not low <= value <= high:
        raise ValueError(f"{option} {text} {unit} is out of range; valid: {low:g} to {high:g} {unit}")
    return value


def _wheel_values(items: Iterable[str], option: str, form: str) -> dict[str, str]:
    """`fl=180` or `all=180`, several by commas or by repeating the option, as wheel -> text. A wheel of its own comes
    before `all`; the same twice is a mistake."""
    values: dict[str, str] = {}
    named: set[str] = set()
    for item in [part for text in items for part in text.split(",")]:
        wheel, equals, value = item.partition("=")
        if not equals or not value:
            raise ValueError(f"{option} {item!r}: want {form}")
        if wheel not in (*WHEELS, "all"):
            raise ValueError(f"{option} {item!r}: unknown wheel {wheel!r}; valid: {', '.join(WHEELS)}, all")
        if wheel in named:
            raise ValueError(f"{option} {item!r}: {wheel} is given twice")
        named.add(wheel)
        fresh = [w for w in WHEELS if w not in named] if wheel == "all" else [wheel]
        values.update(dict.fromkeys(fresh, value))
    return values


def _leaks(items: Iterable[str]) -> dict[str, Leak]:
    leaks = {}
    for wheel, text in _wheel_values(items, "--leak", "WHEEL=RATE[@START], such as rr=5@20").items():
        rate, _, start = text.partition("@")
        leaks[wheel] = Leak(1e3 * _number(rate, "--leak rate"), _number(start or "0", "--leak start"))
    return leaks


def _pressure_sets(items: Iterable[str]) -> dict[str, PressureSet]:
    changes = {}
    for wheel, text in _wheel_values(items, "--set", "WHEEL=PRESSURE@START[/WITHIN], such as fl=130@30/1.5").items():
        pressure, _, when = text.partition("@")
        start, _, within = when.partition("/")
        if not start:
            raise ValueError(f"--set {wheel}={text}: want WHEEL=PRESSURE@START[/WITHIN], such as fl=130@30/1.5")
        changes[wheel] = PressureSet(
            1e3 * _number(pressure, "--set pressure"),
            _number(start, "--set start"),
            _number(within or "0.1", "--set within"),
        )
    return changes


def _brake_pulls(items: Iterable[str]) -> dict[str, BrakePull]:
    pulls = {}
    form = "WHEEL=NM@START[-END], such as rl=3000@20-21"
    for wheel, text in _wheel_values(items, "--brake", form).items():
        torque, _, when = text.partition("@")
        start, dash, end = when.partition("-")
        if not start or (dash and not end):
            raise ValueError(f"--brake {wheel}={text}: want {form}")
        span = [_number(word, "--brake time") for word in ([start, end] if end else [start])]
        pulls[wheel] = BrakePull(_number(torque, "--brake torque"), *span)
    return pulls


def drive_parser() -> Parser:
    """The parser of `python -m testbed.drive`."""
    defaults = Scenario()
    p = Parser(
        prog="testbed.drive",
        description="Drives a multibody car over a road and leaves a recording, which is also its log, and a table.",
        epilog="manoeuvres: " + "; ".join(f"{name}: {m.about}" for name, m in manoeuvres().items()),
    )
    add = p.add_argument
    add(
        "--road",
        default=defaults.road,
        help="ISO 8608 class A to H, a sequence A:200,D:300 (metres), gd=5e-5 (m^3), gd=5e-5^2.5 (of slope "
        "-2.5 in place of -2), flat, an OpenCRG file .crg or a profile .txt with x z (default %(default)s)",
    )
    add("--speed", default="80", help="km/h, 0 to 200 (default %(default)s)")
    add("--duration", default="60", help="s, 0.01 to 86400 (default %(default)s)")
    add("--manoeuvre", default=defaults.manoeuvre, help="one of those below (default %(default)s)")
    add(
        "--pressure",
        action="append",
        default=[],
        metavar="WHEEL=KPA",
        help="gauge pressure at the start in kPa, 0 (a flat tyre) to 500, such as fl=180 or all=200",
    )
    add(
        "--leak",
        action="append",
        default=[],
        metavar="WHEEL=RATE@START",
        help="leak in kPa/s from a time in s on, such as rr=5@20; it dies out as the tyre goes flat",
    )
    add(
        "--set",
        action="append",
        default=[],
        metavar="WHEEL=KPA@START/WITHIN",
        dest="sets",
        help="bring a tyre to a pressure during the drive, such as fl=130@30/1.5 (kPa, s, s; without the last, "
        "within 0.1 s)",
    )
    add(
        "--brake",
        action="append",
        default=[],
        metavar="WHEEL=NM@START-END",
        help="a brake that pulls on its own, past the anti-lock control, such as rl=3000@20-21 (N m, s)",
    )
    add("--load", default="0", help="payload in kg, 0 to 1000 (default %(default)s)")
    add(
        "--load-position",
        default="-0.6,0,0",
        help="its centre x,y,z from the chassis' centre of gravity in m, each within 3 (default %(default)s)",
    )
    add(
        "--tyre",
        default=defaults.tyre,
        help="a tyre of models/tyres or a property file .toml or .tir (default %(default)s)",
    )
    add(
        "--radius",
        action="append",
        default=[],
        metavar="WHEEL=PERCENT",
        help="a tyre's radius off nominal in per cent, within 10, such as rl=-0.3 (wear, spread of new tyres)",
    )
    add(
        "--friction",
        default=defaults.friction,
        help="0.9, left/right 0.9/0.3, or along the road 0.9:100,0.9/0.2:50 (m)",
    )
    add("--grade", default="0", help="rise of the road in per cent, -30 to 30 (default %(default)s)")
    add("--bank", default="0", help="cross slope in per cent, left side up, -20 to 20 (default %(default)s)")
    add(
        "--wind",
        default="0",
        metavar="KMH@DEG/PERCENT",
        help="such as 30@90/25: mean speed in km/h, 0 to 140; where it comes from in degrees, 0 (default) against a "
        "car that drives along x, 90 from its left; gusts in per cent of the mean, 0 to 100 (default 15)",
    )
    add(
        "--obstacle",
        action="append",
        default=[],
        help="cleat@50:height=20,length=30,side=left (m, then mm) or pothole@80:depth=60,length=400,side=right",
    )
    add(
        "--fault",
        action="append",
        default=[],
        metavar="FAULT",
        help=f"of a sensor: {FORM}; kinds: "
        + "; ".join(f"{name}: {kind.about}" for name, kind in fault_kinds().items()),
    )
    add("--driven", default=defaults.driven, help=f"driven axle: {', '.join(DRIVEN)} (default %(default)s)")
    add(
        "--active-steering",
        action="store_true",
        help="a motor superposes an angle on the driver's: the steering ratio varies with the speed",
    )
    add(
        "--faults-in-loop",
        action="store_true",
        help="the motor's control works on a faulty steering/motor_angle; without it only the log shows the fault",
    )
    add("--lock-steering", metavar="S", help="lock that motor at a time in s; the gear's own ratio is left")
    add("--ambient", default="20", help="air temperature in Celsius, -40 to 60 (default %(default)s)")
    add("--seed", default="0", help="of road and sensors (default %(default)s)")
    add("--car-seed", help="of what differs from one sensor to the next of its kind (default: as --seed)")
    add("--sensors", metavar="FILE", help='JSON that overrides sensor settings, such as {"imu/gyro": {"noise": 0.001}}')
    add("--estimators", metavar="NAMES", help="by commas; default all that keep their rate; none for no estimator")
    add("--calibration", metavar="FILE", help="start from what the estimators learnt: the --json of an earlier drive")
    add("--scenario", metavar="FILE", help="JSON of a saved scenario; the other options of the drive are then not read")
    add("--out", metavar="FILE.rrd", help="the recording (default recordings/ROAD.rrd)")
    add("--json", metavar="FILE", help="write every figure of the table, and more, as JSON")
    add("--quiet", action="store_true", help="no progress bar, no table")
    return p


def _position(text: str) -> tuple[float, float, float]:
    parts = [_number(part, "--load-position") for part in text.split(",")]
    if len(parts) != 3:
        raise ValueError(f"--load-position {text!r}: want x,y,z in m")
    return parts[0], parts[1], parts[2]


def _wind(text: str) -> dict[str, float]:
    """Fields of the scenario of KMH[@DEG][/PERCENT]."""
    front, slash, gusts = text.partition("/")
    speed, at, direction = front.partition("@")
    if (slash and not gusts) or (at and not direction):
        raise ValueError(f"--wind {text!r}: want KMH[@DEG][/PERCENT], such as 30@90/25")
    found = {"wind": _quantity("--wind", speed) / 3.6}
    if at:
        found["wind_from"] = math.radians(_quantity("--wind direction", direction))
    if slash:
        found["gusts"] = 0.01 * _quantity("--wind gusts", gusts)
    return found


def _seed(text: str, option: str = "--seed") -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"{option} {text!r}: want a whole number of 0 or more") from None


def read_json(path: str, what: str) -> dict:
    """A JSON object from a file. ValueError names the file."""
    try:
        content = json.loads(Path(path).read_text())
    except OSError as error:
        raise ValueError(f"{what} {path}: {error.strerror}") from None
    except ValueError as error:
        raise ValueError(f"{what} {path}: not JSON ({error})") from None
    if not isinstance(content, dict):
        raise ValueError(f"{what} {path}: want a JSON object")
    return content


def scenario_of(options: argparse.Namespace) -> Scenario:
    """The scenario that the options mean. ValueError with one line that names the bad value and the valid ones."""
    for name in ("scenario", "sensors", "calibration", "out", "json"):
        if getattr(options, name) == "":
            raise ValueError(f"--{name} '': want the name of a file")
    if options.scenario:
        content = read_json(options.scenario, "--scenario")
        try:
            return Scenario.from_notes(content.get("scenario", content))
        except (TypeError, AttributeError) as error:
            raise ValueError(f"--scenario {options.scenario}: {error}") from None
    pressures = _wheel_values(options.pressure, "--pressure", "WHEEL=KPA, such as fl=180")
    radii = _wheel_values(options.radius, "--radius", "WHEEL=PERCENT, such as rl=-0.3")
    return Scenario(
        road=options.road,
        speed=_quantity("--speed", options.speed) / 3.6,
        duration=_quantity("--duration", options.duration),
        manoeuvre=options.manoeuvre,
        tyre=options.tyre,
        seed=_seed(options.seed),
        car_seed=_seed(options.car_seed, "--car-seed") if options.car_seed is not None else None,
        pressures={w: 1e3 * _number(v, "--pressure") for w, v in pressures.items()},
        leaks=_leaks(options.leak),
        pressure_sets=_pressure_sets(options.sets),
        brake_pulls=_brake_pulls(options.brake),
        radius_factor={w: 1.0 + 0.01 * _number(v, "--radius") for w, v in radii.items()},
        payload=_quantity("--load", options.load),
        payload_position=_position(options.load_position),
        friction=options.friction,
        grade=0.01 * _quantity("--grade", options.grade),
        bank=0.01 * _quantity("--bank", options.bank),
        **_wind(options.wind),
        obstacles=tuple(options.obstacle),
        faults=tuple(options.fault),
        driven=options.driven,
        ambient=round(_quantity("--ambient", options.ambient) + KELVIN, 9),
        sensors=read_json(options.sensors, "--sensors") if options.sensors else {},
        active_steering=options.active_steering,
        faults_in_loop=options.faults_in_loop,
        steering_lock=_number(options.lock_steering, "--lock-steering") if options.lock_steering is not None else None,
    )
