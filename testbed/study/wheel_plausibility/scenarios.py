"""The 58 scenarios, equivalents of the thesis' test drives: mu-split, high grip, rapid steering, the circle of 10 m.

Each is a name and what is driven; a repetition drives all of them on roads and with sensors of its own. Names of the
thesis' files say little more than that (fr_3.2_muesplit, fr_3.3_muehigh, f020_m051_r001 the circle), so speeds and
friction are declared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from testbed.scenario import Scenario
from testbed.study.study import run_seed

KMH = 1.0 / 3.6
DURATION = 20.0  # s
SPLIT, LEFT, HIGH, WET, ICE = "0.9/0.15", "0.15/0.9", "0.9", "0.5", "0.2"
ROADS = ("A", "B", "C")


@dataclass(frozen=True)
class Case:
    """group: muesplit, muehigh, muelow, steering or circle; fields: of the scenario, speed in km/h."""

    name: str
    group: str
    manoeuvre: str
    speed: float
    friction: str

    def scenario(self, seed: int, number: int, place: int, duration: float) -> Scenario:
        """Of repetition `number`; place: of the case in CASES."""
        own = run_seed(seed, number, place)
        rng = np.random.default_rng(own)
        drawn: dict[str, Any] = {
            "road": str(rng.choice(ROADS)), "payload": float(rng.uniform(0.0, 300.0)),
            "driven": str(rng.choice(["front", "rear"])),
        }  # fmt: skip
        return Scenario(
            manoeuvre=self.manoeuvre,
            speed=self.speed * KMH,
            friction=self.friction,
            duration=duration,
            seed=own,
            **drawn,
        )


def _cases() -> tuple[Case, ...]:
    found = []
    for speed in (40.0, 60.0, 80.0, 100.0):
        for friction in (SPLIT, LEFT):
            found.append(Case(f"brake_{speed:.0f}_{friction}", "muesplit", "brake", speed, friction))
    for speed in (30.0, 50.0, 70.0):
        for friction in (SPLIT, LEFT):
            found.append(Case(f"stops_{speed:.0f}_{friction}", "muesplit", "stops", speed, friction))
    for manoeuvre, speeds in (("brake", [50.0, 80.0, 110.0, 140.0]), ("stops", [30.0, 50.0, 70.0])):
        found += [Case(f"{manoeuvre}_{v:.0f}_{HIGH}", "muehigh", manoeuvre, v, HIGH) for v in speeds]
    for friction in (WET, ICE):
        found += [Case(f"brake_{v:.0f}_{friction}", "muelow", "brake", v, friction) for v in (50.0, 80.0)]
        found.append(Case(f"stops_40_{friction}", "muelow", "stops", 40.0, friction))
    for manoeuvre, speeds in (
        ("slalom", [40.0, 55.0, 70.0, 85.0, 100.0, 120.0]),
        ("double-lane-change", [60.0, 75.0, 90.0, 105.0, 120.0, 135.0]),
        ("evasion", [50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0]),
    ):
        found += [Case(f"{manoeuvre}_{v:.0f}_{HIGH}", "steering", manoeuvre, v, HIGH) for v in speeds]
    for friction in (WET, ICE):
        found.append(Case(f"slalom_50_{friction}", "steering", "slalom", 50.0, friction))
    found += [
        Case(f"circle_{v:.0f}_{f}", "circle", "tight-circle", v, f) for v in (10.0, 14.0, 18.0) for f in (HIGH, WET)
    ]
    found += [Case(f"wide_circle_{v:.0f}", "circle", "circle", v, HIGH) for v in (30.0, 40.0, 50.0, 70.0)]
    return tuple(found)


CASES = _cases()
