"""A campaign file (TOML) and the drives that it means.

    question = "..."                 the report's title
    seed = 1                         of the campaign: everything drawn, and each drive's own seed
    runs = 10                        drives for each point of the grid (one point without a sweep); a larger number
                                     keeps the drives that are there and adds to them
    estimators = ["wheel_radius"]    all when absent
    low_percent = 15                 loss of nominal pressure from which on a tyre is low and an alarm is due
    [scenario]                       `testbed.campaign.fields`; a value may be one of `testbed.campaign.distributions`
    [calibration]                    fields of a drive before, on which the estimators learn this car; without it they
                                     start uncalibrated. Pressures there are nominal and nothing leaks.
    [vehicle] [tyre]                 factors on numbers of models/suv.toml (`front.spring_rate = 1.05`) and of the tyre
    [believed]                       what the estimators take for true and is not: `tyre = "..."`, factors on fields of
                                     estimators.car.Car (`chassis_mass = 0.9`)

[vehicle] and [tyre] change what drives and not what the estimators are told, so they are a mismatch as well.
"""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from estimators.registry import select
from testbed.campaign.distributions import SWEEP, check, draw, filled, is_distribution, leaves
from testbed.campaign.fields import scenario_from
from testbed.campaign.variants import variant_of
from testbed.manoeuvres.manoeuvre import find_manoeuvre
from testbed.roads import make_road
from testbed.roads.friction import parse_friction
from testbed.scenario import Scenario
from testbed.sensors import sensor_settings

TABLES = ("scenario", "calibration", "vehicle", "tyre", "believed")
KEYS = ("question", "seed", "runs", "estimators", "low_percent", *TABLES)
MOST_DRIVES = 1_000_000
MOST_ROADS = 100  # that are tried before the first drive


@dataclass(frozen=True)
class Campaign:
    """question: text; low: loss of pressure that counts, share of nominal [-]; fixed, swept, drawn: by name, the values
    that all drives have, those that they take in turn, and the distributions; tasks: JSON values that
    `testbed.campaign.drive_row` turns into rows, in order."""

    question: str
    low: float
    estimators: tuple[str, ...]
    fixed: Mapping[str, Any]
    swept: Mapping[str, list[Any]]
    drawn: Mapping[str, Mapping[str, Any]]
    tasks: tuple[dict[str, Any], ...]

    @property
    def driven_seconds(self) -> float:
        """Simulated time of all drives, calibrations included [s]."""
        drives = [t[part] for t in self.tasks for part in ("scenario", "calibration") if t[part]]
        return float(sum(drive["duration"] for drive in drives))


def read_campaign(path: Path) -> Campaign:
    """The campaign of a file. ValueError in one line names the file, what is wrong in it and what would be valid."""
    try:
        content = tomllib.loads(path.read_text())
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: not TOML ({error})") from None
    try:
        return campaign(content)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from None


def _whole(content: Mapping[str, Any], key: str, default: int, lowest: int) -> int:
    value = content.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int) or value < lowest:
        raise ValueError(f"{key} is {value!r}, want a whole number of {lowest} or more")
    return value


def _estimators(names: Any) -> tuple[str, ...]:
    if names is not None and not (isinstance(names, list) and all(isinstance(n, str) for n in names)):
        raise ValueError(f"estimators is {names!r}, want a list of names")
    return tuple(select(names))


def _share(content: Mapping[str, Any], key: str, default: float) -> float:
    value = content.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < 100.0:
        raise ValueError(f"{key} is {value!r}, want a number between 0 and 100")
    return 0.01 * value


def campaign(content: Mapping[str, Any]) -> Campaign:
    """The campaign of a file's content. ValueError in one line."""
    odd = sorted(set(content) - set(KEYS))
    if odd:
        raise ValueError(f"unknown field {odd[0]!r}; valid: {', '.join(KEYS)}")
    tables = {name: content.get(name, {}) for name in TABLES}
    for name, table in tables.items():
        if not isinstance(table, Mapping):
            raise ValueError(f"[{name}] is {table!r}, want a table")
    seed, runs = _whole(content, "seed", 0, 0), _whole(content, "runs", 1, 1)
    given = dict(leaves(tables))
    varied = {name: value for name, value in given.items() if is_distribution(value)}
    for name, value in varied.items():
        check(name, value)
    swept = {name: value[SWEEP] for name, value in varied.items() if SWEEP in value}
    drawn = {name: value for name, value in varied.items() if name not in swept}
    count = runs * math.prod(len(values) for values in swept.values())
    if count > MOST_DRIVES:
        raise ValueError(f"{count} drives, want at most {MOST_DRIVES}")
    names = _estimators(content.get("estimators"))
    tasks: list[dict[str, Any]] = []
    for number, (_, *point) in enumerate(itertools.product(range(runs), *swept.values())):
        values = dict(zip(swept, point, strict=True))
        values |= {name: draw(seed, number, name, value) for name, value in drawn.items()}
        tasks.append(_task(seed, number, filled(tables, values), values, names))
    _check_roads(tasks)
    return Campaign(
        question=str(content.get("question", "How well do the estimators do?")),
        low=_share(content, "low_percent", 15.0),
        estimators=names,
        fixed={_shown(name): value for name, value in given.items() if name not in varied},
        swept={_shown(name): value for name, value in swept.items()},
        drawn={_shown(name): value for name, value in drawn.items()},
        tasks=tuple(tasks),
    )


def _shown(name: str) -> str:
    return name.removeprefix("scenario.")


def _cell(value: Any) -> Any:
    """A value as a table can hold it."""
    return value if isinstance(value, int | float | str) else json.dumps(value)


def _task(
    seed: int, number: int, tables: Mapping[str, Mapping[str, Any]], values: Mapping[str, Any], names: Sequence[str]
) -> dict[str, Any]:
    """One drive as JSON values; all but its roads is checked here, before any drive begins."""
    scenario = scenario_from(tables["scenario"], seed=_drive_seed(seed, number))
    before = calibration_drive(scenario, tables["calibration"], _drive_seed(seed, number, 1))
    for drive in (scenario, before):
        if drive:
            find_manoeuvre(drive.manoeuvre).plan(drive.speed, drive.duration)
            parse_friction(drive.friction)
            sensor_settings(drive.sensors, drive.active_steering)
    variant_of(scenario, tables["vehicle"], tables["tyre"], tables["believed"])
    named = {d.road for d in (scenario, before) if d} | {scenario.tyre, str(tables["believed"].get("tyre"))}
    return {
        "number": number,
        "variables": {_shown(name): _cell(value) for name, value in values.items()},
        "scenario": scenario.as_notes(),
        "calibration": before.as_notes() if before else None,
        **{name: dict(tables[name]) for name in ("vehicle", "tyre", "believed")},
        "estimators": list(names),
        "files": {name: _digest(name) for name in sorted(named) if Path(name).is_file()},
    }


@cache
def _digest(path: str) -> str:
    """Of a file that decides the drive: an edited road is another road."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16]


def _drive_seed(seed: int, number: int, place: int = 0) -> int:
    """Drives that follow one another, and campaigns whose seeds do, have nothing in common."""
    return int(np.random.SeedSequence((seed, number, place)).generate_state(1)[0])


def calibration_drive(scenario: Scenario, table: Mapping[str, Any], seed: int) -> Scenario | None:
    """The drive on which the estimators learn the scenario's car before it: the same car at nominal pressures, with
    what the table says otherwise. None without a table."""
    if not table:
        return None
    parts = scenario.seed if scenario.car_seed is None else scenario.car_seed
    same = {
        "pressures": {},
        "leaks": {},
        "pressure_sets": {},
        "obstacles": (),
        "brake_pulls": {},
        "faults": (),
        "faults_in_loop": False,
        "steering_lock": None,
        "seed": seed,
        "car_seed": parts,
    }
    return scenario_from(table, **(dataclasses.asdict(scenario) | same))


def _check_roads(tasks: Sequence[Mapping[str, Any]]) -> None:
    """ValueError for a road that cannot be had; each different one once, and of very many (drawn levels) the first."""
    drives = [task[part] for task in tasks for part in ("scenario", "calibration") if task[part]]
    roads = dict.fromkeys((drive["road"], tuple(drive["obstacles"])) for drive in drives)
    for road, obstacles in itertools.islice(roads, MOST_ROADS):
        make_road(road, 0, 1.0, 1.0, obstacles=obstacles)
