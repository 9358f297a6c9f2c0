"""The estimator in a car with active steering: sound, with a fault in the log, with the same fault inside the loop."""

from __future__ import annotations

import pytest

from testbed.scenario import Scenario
from testbed.session import Session

SOUND = Scenario(
    road="B", manoeuvre="slalom", speed=25.0 / 3.6, duration=7.0, seed=77, active_steering=True, faults=()
)  # fmt: skip


def alarms(**changes: object) -> list[str]:
    fields = {**SOUND.__dict__, **changes}
    with Session(Scenario(**fields), None, ["steering_actuator"]) as session:
        for _ in session.run():
            pass
        assert not session.bank.flags["steering_actuator"]
        return [alarm.text for alarm in session.bank.alarms["steering_actuator"]]


@pytest.mark.parametrize(
    ("changes", "accused"),
    [
        ({}, None),
        ({"faults": ("steering/motor_angle=bias:20@4",)}, "motor angle sensor errs"),
        ({"faults": ("steering/motor_angle=bias:60@4",), "faults_in_loop": True}, "angles of pinion"),
    ],
)
def test_who_is_accused(changes: dict[str, object], accused: str | None) -> None:
    found = alarms(**changes)
    if accused is None:
        assert found == []
        return
    assert found[-1].startswith(accused)
    since = float(found[-1].split("since ")[1].split()[0])
    assert since == pytest.approx(4.0, abs=0.05)


def test_a_car_without_active_steering_hears_nothing() -> None:
    assert alarms(active_steering=False) == []
