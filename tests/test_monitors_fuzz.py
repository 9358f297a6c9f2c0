"""No log, however broken, stops the monitors: faults upon faults, drawn at random, on every sensor at once."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from estimators.drive_log import WHEELS, DriveLog
from estimators.faults import inject
from estimators.faults.kind import fault_kinds
from estimators.faults.targets import UNITS
from estimators.registry import registered
from estimators.runner import run
from tests.synthetic_drive import Noise, drive, varied_speed
from tests.test_estimators_contract import assert_sound

SECONDS = 10.0
FAULTS = 16  # in a log
NUMBERS = {"": (0.0, 1.0), "s": (1e-3, 2.0)}  # from which a number is drawn, by unit; others up to HUGE
HUGE = (1e-3, 1.0, 1e3, 1e9)


@cache
def log() -> DriveLog:
    speed = varied_speed(SECONDS, 14.0, 2.0)
    speed[:150] = 0.0
    return drive(speed, curvature=3e-3, noise=Noise(), seed=8, hubs=True)


def drawn(rng: np.random.Generator) -> str:
    """One fault: any sensor, any kind that it can have, numbers of any size, any time."""
    while True:
        kind = list(fault_kinds().values())[int(rng.integers(len(fault_kinds())))]
        name = str(rng.choice(list(UNITS))).format(rng.choice(WHEELS))
        if (kind.wheels_only and not name.startswith("wheel/")) or (kind.name == "swap" and not _corner(name)):
            continue
        numbers = []
        for number in kind.numbers:
            low, high = NUMBERS.get(number.unit, (-float(rng.choice(HUGE)), float(rng.choice(HUGE))))
            numbers.append(f"{float(np.clip(rng.uniform(low, high), number.low, number.high)):.6g}")
        start = float(rng.uniform(0.0, SECONDS))
        end = f"-{start + float(rng.uniform(0.1, 10.0)):.3f}" if rng.random() < 0.5 else ""
        return f"{name}={kind.name}{':' if numbers else ''}{','.join(numbers)}@{start:.3f}{end}"


def _corner(name: str) -> bool:
    return any(part in WHEELS for part in name.split("/"))


@pytest.mark.parametrize("seed", range(4))
def test_any_combination_of_faults_is_survived_by_every_monitor(seed: int) -> None:
    rng = np.random.default_rng(seed)
    faults = [drawn(rng) for _ in range(FAULTS)]
    broken = inject(log(), faults, seed)
    for name in registered():
        assert_sound(run(broken, [name], float(rng.choice([0.3, 1.0, 7.0]))), name)


def test_all_sensors_dead_at_once_is_survived() -> None:
    for kind in ("stuck", "dropout", "noise:100"):
        sensors = [name for name in UNITS if not name.endswith(("/edges", "/speed"))]
        dead = [f"{name.format(w)}={kind}@6" for name in sensors for w in (WHEELS if "{}" in name else WHEELS[:1])]
        for name in registered():
            assert_sound(run(inject(log(), dead), [name]), name)
