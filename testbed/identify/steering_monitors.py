"""python -m testbed.identify steering-monitors: the thesis' monitors of the steering actuator, tuned as it says.

Of each method the numbers by its rule (`estimators.steering_actuator.tuning`), after set A, or B for the last but one,
of TUNED repetitions of the tuning drives; errors to find are those of the thesis, on set A. Beside them the project's
own way: `on_b`, numbers after set B for every method, and `level`, the factor on all their thresholds at which set B
has one false alarm in 100 h, from the tail of the method's statistic on all repetitions (`exponential_tail`).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.steering_actuator.errors import Error
from estimators.steering_actuator.exponential_tail import threshold_at
from estimators.steering_actuator.published import METHODS, Method, statistics
from estimators.steering_actuator.residuals import STEP, residuals
from estimators.steering_actuator.steering_actuator import FALSE_ALARMS_PER_HOUR
from estimators.steering_actuator.tuning import tuned
from testbed.study.steering_actuator.heard import Heard
from testbed.study.steering_actuator.scenarios import SET_A, Case
from testbed.study.steering_actuator.tuning_drives import tuning_drives

TUNED = 2  # repetitions
SOUGHT = (
    *(Error("constant", size) for size in (20.0, 30.0, 50.0, 100.0, 200.0, 500.0, 1000.0)),
    Error("noise", 50.0), Error("noise", 100.0), Error("sine", 40.0),
)  # fmt: skip

Array = NDArray[np.float64]


def document(drives: Iterable[tuple[int, Case, Heard]] | None = None) -> dict[str, Any]:
    """By method: `numbers` of each residual, `on_b` and `level`. JSON values."""
    heard = list(tuning_drives() if drives is None else drives)
    sound = {"A": [], "B": []}  # type: dict[str, list[Array]]
    faulty: list[Array] = []
    for place, (number, case, drive) in enumerate(heard):
        if number >= TUNED:
            continue
        error = drive.error_deg
        sound["B"].append(residuals(error))
        if case in SET_A:
            sound["A"].append(sound["B"][-1])
            faulty += [residuals(error + sought.of(len(error), place)) for sought in SOUGHT]
    everything = [residuals(drive.error_deg) for *_, drive in heard]
    found = {}
    for method in METHODS:
        numbers = tuned(method, sound[method.tuned_on], faulty)
        on_b = numbers if method.tuned_on == "B" else tuned(method, sound["B"], faulty)
        found[method.name] = {"numbers": numbers, "on_b": on_b, "level": level(method, on_b, everything)}
    return found


def level(method: Method, numbers: dict[str, Any], drives: list[Array]) -> float:
    """Factor on the thresholds at the designed rate."""
    largest = [float(statistics(method, numbers, eps).max()) for eps in drives]
    hours = sum(len(eps) for eps in drives) * STEP / 3600.0
    return threshold_at(largest, hours, FALSE_ALARMS_PER_HOUR)
