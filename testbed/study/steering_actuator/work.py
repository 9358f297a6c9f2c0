"""A repetition: scenarios driven once; what each monitor says of them and of errors added to them.

Row: found, as JSON text: cases, of each: name, set_a, ended (why, or ""), hours, sound (`trials.sound`), alarms of the
estimator (time s, text), evidence (the largest of the servo's watch, over its threshold); of set A
also table (`trials.table`) and sizes (`trials.sizes_found`). gaussian: `gaussian.measured` of set A. Of repetition 0
`example`, series for the figures."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.steering_actuator.calibration import Calibration
from estimators.steering_actuator.residuals import STEP
from estimators.steering_actuator.servo_model import CAUSES, simulated
from estimators.steering_actuator.steering_actuator import SteeringActuator
from estimators.steering_actuator.watching import Watching
from models.identified import identified, identified_monitors
from testbed.simulation import Diverged
from testbed.study.steering_actuator import gaussian
from testbed.study.steering_actuator.heard import Heard, heard
from testbed.study.steering_actuator.scenarios import CASES, SET_A, Case
from testbed.study.steering_actuator.trials import sizes_found, sound, table

EXAMPLES = (SET_A[6].name, "country-80")


def run(task: Mapping[str, Any]) -> dict[str, Any]:
    """See the module."""
    document = identified()["steering_actuator"]
    known, tuned = Calibration.from_json(document), identified_monitors()
    cases, position, example = [], list[NDArray[np.float64]](), {}
    for place in task["places"]:
        case = CASES[place]
        listener = SteeringActuator(Car())
        listener.use_calibration(document)
        try:
            drive = heard(case.scenario(task["seed"], task["number"]), listener)
        except (ValueError, Diverged) as error:
            cases.append({"name": case.name, "set_a": case in SET_A, "ended": str(error)})
            continue
        if case in SET_A:
            position.append(drive.error_deg)
        if case.name in EXAMPLES and task["number"] == 0:
            example[case.name] = _series(drive, known)
        cases.append(judged(case, drive, known, tuned, task["number"]))
    pooled = gaussian.measured(np.concatenate(position)) if position else None
    return {"found": json.dumps({"cases": cases, "gaussian": pooled, "example": example})}


def judged(case: Case, drive: Heard, known: Calibration, tuned: dict[str, Any], number: int) -> dict[str, Any]:
    """One drive."""
    model = simulated(known.servo, drive.demand)
    said = Watching(known.servo_watch).take(0, drive.angle - model[:, 0], model[:, CAUSES])
    found = {
        "name": case.name, "set_a": case in SET_A, "ended": "", "hours": len(drive.demand) * STEP / 3600.0,
        "sound": sound(drive, known, tuned), "alarms": [[alarm.time, alarm.text] for alarm in drive.alarms],
        "evidence": float(said.evidence.max()),
    }  # fmt: skip
    if case in SET_A:
        seed = number * len(CASES) + CASES.index(case)
        found |= {"table": table(drive, known, tuned, seed), "sizes": sizes_found(drive, known, tuned)}
    return found


def _series(drive: Heard, known: Calibration) -> dict[str, Any]:
    model = simulated(known.servo, drive.demand)
    return {
        "demand": np.degrees(drive.demand).round(2).tolist(), "angle": np.degrees(drive.angle).round(2).tolist(),
        "error": np.degrees(drive.angle - model[:, 0]).round(3).tolist(),
        "spread": np.degrees(known.servo_watch.spread.at(model[:, CAUSES])).round(3).tolist(),
    }  # fmt: skip
