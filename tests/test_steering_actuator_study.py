"""The study of the steering actuator: the thesis' tables as read, trials, its table from rows."""

from __future__ import annotations

import json

import numpy as np
import pytest

from estimators.steering_actuator.calibration import Calibration
from estimators.steering_actuator.errors import THESIS
from estimators.steering_actuator.published import METHODS
from models.identified import identified, identified_monitors
from testbed.study.steering_actuator.gaussian import measured
from testbed.study.steering_actuator.heard import Heard
from testbed.study.steering_actuator.paper import SCENARIOS, Printed, smallest_constant, tables
from testbed.study.steering_actuator.scenarios import SET_A
from testbed.study.steering_actuator.steering_actuator import SteeringActuatorStudy, smallest
from testbed.study.steering_actuator.trials import KINDS, LATE, NAMES, SERVO_MODEL, sizes_found, table
from testbed.study.steering_actuator.work import judged
from tests.steering_servo import cells, log


def test_the_thesis_tables_are_whole() -> None:
    assert list(tables()) == [error.name for error in THESIS]
    known = {method.name for method in METHODS}
    for rows in tables().values():
        assert set(rows) <= known
        assert all(len(entries) == SCENARIOS == len(SET_A) for entries in rows.values())
    assert Printed.of("x*") == Printed(None, "", True)
    assert Printed.of("5.5v") == Printed(5.5, "velocity", False)
    assert tables()["slope_500"]["ADYN"][1] == Printed(7.4, "", True)


def test_the_thesis_smallest_constants_follow_from_its_tables() -> None:
    """50 by LCUSUM, 100 by double LGCUSUM (50 in seven of ten), 1500 by the production monitor."""
    sizes = {name: smallest_constant(name) for name in NAMES}
    assert (sizes["LCUSUM"], sizes["double_LGCUSUM"], sizes["ADYN"], sizes["GMA"]) == (50.0, 100.0, 1500.0, None)


@pytest.fixture(scope="module")
def drive() -> Heard:
    return Heard(*cells(log(10.0, 3)))


def test_trials_find_what_is_there_when_it_is_there(drive: Heard) -> None:
    known, tuned = Calibration.from_json(identified()["steering_actuator"]), identified_monitors()
    fits = known.__class__(known.servo, known.servo_watch)
    found = table(drive, fits, tuned, 0)
    assert set(found) == {error.name for error in THESIS}
    assert found["constant_1500"]["double_LGCUSUM"][0] < 1.0
    assert found["constant_1500"]["CUSUM"][0] > 1.0  # environment 1
    late = found["slope_500"]["CUSUM"][0]
    assert 5.0 < late < 10.0
    sizes = sizes_found(drive, fits, tuned)
    assert 3000.0 in sizes["AC"]["tuned"]
    assert set(sizes["AC"]) == set(KINDS)
    assert LATE == 5.0


def test_measures_of_a_gaussian_are_a_gaussian_s() -> None:
    found = measured(15.0 * np.random.default_rng(2).standard_normal(20000))
    own = found["4.15"]
    assert own["sigma"] == pytest.approx(15.0, rel=0.02)
    assert own["distance"] < 0.01
    assert abs(own["kurtosis"]) < 0.1
    assert own["h"] == pytest.approx(84.2, rel=0.05)  # the thesis: "sigma = 15 gives h = 84.2"
    assert own["alarms"] == 0
    assert sum(found["histogram"]) == 20000


def test_the_table_counts_what_the_rows_say(drive: Heard) -> None:
    known, tuned = Calibration.from_json(identified()["steering_actuator"]), identified_monitors()
    case = judged(SET_A[0], drive, known, tuned, 0)
    cases = [{**case, "name": one.name} for one in SET_A]
    for kind in KINDS:
        for one in cases:
            one["sizes"][SERVO_MODEL][kind] = [10.0, 20.0]
    row = {"found": json.dumps({"cases": cases, "gaussian": measured(drive.error_deg), "example": {}})}
    rows = {row.name: row for row in SteeringActuatorStudy().table([row])}
    assert smallest({"cases": cases}, SERVO_MODEL, "on_b") == 10.0
    assert rows["servo_model.smallest_constant_error_deg"].here == 10.0
    assert rows["servo_model.smallest_constant_error_deg"].limit == 20.0
    assert rows["hours"].here == pytest.approx(10 * len(drive.demand) / 360000.0)
    assert rows["double_LGCUSUM.smallest_constant_error_after_the_thesis_sets_deg"].paper == 100.0
    assert rows["slope_500.CUSUM.found"].here == 10.0
    assert rows["slope_500.CUSUM.found"].paper == 10.0
    assert set(SteeringActuatorStudy().figures([row])) == {
        "tables-4-2-2-constant", "tables-4-2-2-other", "figures-4-13-to-4-17", "smallest-constant",
    }  # fmt: skip


def test_a_repetition_does_not_depend_on_how_many_there_are() -> None:
    study = SteeringActuatorStudy()
    assert study.tasks(3, 5, False)[:2] == study.tasks(2, 5, False)
    assert len(study.tasks(1, 5, False)[0]["places"]) == 50
