"""python -m testbed.identify steering-servo: what `steering_actuator` starts from.

Servo model and ratios from the first repetition of the tuning drives, watches with their thresholds from all of them
(`testbed.study.steering_actuator.tuning_drives`): an hour of driving, ten minutes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from estimators.steering_actuator.learn import learnt
from estimators.steering_actuator.steering_actuator import FALSE_ALARMS_PER_HOUR
from testbed.study.steering_actuator.heard import Heard
from testbed.study.steering_actuator.scenarios import Case
from testbed.study.steering_actuator.tuning_drives import tuning_drives


def document(drives: Iterable[tuple[int, Case, Heard]] | None = None) -> dict[str, Any]:
    """The calibration of `steering_actuator`, JSON values."""
    heard = [(number, drive[:4]) for number, _, drive in (tuning_drives() if drives is None else drives)]
    few = [drive for number, drive in heard if number == 0]
    return learnt(few, [drive for _, drive in heard], FALSE_ALARMS_PER_HOUR).as_json()
