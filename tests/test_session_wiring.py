"""Claims about what joins the parts of a drive: each sensor feels its own motion, the estimators are told the car and
nothing true of the day, and an alarm reaches log, table, JSON and layout."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from estimators.drive_log import WHEELS, DriveLog
from estimators.readers import read_log
from models.tyre_properties import load_tyre
from models.vehicle import load_vehicle
from testbed.drive import main
from testbed.notes import known_car
from testbed.scenario import Scenario
from testbed.session import Session, Variant
from testbed.tyre.inflation import Leak

QUIET = {
    "*/accel*": {"noise": 0.0, "bias_std": 0.0, "scale_std": 0.0},
    "imu/gyro": {"noise": 0.0, "bias_std": 0.0, "scale_std": 0.0},
    "*/torque": {"noise": 0.0, "bias_std": 0.0, "scale_std": 0.0},
    "wheel/*/edges": {"pitch_error": 0.0},
}
SPEED, TEETH = 12.0, 48


def said(**fields) -> DriveLog:
    """Every signal of a drive with quiet sensors, the truth apart."""
    parts: dict[str, list] = {}
    with Session(Scenario(**({"sensors": QUIET} | fields)), None, []) as session:
        suite = session._suite
        advance = suite.advance

        def kept(chunk):
            signals = advance(chunk)
            for name, signal in signals.items():
                parts.setdefault(name, []).append(signal)
            return signals

        suite.advance = kept  # type: ignore[method-assign]
        for _ in session.run():
            pass
    joined = {}
    for name, signals in parts.items():
        time = np.concatenate([s.time for s in signals])
        value = np.concatenate([s.value for s in signals])
        joined[name] = type(signals[0])(time, value, signals[0].unit, signals[0].frame)
    return DriveLog(joined)


@pytest.fixture(scope="module")
def circle() -> DriveLog:
    """A left circle on a flat road, a leak in the rear right tyre."""
    return said(road="flat", manoeuvre="circle", speed=SPEED, duration=14.0, leaks={"rr": Leak(4e3, 2.0)})


def late(log: DriveLog, name: str) -> np.ndarray:
    """Mean over the last two seconds."""
    return log[name].between(12.0, 14.0).value.mean(axis=0)


def test_gyro_and_accelerometer_feel_a_left_turn_in_iso_axes(circle):
    yaw_rate = late(circle, "imu/gyro")[2]
    accel = late(circle, "imu/accel")
    assert yaw_rate > 0.1
    assert accel[1] == pytest.approx(SPEED * yaw_rate, rel=0.1)  # the body's roll adds g times its angle
    assert accel[2] == pytest.approx(9.81, abs=0.2)
    assert abs(late(circle, "imu/gyro")[:2]).max() < 0.05


def test_steering_wheel_turns_left_by_the_ratio(circle):
    v = load_vehicle()
    angle = late(circle, "steering/angle")
    curvature = late(circle, "imu/gyro")[2] / SPEED
    assert angle / v.driveline.steering_ratio == pytest.approx(v.wheelbase * curvature, rel=0.3)  # and understeer


def test_each_wheel_s_edges_and_bus_speed_are_its_own(circle):
    """Outer wheels faster by track times yaw rate; edges at 48 a turn."""
    speed = {wheel: late(circle, f"wheel/{wheel}/speed") for wheel in WHEELS}
    yaw_rate, v = late(circle, "imu/gyro")[2], load_vehicle()
    # load transfer at 3 m/s^2 makes the outer tyre roll shorter: a tenth more
    assert speed["rr"] - speed["rl"] == pytest.approx(1.1 * v.rear.track * yaw_rate / 0.36, rel=0.05)
    assert speed["fr"] > speed["fl"] > speed["rl"]  # the front wheels run on a wider circle
    assert speed["fr"] > speed["rr"]
    for wheel in WHEELS:
        edges = len(circle[f"wheel/{wheel}/edges"].between(12.0, 14.0))
        assert edges * 2.0 * np.pi / TEETH / 2.0 == pytest.approx(speed[wheel], abs=2.0 * np.pi / TEETH)


def test_each_tyre_sensor_hears_its_own_tyre(circle):
    lost = {w: circle[f"tyre/{w}/pressure"].value[0] - circle[f"tyre/{w}/pressure"].value[-1] for w in WHEELS}
    assert lost["rr"] > 30e3
    assert max(abs(lost[w]) for w in ("fl", "fr", "rl")) < 5e3


def test_pulling_away_is_felt_forward_and_its_torques_agree():
    """m a = T / R on the driven axle, less drag; engine torque times a gear's ratio and efficiency is the axle's."""
    log = said(road="flat", manoeuvre="stops", speed=10.0, duration=16.0)
    accel, torque = log["imu/accel"], log["driveline/torque"]
    x = np.interp(torque.time, accel.time, accel.value[:, 0])
    pulling = (x > 0.8) & (np.abs(np.gradient(torque.value, torque.time)) < 200.0)
    assert pulling.sum() > 50
    v = load_vehicle()
    force = torque.value[pulling] / 0.36
    assert np.median(force / (v.mass * x[pulling])) == pytest.approx(1.08, abs=0.08)  # wheels' inertia, rolling drag
    engine = np.interp(torque.time, log["engine/torque"].time, log["engine/torque"].value)[pulling]
    ratios = torque.value[pulling] / engine / v.driveline.efficiency
    nearest = np.array(v.driveline.gear_ratios)[np.argmin(np.abs(ratios[:, None] - v.driveline.gear_ratios), axis=1)]
    assert np.median(ratios / nearest) == pytest.approx(1.0, abs=0.02)


def test_hubs_feel_more_than_the_body_and_each_side_its_own_road():
    log = said(road="flat", obstacles=("cleat@15:height=20,length=50,side=left",), speed=SPEED, duration=4.0)

    def shaken(name: str) -> float:
        return float(np.ptp(log[name].value))

    for axle in "fr":
        assert shaken(f"hub/{axle}l/accel_z") > 3.0 * shaken(f"hub/{axle}r/accel_z")
        assert shaken(f"hub/{axle}l/accel_z") > 3.0 * shaken(f"body/{axle}l/accel_z")


def test_tyre_temperature_rises_as_the_tyre_warms():
    log = said(road="flat", speed=40.0, duration=20.0, sensors={"tyre/*": {"noise": 0.0, "quantisation": 0.0}})
    warmth = log["tyre/fl/temperature"].value
    assert warmth[-1] > warmth[0] > 290.0


@pytest.mark.parametrize(
    "fields",
    [{"pressures": {"fl": 150e3}}, {"leaks": {"rr": Leak(1e3, 1.0)}}, {"radius_factor": {"rl": 0.99}}, {"seed": 9}],
)
def test_estimators_are_told_the_same_car_whatever_is_true_of_the_day(fields):
    plain, day = (Session(Scenario(road="flat", duration=1.0, **f), None, None) for f in ({}, fields))
    cars = [next(iter(s.bank._members.values())).car for s in (plain, day)]
    assert cars[0] == cars[1]
    assert cars[0] == known_car(load_vehicle(), load_tyre(), Scenario())
    assert cars[0].steering_ratio == load_vehicle().driveline.steering_ratio
    assert cars[0].radius_sensitivity == pytest.approx(4e-8, rel=0.01)  # 1/Pa: real cars


def test_a_log_shows_estimators_no_scenario(tmp_path: Path):
    out = tmp_path / "drive.rrd"
    assert main(["--quiet", "--road", "flat", "--duration", "1", "--pressure", "fl=180", "--out", str(out)]) == 0
    log = read_log(out)
    assert log.notes["scenario"]["pressures"] == {"fl": 180e3}
    assert set(log.visible().notes) == {"car"}
    low = {w: float(log[f"truth/{w}/pressure"].value.mean()) for w in WHEELS}
    assert min(low, key=lambda w: low[w]) == "fl"


def test_estimators_import_neither_testbed_nor_simulator():
    code = (
        "import sys, estimators.__main__, estimators.runner, estimators.readers, estimators.report\n"
        "from estimators.registry import registered\nregistered()\n"
        "print([m for m in ('testbed', 'models', 'mujoco', 'dm_control') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_alarm_of_a_calibrated_drive_reaches_log_table_json_and_layout(tmp_path: Path, capsys):
    """Learnt on one road, driven on another with the same car: two commands, as the README shows."""
    learnt, found, out = tmp_path / "learnt.json", tmp_path / "found.json", tmp_path / "drive.rrd"
    ordinary = ["--manoeuvre", "motorway", "--speed", "90", "--car-seed", "5"]
    first = [*ordinary, "--duration", "200", "--road", "B", "--seed", "1", "--json", str(learnt)]
    assert main([*first, "--out", str(tmp_path / "first.rrd"), "--quiet"]) == 0
    assert json.loads(learnt.read_text())["alarms"] == []
    second = [*ordinary, "--duration", "60", "--road", "C", "--seed", "2", "--pressure", "fl=180"]
    assert main([*second, "--calibration", str(learnt), "--json", str(found), "--out", str(out)]) == 0
    alarms = json.loads(found.read_text())["alarms"]
    assert all(alarm["text"].startswith("fl: low pressure") for alarm in alarms)  # the direct sensors see it as well
    (alarm,) = [alarm for alarm in alarms if alarm["method"] == "wheel_radius"]
    assert f"alarm {alarm['time_s']:.1f} s" in capsys.readouterr().out
    log = read_log(out)
    assert log["alarm/wheel_radius"].value.tolist() == [alarm["text"]]
    assert log["alarm/wheel_radius"].time.tolist() == [alarm["time_s"]]


def test_sensors_that_nobody_reads_may_be_left_out() -> None:
    """What the estimator says is the same to the last bit, with fewer sensors."""
    scenario, heard, counts = Scenario(road="C", duration=6.0), [], []
    for only in (False, True):
        with Session(scenario, None, ["wheel_radius"], Variant(only_read=only)) as session:
            heard.append([words for _, words in session.run()])
            counts.append(len(session._suite._lines))
    assert heard[0] == heard[1]
    assert counts[1] < counts[0]
