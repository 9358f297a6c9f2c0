"""The driving scenarios of the thesis' two sets (Razavi, Lund 2006, section 1.1.3), as seeded drives.

Set A (`SET_A`): ten driven so that the residual of the motor's position becomes as large as it can: rapid steering at
speeds at which the ratio is direct. Set B (`CASES`): fifty, those ten and forty that cover every size of residual down
to none: straight on, motorway, country, town, lane changes, slaloms, circles, parking. The thesis says no more of them
than that, so manoeuvres and speeds are declared. All with active steering. They last 10 s (longer where the manoeuvre
is slow), as the thesis' time axes do; a fault begins at 5 s there. Each repetition drives them on roads, with payloads
and sensors of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.scenario import Scenario
from testbed.study.study import run_seed

KMH = 1.0 / 3.6
DURATION = 10.0  # s
ROADS = ("A", "B", "C")
CALM, BRISK, RAPID = "calm", "brisk", "rapid"


@dataclass(frozen=True)
class Case:
    """name: of the scenario; group: CALM, BRISK or RAPID; speed in km/h; duration in s."""

    name: str
    group: str
    manoeuvre: str
    speed: float
    duration: float = DURATION

    def scenario(self, seed: int, number: int) -> Scenario:
        """Of repetition `number` of a study's seed; sensors differ from one repetition to the next as cars do."""
        own = run_seed(seed, number, CASES.index(self))
        rng = np.random.default_rng(own)
        return Scenario(
            road=str(rng.choice(ROADS)),
            manoeuvre=self.manoeuvre,
            speed=self.speed * KMH * float(rng.uniform(0.97, 1.03)),
            duration=self.duration,
            payload=float(rng.uniform(0.0, 300.0)),
            driven=str(rng.choice(["front", "rear"])),
            seed=own,
            car_seed=run_seed(seed, number, len(CASES)),
            active_steering=True,
        )


def _cases(group: str, manoeuvre: str, *speeds: float, duration: float = DURATION) -> tuple[Case, ...]:
    return tuple(Case(f"{manoeuvre}-{speed:g}", group, manoeuvre, speed, duration) for speed in speeds)


SET_A = _cases(RAPID, "rapid-steering", 8.0, 10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 25.0, 30.0, 35.0)

CASES = (
    *SET_A,
    *_cases(CALM, "constant", 20.0, 50.0, 80.0, 130.0),
    *_cases(CALM, "motorway", 90.0, 110.0, 130.0, 160.0, duration=20.0),
    *_cases(CALM, "country", 40.0, 60.0, 80.0, 100.0, duration=20.0),
    *_cases(CALM, "stops", 30.0, 50.0, duration=20.0),
    *_cases(CALM, "circle", 20.0, 30.0, 50.0, 80.0),
    *_cases(CALM, "double-lane-change", 60.0, 80.0, 100.0, 120.0),
    *_cases(CALM, "slalom", 60.0, 90.0),
    *_cases(BRISK, "town", 15.0, 20.0, duration=30.0),
    *_cases(BRISK, "tight-circle", 10.0, 15.0, 18.0),
    *_cases(BRISK, "slalom", 15.0, 25.0, 40.0),
    *_cases(BRISK, "evasion", 40.0, 50.0, 70.0, 90.0),
    *_cases(BRISK, "parking", 4.0, 6.0, duration=20.0),
    *_cases(RAPID, "rapid-steering", 45.0, 60.0),
)
