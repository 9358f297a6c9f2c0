"""A repetition: all scenarios driven once; what monitor and thesis' methods say of them, and of errors added to them.

Row: found, as JSON text: cases, of each: name, group, hours judged; alarms [time s, wheel, true deviation m/s] of the
monitor; false: of each method; real: outliers that were there, [wheel, duration s, delay s or null] by method; peaks:
largest evidence of each SECOND without an outlier; speed_error: its 95 % and largest [m/s]; residuals: means [km/h] by
geometry; trials. constant: detection times of errors added to a straight drive, Tables 6.2 to 6.4. Of repetition 0
`example`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.drive_log import WHEELS
from estimators.grid import LATENCY
from estimators.wheel_plausibility.geometry import GEOMETRIES, factors
from estimators.wheel_plausibility.kernel import ACCUSED, EVIDENCE, SAID, SPEED, STEP, constants, follow, new_state
from estimators.wheel_plausibility.published import METHODS, published
from estimators.wheel_plausibility.residuals import averages, wheel_to_wheel
from estimators.wheel_plausibility.thresholds import LIMITS
from testbed.scenario import Scenario
from testbed.simulation import Diverged
from testbed.study.wheel_plausibility.heard import Heard, heard
from testbed.study.wheel_plausibility.trials import constant_errors, trials
from testbed.study.wheel_plausibility.truth import KMH, OUTLIER, SECOND, Truth, outliers, truth

EXAMPLES = ("stops_50_0.9/0.15", "brake_80_0.9/0.15", "circle_18_0.9", "evasion_80_0.9")
MOVING = 1.0  # m/s


def run(task: Mapping[str, Any]) -> dict[str, Any]:
    """See the module."""
    cases, random = [], np.random.default_rng(task["seed"])
    example = {}
    for asked in task["cases"]:
        scenario = Scenario.from_notes(asked["scenario"])
        car = Car(driven_axle=scenario.driven)
        try:
            drive = heard(scenario)
        except (ValueError, Diverged) as error:  # a car that rolls over
            cases.append({"name": asked["name"], "group": asked["group"], "ended": str(error)})
            continue
        found = judged(drive, car, random)
        cases.append({"name": asked["name"], "group": asked["group"], "ended": "", **found})
        if task["number"] == 0 and asked["name"] in EXAMPLES:
            example[asked["name"]] = _series(drive, car)
    straight = heard(Scenario.from_notes(task["straight"]))
    return {"found": json.dumps({"cases": cases, "constant": constant_errors(straight, Car()), "example": example})}


def said_of(drive: Heard, car: Car) -> NDArray[np.float64]:
    """Columns of `kernel.follow`, shape (n, SAID)."""
    said = np.empty((len(drive.index), SAID))
    follow(constants(car), new_state(), LIMITS, drive.index, np.ascontiguousarray(drive.value), said)
    return said


def judged(drive: Heard, car: Car, random: np.random.Generator) -> dict[str, Any]:
    """What is said of a case, JSON values, see the module."""
    of, said = truth(drive, car), said_of(drive, car)
    accused = {"monitor": said[:, ACCUSED] > 0.5}
    kmh = drive.value[:, :4] * car.rolling_radius / KMH
    for method in METHODS:
        accused[method] = published(method, kmh, STEP).accused
    moving = (np.arange(len(said)) < of.end) & (drive.forward > MOVING) & np.isfinite(said[:, SPEED])
    error = np.abs(said[moving, SPEED] - drive.forward[moving])
    steer = np.nan_to_num(drive.value[:, 6]) / car.steering_ratio
    return {
        "hours": of.end * STEP / 3600.0,
        "alarms": _alarms(drive, of, accused["monitor"]),
        "false": {method: _false(of, flags) for method, flags in accused.items()},
        "real": {method: _real(drive, of, flags, method) for method, flags in accused.items()},
        "peaks": _peaks(of, said),
        "speed_error": [float(np.quantile(error, 0.95)), float(error.max())] if len(error) else None,
        "residuals": {g: _residuals(kmh[: of.end], steer[: of.end], g, car) for g in GEOMETRIES},
        "trials": trials(drive, of, car, random),
    }


def _raised(of: Truth, accused: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """(cell, wheel) at which an accusation begins, while the case can be judged."""
    before = np.vstack([np.zeros((1, 4), bool), accused[:-1]])
    return [(int(k), int(i)) for k, i in np.argwhere((accused & ~before)[: of.end])]


def _alarms(drive: Heard, of: Truth, accused: NDArray[np.bool_]) -> list[list[Any]]:
    return [[float(drive.end[k]), WHEELS[i], float(of.worst[k, i])] for k, i in _raised(of, accused)]


def _false(of: Truth, accused: NDArray[np.bool_]) -> int:
    return sum(bool(of.worst[k, i] < OUTLIER) for k, i in _raised(of, accused))


def _real(drive: Heard, of: Truth, accused: NDArray[np.bool_], method: str) -> list[list[Any]]:
    waits = LATENCY if method == "monitor" else 0.0  # the thesis' work without one
    found = []
    for wheel, first, last in outliers(of):
        told = np.flatnonzero(accused[first : last + SECOND // 2, wheel])
        delay = float(drive.end[first + told[0]] - drive.end[first]) + STEP + waits if len(told) else None
        found.append([WHEELS[wheel], (last - first) * STEP, delay])
    return found


def _peaks(of: Truth, said: NDArray[np.float64]) -> list[float]:
    """Largest evidence of each whole SECOND in which no wheel was an outlier, nor in the two before, in which what an
    outlier left runs down."""
    found = []
    for start in range(SECOND, of.end - SECOND + 1, SECOND):
        span = slice(start, start + SECOND)
        if of.worst[start - SECOND : start + SECOND].max() < OUTLIER and np.isfinite(said[span, EVIDENCE]).all():
            found.append(float(said[span, EVIDENCE].max()))
    return found


def _residuals(kmh: NDArray[np.float64], steer: NDArray[np.float64], geometry: str, car: Car) -> list[float]:
    """Means of the six and the seven residuals [km/h], (13,)."""
    over = factors(geometry, steer, car.wheelbase, 0.5 * (car.front_track + car.rear_track))
    v = kmh / over
    v = v[np.isfinite(v).all(axis=1)]
    means = np.concatenate([wheel_to_wheel(v).mean(axis=0), averages(v).mean(axis=0)])
    return [round(float(mean), 5) for mean in means]


def _series(drive: Heard, car: Car) -> dict[str, Any]:
    """Ten rows a second for the figure."""
    said, kept = said_of(drive, car), slice(None, None, round(0.1 / STEP))
    return {
        "time": drive.end[kept].round(2).tolist(),
        "wheels": (drive.value[kept, :4] * car.rolling_radius / KMH).round(2).tolist(),
        "speed": (said[kept, SPEED] / KMH).round(2).tolist(),
        "truth": (drive.forward[kept] / KMH).round(2).tolist(),
        "accused": (said[kept, ACCUSED] > 0.5).tolist(),
    }
