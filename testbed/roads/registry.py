"""From a text to a road: finds every kind of road in this folder and lets the one that recognises the text build it."""

from __future__ import annotations

import importlib
import math
import pkgutil
from collections.abc import Sequence
from functools import cache

import testbed.roads
from testbed.roads.laid_road import LaidRoad
from testbed.roads.obstacles import parse_obstacle
from testbed.roads.road import RoadKind

UNREPEATED_TIME = 60.0  # [s] the longest window an estimator sees; a road must not come round within it
_TOP_SPEED = 100.0  # [m/s]
_STEEPEST = 0.5  # [-] grade and bank
_LENGTH_STEP = 750.0  # [m] lengths come in such steps, so neighbouring speeds share one and the same road


@cache
def road_kinds() -> tuple[RoadKind, ...]:
    """Every kind of road: the `KIND` of each module in this folder that has one, in order of module names."""
    names = [m.name for m in pkgutil.iter_modules(testbed.roads.__path__) if not m.name.startswith("_")]
    modules = [importlib.import_module(f"testbed.roads.{name}") for name in names]
    return tuple(module.KIND for module in modules if isinstance(getattr(module, "KIND", None), RoadKind))


def road_forms() -> str:
    """The forms a road's text may take, for help and error messages."""
    return "; ".join(kind.form for kind in road_kinds())


def unrepeated_length(speed: float, duration: float) -> float:
    """Length [m] that must not repeat: 60 s (or the whole drive) at `speed` [m/s], 10 % to spare, at least 1500 m."""
    wanted = 1.1 * speed * min(duration, UNREPEATED_TIME)
    return max(math.ceil(wanted / _LENGTH_STEP), 2) * _LENGTH_STEP


def make_road(
    spec: str,
    seed: int,
    speed: float,
    duration: float,
    *,
    grade: float = 0.0,
    bank: float = 0.0,
    obstacles: Sequence[str] = (),
) -> LaidRoad:
    """The road of a drive.

    spec: one of `road_forms()`; seed: >= 0; speed: the drive's highest [m/s]; duration: [s];
    grade: rise over run along x [-]; bank: rise towards the left [-]; obstacles: texts of `obstacles.FORM`.
    Returns a road that is flat at x <= 0; `.raw` is the surface without fade-in, grade, bank and obstacles.
    Raises ValueError with one line that names the bad value and the valid ones.
    """
    if not 0 <= seed < 2**63:
        raise ValueError(f"road seed {seed} must be 0 or more")
    if not 0.0 <= speed <= _TOP_SPEED:
        raise ValueError(f"road for a speed of {speed} m/s: it must be 0 to {_TOP_SPEED:g} m/s")
    if not duration > 0.0:
        raise ValueError(f"road for a duration of {duration} s: it must be above 0 s")
    for what, value in (("grade", grade), ("bank", bank)):
        if not abs(value) <= _STEEPEST:
            raise ValueError(f"{what} {value} must be {-_STEEPEST} to {_STEEPEST} (rise over run)")
    laid = tuple(parse_obstacle(text) for text in obstacles)
    kind = next((kind for kind in road_kinds() if kind.recognises(spec)), None)
    if kind is None:
        raise ValueError(f"road '{spec}' is unknown; valid: {road_forms()}")
    return LaidRoad(kind.build(spec, seed, unrepeated_length(speed, duration)), grade, bank, laid)
