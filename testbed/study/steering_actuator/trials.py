"""The thesis' errors, and constants of many sizes, added to the motor's angle of a drive: who alarms, and when.

Methods: those of the thesis, as tuned by its rule; and `servo_model`, the watch of the identified servo's innovation.
Times are to the end of the cell; the estimator itself waits LATENCY more for late samples.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.steering_actuator.calibration import Calibration
from estimators.steering_actuator.errors import THESIS, Error
from estimators.steering_actuator.published import METHODS, Method, Verdict, statistics, verdict
from estimators.steering_actuator.residuals import STEP, residuals
from estimators.steering_actuator.servo_model import CAUSES, simulated
from estimators.steering_actuator.watch import VARIANCE
from estimators.steering_actuator.watching import Watching
from testbed.study.steering_actuator.heard import Heard

SERVO_MODEL = "servo_model"
KINDS = ("late", "on_b", "rated", "tuned")
"""Thresholds after set B, for an error from LATE on and for one that is there from the beginning; the same at the
designed rate of false alarms; thresholds after the thesis' sets. The servo's watch knows but its designed rate."""
LATE = 5.0  # s
NAMES = (*(method.name for method in METHODS), SERVO_MODEL)
SIZES = (
    0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0, 70.0, 100.0, 150.0, 200.0, 300.0, 400.0, 500.0,
    700.0, 1000.0, 1500.0, 2000.0, 3000.0, 5000.0, 7000.0,
)  # deg  # fmt: skip


Array = NDArray[np.float64]
Tuned = dict[str, dict[str, Any]]


def table(drive: Heard, known: Calibration, tuned: Tuned, seed: int) -> dict[str, dict[str, list[Any]]]:
    """Error -> method -> [seconds to the alarm or null, by what, star]."""
    model = simulated(known.servo, drive.demand)
    found: dict[str, dict[str, list[Any]]] = {}
    for error in THESIS:
        added = error.of(len(drive.demand), seed)
        eps = residuals(drive.error_deg + added)
        rows = {m.name: verdict(statistics(m, tuned[m.name]["numbers"], eps)) for m in METHODS}
        rows[SERVO_MODEL] = by_model(drive.angle + np.radians(added), model, known)
        found[error.name] = {name: [v.time, v.by[:1], v.star] for name, v in rows.items()}
    return found


def by_model(angle: Array, model: Array, known: Calibration) -> Verdict:
    """The first alarm of the servo's watch; model: as `simulated` says, (n, SAID)."""
    said = Watching(known.servo_watch).take(0, angle - model[:, 0], model[:, CAUSES])
    if not said.alarms:
        return Verdict(None, "", False)
    first = said.alarms[0]
    return Verdict((first.cell + 1) * STEP, "variance" if first.kind == VARIANCE else "mean", False)


def sizes_found(drive: Heard, known: Calibration, tuned: Tuned) -> dict[str, dict[str, list[float]]]:
    """Method -> KINDS -> constants of SIZES [deg] that are found within the drive."""
    model = simulated(known.servo, drive.demand)
    found: dict[str, dict[str, list[float]]] = {name: {kind: [] for kind in KINDS} for name in NAMES}
    for size in SIZES:
        for late, start in ((False, 0.0), (True, LATE)):
            added = Error("constant", size, start).of(len(drive.demand))
            eps = residuals(drive.error_deg + added)
            for method in METHODS:
                for kind in ("late",) if late else KINDS[1:]:
                    _note(found[method.name][kind], size, _by(method, tuned, kind, eps).time, start)
            told = by_model(drive.angle + np.radians(added), model, known).time
            for kind in ("late",) if late else KINDS[1:]:
                _note(found[SERVO_MODEL][kind], size, told, start)
    return found


def _by(method: Method, tuned: Tuned, kind: str, eps: Array) -> Verdict:
    own = tuned[method.name]
    if kind == "tuned":
        return verdict(statistics(method, own["numbers"], eps))
    return verdict(statistics(method, own["on_b"], eps), own["level"] if kind == "rated" else 1.0)


def _note(sizes: list[float], size: float, told: float | None, start: float) -> None:
    """What is told before it is there is no finding."""
    if told is not None and told > start:
        sizes.append(size)


def sound(drive: Heard, known: Calibration, tuned: Tuned) -> dict[str, dict[str, bool]]:
    """Method -> KINDS but the first -> whether it alarms though nothing is wrong."""
    eps = residuals(drive.error_deg)
    found = {}
    for method in METHODS:
        found[method.name] = {kind: _by(method, tuned, kind, eps).time is not None for kind in KINDS[1:]}
    own_word = by_model(drive.angle, simulated(known.servo, drive.demand), known).time is not None
    return found | {SERVO_MODEL: dict.fromkeys(KINDS[1:], own_word)}
