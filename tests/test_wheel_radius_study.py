"""The figures of the study `wheel-radius`, from made-up drives of which they are known."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.course import PAIRS
from testbed.study.wheel_radius.drives import LOW, OFF, TEST_RUNS, task
from testbed.study.wheel_radius.sound_drives import SoundCar, driven_cells, told
from testbed.study.wheel_radius.wheel_radius import NEAR, PAPER_TIME, WheelRadiusStudy
from testbed.study.wheel_radius.wheel_radius_alarm import WheelRadiusAlarmStudy

DURATION, ONSET = 440.0, 220.0
TIME = np.arange(2.0, DURATION + 1.0, 2.0)
STEP, LAG, NOISE = 2.5e-3, 40.0, 1e-4


def _truth(test_run, name):
    wheel, from_start = TEST_RUNS[test_run]
    sign = {("fl", "delta12"): -1.0, ("fl", "delta13"): 1.0, ("rl", "delta34"): -1.0, ("rl", "delta13"): -1.0}
    onset = 0.0 if from_start else ONSET
    return STEP * sign.get((wheel, name), 0.0) * (onset < TIME), onset


def _row(seed):
    """Estimates that follow the truth with a lag of LAG seconds and report their noise rightly; alarms 50 s after a
    loss, for the wheel it is in."""
    rng = np.random.default_rng(seed)
    row = {"duration_s": DURATION, "onset_s": ONSET}
    for test_run, (wheel, _) in TEST_RUNS.items():
        for name in PAIRS:
            truth, onset = _truth(test_run, name)
            value = np.where(onset + LAG < TIME, truth, 0.0) + rng.normal(0.0, NOISE, len(TIME))
            row |= {f"{test_run}/{name}/{key}": x.tolist() for key, x in
                    (("value", value), ("truth", truth), ("std", np.full(len(TIME), NOISE)))}  # fmt: skip
        row[f"{test_run}/time_s"] = TIME.tolist()
        row[f"{test_run}/alarms"] = [onset + 50.0] if wheel else []
        row[f"{test_run}/wheels"] = [wheel] if wheel else []
    return row


@pytest.fixture
def rows():
    return [_row(seed) for seed in range(8)]


def _figures(rows):
    return {row.name: row for row in WheelRadiusStudy().table(rows)}


def test_final_levels_are_the_truth(rows):
    found = _figures(rows)
    for test_run in TEST_RUNS:
        for name in PAIRS:
            row = found[f"final {name}, {test_run}"]
            assert row.limit == pytest.approx(1e3 * _truth(test_run, name)[0][-1])
            assert row.ci95[0] - 0.05 < row.limit < row.ci95[1] + 0.05


def test_an_estimator_that_reports_its_noise_has_nees_one_and_that_error(rows):
    found = _figures(rows)
    for name in PAIRS:
        assert found[f"mean NEES of {name}"].here == pytest.approx(1.0, abs=0.1)
        assert found[f"r.m.s. error of {name}"].here == pytest.approx(1e3 * NOISE, rel=0.05)
        assert found[f"r.m.s. error of {name}"].limit == pytest.approx(1e3 * NOISE)


@pytest.mark.parametrize("test_run", [name for name, (wheel, _) in TEST_RUNS.items() if wheel])
def test_settling_and_alarm_times_are_found(rows, test_run):
    found = _figures(rows)
    reached = found[f"median time to reach, delta13, {test_run}"]
    assert reached.here == pytest.approx(LAG + 2.0, abs=2.0)
    assert reached.paper == PAPER_TIME
    assert found[f"median time to settle, delta13, {test_run}"].here == reached.here
    assert found[f"median time to an alarm, {test_run}"].here == pytest.approx(50.0)
    assert found[f"share with an alarm within 60 s, {test_run}"].here == 1.0
    assert found[f"share of alarms that name the wheel, {test_run}"].here == 1.0


def test_an_estimate_that_strays_has_reached_its_level_but_not_settled(rows):
    for row in rows:
        row["rear left low after 220 s/delta34/value"][-20] += 2.0 * NEAR
    found = _figures(rows)
    assert found["median time to reach, delta34, rear left low after 220 s"].here == pytest.approx(LAG + 2.0, abs=2.0)
    settled = found["median time to settle, delta34, rear left low after 220 s"]
    assert settled.here == pytest.approx(DURATION - ONSET - 38.0, abs=2.0)


def test_an_alarm_before_the_loss_is_false_and_one_for_another_wheel_is_no_isolation(rows):
    rows[0]["front left low after 220 s/alarms"] = [ONSET - 1.0, 270.0]
    rows[0]["front left low after 220 s/wheels"] = ["fl", "rr"]
    found = _figures(rows)
    assert found["share of alarms that name the wheel, front left low after 220 s"].here == pytest.approx(7.0 / 8.0)
    hours = 8 * (DURATION + 2 * ONSET) / 3600.0
    rate = found[f"false alarms (1 in {hours:.1f} h)"]
    assert rate.here == pytest.approx(1.0 / hours)


def test_no_false_alarm_still_has_an_upper_limit(rows):
    (rate,) = (row for row in _figures(rows).values() if row.name.startswith("false alarms (0"))
    assert rate.here == 0.0
    assert rate.ci95[1] == pytest.approx(3.689 / (8 * (DURATION + 2 * ONSET) / 3600.0), rel=1e-3)


def test_test_runs_are_the_papers_five():
    drives = task(0, 0)["drives"]
    assert len(drives) == 5
    assert all(drive["duration"] == DURATION and drive["radius_factor"] == OFF for drive in drives.values())
    assert drives["front left low"]["pressures"] == {"fl": LOW}
    late = drives["rear left low after 220 s"]["pressure_sets"]["rl"]
    assert (late["pressure"], late["start"]) == (LOW, ONSET)
    assert len({drive["seed"] for drive in drives.values()}) == 1


def test_a_sound_drive_is_kept_as_the_estimators_cells_and_is_the_same_again():
    car = SoundCar(1, 0)
    scenario = car.day(0, duration=3.0)
    cells = driven_cells(scenario)
    assert len(cells.index) == 30
    assert np.isfinite(cells.value[10:-1]).all()
    assert SoundCar(1, 0).day(0, duration=3.0) == scenario != SoundCar(1, 1).day(0, duration=3.0)
    assert 0.9 < told(scenario, car).rear_track / 1.6364 < 1.1


def _sound(alarms, loaded=False, manoeuvre="town", friction="1.0", nearness=(0.5, 0.9)):
    drive = {"loaded": loaded, "manoeuvre": manoeuvre, "friction": friction, "payload_kg": 0.0}
    return {**drive, "seconds": 600, "alarms": alarms, "nearness": [*nearness]}


def test_alarms_on_sound_cars_are_counted_by_kind_and_the_loaded_drives_apart():
    rows = [
        {"calibrated": True, "drives": [_sound([100.0, 130.0, 400.0], manoeuvre="country"), _sound([])]},
        {"calibrated": True, "drives": [_sound([], friction="0.2"), _sound([7.0], loaded=True)]},
    ] * 3  # fmt: skip
    found = {row.name: row for row in WheelRadiusAlarmStudy().table(rows)}
    assert found["false_alarms_other_drives"].here == found["false_alarms_country"].here == 6
    assert found["hours_other_drives"].here == pytest.approx(1.5)
    assert found["false_alarms_per_hour_other_drives"].here == pytest.approx(4.0)
    assert found["false_alarms_friction_0.2"].here == 0
    assert found["false_alarms_600_kg"].here == 3
    assert found["greatest_nearness_600_kg"].here == 0.9


def test_the_tail_of_many_sound_drives_gives_the_rate_they_have():
    """Minutes whose maxima are 0.1 plus exponential of scale 0.1: the rate of an alarm in closed form."""
    rng = np.random.default_rng(0)
    rows = [{"calibrated": True, "drives": [_sound([], nearness=0.1 + rng.exponential(0.1, 10))]} for _ in range(200)]
    found = {row.name: row for row in WheelRadiusAlarmStudy().table(rows)}
    low, high = found["false_alarms_per_100_h_by_tail"].ci95
    assert low < 6000.0 * np.exp(-0.9 / 0.1) < high
