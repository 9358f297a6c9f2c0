"""python -m testbed.identify steering-servo: what `steering_actuator` starts from.

Servo model and ratios from the first repetition's drives that are not calm, watches with their thresholds from all
tuning drives (`testbed.study.steering_actuator.tuning_drives`): half an hour of driving, five minutes.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from estimators.steering_actuator.identify import identified
from estimators.steering_actuator.learn import Drive, learnt
from estimators.steering_actuator.steering_actuator import FALSE_ALARMS_PER_HOUR
from testbed.study.steering_actuator.heard import Heard
from testbed.study.steering_actuator.scenarios import CALM, Case
from testbed.study.steering_actuator.tuning_drives import tuning_drives


def document(drives: Iterable[tuple[int, Case, Heard]] | None = None) -> dict[str, Any]:
    """The calibration of `steering_actuator`, JSON values."""
    few, many = list[Drive](), list[Drive]()
    for number, case, drive in tuning_drives() if drives is None else drives:
        many.append(drive[:4])
        if number == 0 and case.group != CALM:
            few.append(many[-1])
    servo = identified([demand for demand, *_ in few], [angle for _, angle, *_ in few])
    return learnt(servo, few, many, FALSE_ALARMS_PER_HOUR).as_json()
