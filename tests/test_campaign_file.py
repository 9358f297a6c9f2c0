"""A campaign file means the drives that it says, draws that stay as they are, and refuses what makes no sense."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from estimators.drive_log import WHEELS
from models.tyre_properties import load_tyre
from models.vehicle import load_vehicle
from testbed.campaign.distributions import draw
from testbed.campaign.fields import scenario_from
from testbed.campaign.plan import Campaign, campaign, read_campaign
from testbed.campaign.variants import believed_car, variant_of
from testbed.scenario import Scenario
from testbed.tyre.inflation import Leak, PressureSet

FILE = """
seed = 5
runs = 3
[scenario]
road = { sweep = ["A", "C"] }
speed_kmh = { sweep = [36, 72] }
duration_s = 20
pressure_kpa = { fl = { uniform = [180, 250] }, rr = 240 }
[calibration]
duration_s = 30
[vehicle]
front.spring_rate = { normal = [1.0, 0.05] }
[believed]
chassis_mass = 0.9
"""


def planned(text: str) -> Campaign:
    return campaign(tomllib.loads(text))


def test_grid_times_runs_is_the_number_of_drives() -> None:
    plan = planned(FILE)
    assert len(plan.tasks) == 2 * 2 * 3
    points = [(t["variables"]["road"], t["variables"]["speed_kmh"]) for t in plan.tasks]
    assert {p: points.count(p) for p in points} == {(r, s): 3 for r in "AC" for s in (36, 72)}
    assert [t["number"] for t in plan.tasks] == list(range(12))
    assert plan.driven_seconds == 12 * 50.0
    assert set(plan.swept) == {"road", "speed_kmh"}
    assert set(plan.drawn) == {"pressure_kpa.fl", "vehicle.front.spring_rate"}
    assert plan.fixed["duration_s"] == 20


def test_task_is_in_si_and_its_calibration_is_the_same_car_at_nominal_pressures() -> None:
    task = planned(FILE).tasks[-1]
    drive, before = Scenario.from_notes(task["scenario"]), Scenario.from_notes(task["calibration"])
    assert (drive.road, drive.speed, drive.duration) == ("C", 20.0, 20.0)
    assert drive.pressures["rr"] == 240e3
    assert 180e3 <= drive.pressures["fl"] <= 250e3
    assert (before.road, before.speed, before.duration, before.pressures) == ("C", 20.0, 30.0, {})
    assert before.seed != drive.seed


def test_more_runs_keep_the_drives_that_are_there() -> None:
    fewer, more = planned(FILE), planned(FILE.replace("runs = 3", "runs = 4"))
    assert more.tasks[: len(fewer.tasks)] == fewer.tasks


def test_another_drawn_field_leaves_the_draws_of_the_others() -> None:
    more = planned(FILE.replace("duration_s = 20", "duration_s = 20\nambient_c = { normal = [15, 8] }"))
    for one, other in zip(planned(FILE).tasks, more.tasks, strict=True):
        assert one["scenario"]["pressures"] == other["scenario"]["pressures"]
        assert one["scenario"]["seed"] == other["scenario"]["seed"]


def test_another_seed_draws_anew() -> None:
    other = planned(FILE.replace("seed = 5", "seed = 6"))
    assert all(
        a["scenario"]["seed"] != b["scenario"]["seed"] and a["scenario"]["pressures"] != b["scenario"]["pressures"]
        for a, b in zip(planned(FILE).tasks, other.tasks, strict=True)
    )


@pytest.mark.parametrize(
    ("distribution", "mean", "std"),
    [
        ({"uniform": [180, 250]}, 215.0, 70 / 12**0.5),
        ({"normal": [250, 5]}, 250.0, 5.0),
        ({"choice": [1, 3]}, 2.0, 1.0),
    ],
)
def test_draws_have_the_moments_of_their_distribution(distribution: Any, mean: float, std: float) -> None:
    values = np.array([draw(1, number, "field", distribution) for number in range(1000)])
    assert values.mean() == pytest.approx(mean, abs=4.0 * std / 1000**0.5)
    assert values.std() == pytest.approx(std, rel=0.1)


def test_draws_of_two_fields_have_nothing_in_common() -> None:
    one, other = ([draw(1, number, name, {"uniform": [0, 1]}) for number in range(1000)] for name in ("a", "b"))
    assert abs(np.corrcoef(one, other)[0, 1]) < 4.0 / 1000**0.5


def test_log_uniform_is_uniform_in_the_logarithm() -> None:
    values = np.log10([draw(1, n, "field", {"log_uniform": [1e-6, 1e-2]}) for n in range(1000)])
    assert values.mean() == pytest.approx(-4.0, abs=4.0 * 4.0 / 12**0.5 / 1000**0.5)


def test_every_field_reaches_the_scenario() -> None:
    drive = scenario_from(
        {
            "road_gd": 5e-5, "pressure_kpa": 230, "leak_kpa_s": {"rr": {"rate": 2, "start_s": 5}},
            "set_kpa": {"fl": {"to": 130, "start_s": 30}}, "radius_percent": {"rl": -0.3}, "payload_kg": 200,
            "payload_position_m": [0, 0, 0.1], "friction": "0.9", "grade_percent": 2, "bank_percent": 1,
            "obstacles": ["cleat@50:height=20,length=30,side=left"], "driven": "rear", "ambient_c": 0,
            "sensors": {"imu/gyro": {"noise": 0.01}}, "manoeuvre": "town", "tyre": "book-205-60r15", "seed": 9,
        }
    )  # fmt: skip
    assert drive.road == "gd=5e-05"
    assert drive.pressures == dict.fromkeys(WHEELS, 230e3)
    assert drive.leaks == {"rr": Leak(2e3, 5.0)}
    assert drive.pressure_sets == {"fl": PressureSet(130e3, 30.0, 0.1)}
    assert drive.radius_factor["rl"] == pytest.approx(0.997)
    assert (drive.payload, drive.payload_position, drive.grade, drive.bank) == (200.0, (0, 0, 0.1), 0.02, 0.01)
    assert (drive.driven, drive.ambient, drive.seed, drive.tyre) == ("rear", 273.15, 9, "book-205-60r15")


def test_vehicle_and_tyre_are_scaled_and_the_estimators_are_told_the_book_s() -> None:
    variant = variant_of(Scenario(), {"front": {"spring_rate": 1.1}}, {"pfz1": 0.8}, {})
    assert variant.vehicle is not None
    assert variant.tyre is not None
    assert variant.vehicle.front.spring_rate == pytest.approx(1.1 * load_vehicle().front.spring_rate)
    assert variant.tyre.pfz1 == pytest.approx(0.8 * load_tyre().pfz1)
    assert variant.car == believed_car(Scenario(), {})


def test_believed_changes_only_what_is_told() -> None:
    variant = variant_of(Scenario(), {}, {}, {"chassis_mass": 0.9, "tyre": "book-205-60r15"})
    assert variant.car is not None
    assert variant.car.chassis_mass == pytest.approx(0.9 * load_vehicle().chassis.mass)
    assert variant.car.rolling_radius < 0.33
    assert variant.vehicle == load_vehicle()


def test_edited_road_file_is_another_task(tmp_path: Path) -> None:
    from testbed.campaign import plan

    road = tmp_path / "road.txt"
    tasks = []
    for height in (0.001, 0.002):
        road.write_text("".join(f"{0.25 * k} {height * (k % 3)}\n" for k in range(200)))
        plan._digest.cache_clear()
        tasks.append(planned(f'[scenario]\nroad = "{road}"\nduration_s = 2\n').tasks[0])
    assert tasks[0]["scenario"] == tasks[1]["scenario"]
    assert tasks[0] != tasks[1]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("run = 3", "unknown field 'run'; valid: question, seed, runs"),
        ("runs = 0", "runs is 0, want a whole number of 1 or more"),
        ("runs = 2000000", "2000000 drives, want at most 1000000"),
        ("low_percent = 0", "low_percent is 0, want a number between 0 and 100"),
        ('estimators = ["crystal_ball"]', "no estimator 'crystal_ball', valid: .*wheel_radius"),
        ("scenario = 3", r"\[scenario\] is 3, want a table"),
        ("[scenario]\nspeed = 80", r"unknown field 'speed' of \[scenario\]; valid: road, road_gd, speed_kmh"),
        ("[scenario]\nspeed_kmh = 400", "speed 111.111.* m/s is out of range; valid: 0 to 55.5"),
        ("[scenario]\nspeed_kmh = { uniform = [80, 50] }", "want the lower limit first"),
        ("[scenario]\nspeed_kmh = { uniform = [80] }", "want two finite numbers"),
        ("[scenario]\nspeed_kmh = { normal = [80, -1] }", "want a standard deviation of 0 or more"),
        ("[scenario]\nroad_gd = { log_uniform = [0, 1] }", "want limits above 0"),
        ("[scenario]\nspeed_kmh = { sweep = [] }", "want a list of values"),
        ('[scenario]\nspeed_kmh = { sweep = [50, "C"] }', "want values of one kind"),
        ("[scenario]\nspeed_kmh = { unifrom = [1, 2] }", "want a number, or a table of one of sweep, choice, uniform"),
        ('[scenario]\nroad = "Z"', "Z"),
        ('[scenario]\nroad = { choice = ["C", "Z"] }', "Z"),
        ('[scenario]\nroad = "C"\nroad_gd = 1e-5', "says again what another field"),
        ("[scenario]\npressure_kpa = { xx = 3 }", "unknown wheel 'xx'; valid: fl, fr, rl, rr"),
        ("[scenario]\npayload_position_m = 3", "payload_position_m is 3, want a list"),
        ('[scenario]\nmanoeuvre = "flight"', "flight.*valid: .*constant"),
        ("[calibration]\nspeed = 80", "unknown field 'speed'"),
        ("[vehicle]\nwings = 2", r"\[vehicle\] has no number 'wings'; valid: "),
        ("[vehicle]\nfront.spring_rate = -1", r"\[vehicle\] front.spring_rate is -1, want a factor above 0"),
        ("[tyre]\nname = 2", r"\[tyre\] has no number 'name'"),
        ("[believed]\ntyre = 3", r"\[believed\] tyre is 3, want the name of a tyre"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "campaign.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as refused:
        read_campaign(path)
    assert str(refused.value).startswith(f"{path}: ")
    assert "\n" not in str(refused.value)


def test_file_that_is_not_there_or_not_toml_is_told(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="No such file"):
        read_campaign(tmp_path / "nowhere.toml")
    (tmp_path / "c.toml").write_text("runs: 3")
    with pytest.raises(ValueError, match="not TOML"):
        read_campaign(tmp_path / "c.toml")
