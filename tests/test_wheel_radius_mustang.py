"""What the wheel-radius analysis says of a real car: 70 s of a rear-driven Mustang whose right rear tyre is a third
low.

Direct sensors say 193, 186, 198, 133.5 kPa. The log has wheel speeds, accelerations and pedals, no gyro, no torque, no
earlier drive to calibrate on, and about 25 s above 4 m/s. So lateral acceleration stands in for the yaw rate, and only
left/right and diagonal differences are looked at: front and rear tyres of this car differ by 1 % in size.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from estimators.__main__ import main
from estimators.car import Car
from estimators.drive_log import WHEELS, DriveLog, Signal
from estimators.grid import Grid
from estimators.readers.column_map import load_map
from estimators.runner import Bank, run_bank
from estimators.wheel_radius.low_pressure import likeliest_loss
from estimators.wheel_radius.motion import CHANNELS, MotionTracker
from estimators.wheel_radius.residuals import Methods
from estimators.wheel_radius.wheel_change import wheel_change
from tests.synthetic_drive import last

PATH = Path(__file__).resolve().parents[2] / "shared" / "data" / "mustang_wheels_tpms.csv"
CAR = Car.from_notes(load_map("mustang").notes)  # as the built-in map declares it


@cache
def table() -> np.ndarray:
    if not PATH.exists():
        pytest.skip(f"measured data absent: {PATH}")
    return np.genfromtxt(PATH, delimiter=",", names=True)


def log() -> DriveLog:
    """Wheel speeds [rad/s] and accelerations [m/s^2]; column signs are ISO's already."""
    data = table()
    signals = {f"wheel/{w}/speed": Signal(data["t_s"], data[f"{w}_kmh"] / 3.6 / CAR.rolling_radius) for w in WHEELS}
    accel = np.column_stack([data["ax_mps2"], data["ay_mps2"], np.full(len(data), np.nan)])
    return DriveLog(signals | {"imu/accel": Signal(data["t_s"], accel, "m/s^2")}, {"car": asdict(CAR)})


def test_the_rear_wheels_differ_as_published_while_the_car_slows_down() -> None:
    data = table()
    speed = 0.5 * (data["fl_kmh"] + data["fr_kmh"]) / 3.6
    slowing = (speed > 4.0) & (data["pedal_pct"] < 1.0)
    ratio = np.log(data["rl_kmh"][slowing] / data["rr_kmh"][slowing])
    assert ratio.mean() == pytest.approx(-2.3e-3, abs=0.4e-3)


def test_static_residual_points_at_rr_or_fl_and_cannot_say_which() -> None:
    value, std = last(run_bank(Bank(None, CAR), log()), "static_residual")
    assert value > 1.3 * std  # measured: +1.0e-3, std 0.70e-3 after 15 s of readable driving
    assert value == pytest.approx(1.1e-3, abs=0.6e-3)


def test_with_lateral_acceleration_for_the_yaw_rate_the_lateral_filter_points_at_rr() -> None:
    """delta34 > 0: rr is smaller than rl, by two thirds to the whole of what -33 % means at 4e-5 per kPa (2.6e-3)."""
    said = run_bank(Bank(None, CAR), log())
    rear, rear_std = last(said, "delta34")
    front, _ = last(said, "delta12")
    assert rear > 3.0 * rear_std
    assert 1.0e-3 < rear < 3.0e-3
    assert abs(front) < 0.6 * rear


def test_the_likeliest_single_explanation_is_a_low_rr() -> None:
    methods, tracker, grid = Methods(CAR), MotionTracker(CAR, 0.1), Grid(CHANNELS, 0.1)
    grid.add(log())
    cells, _ = grid.close(100.0)
    for index, centre, cell in zip(cells.index.tolist(), cells.centre.tolist(), cells.value, strict=True):
        methods.step(tracker.motion(index, centre, cell))
    residuals = methods.residuals()
    left_right_and_diagonal = np.array([True, True, True, False, False])
    loss = likeliest_loss(*wheel_change(residuals.value, residuals.covariance, left_right_and_diagonal))
    assert [WHEELS[i] for i in loss.wheels] == ["rr"]
    assert -3.0e-3 < loss.change < -1.0e-3


def test_an_uncalibrated_car_gets_no_alarm_and_a_std_as_wide_as_tyres_differ() -> None:
    bank = Bank(None, CAR)
    said = run_bank(bank, log())
    assert bank.alarms["wheel_radius"] == []
    assert last(said, "rr/relative_radius_change")[1] > 1.5e-3


def test_the_command_reports_the_ratio_of_the_rear_radii_and_calls_no_tyre_low(tmp_path: Path) -> None:
    """RR is a third low: r_rl / r_rr above 1. Measured independently while slowing down: +2.3e-3 +- 0.4e-3."""
    table()
    out = tmp_path / "mustang.json"
    assert main([str(PATH), "wheel_radius", "--json", str(out)]) == 0
    document = json.loads(out.read_text())
    (row,) = [row for row in document["rows"] if row["name"] == "ln_radius_rl_over_rr"]
    assert set(row) == {"name", "unit", "paper", "here", "ci95", "limit"}
    low, high = row["ci95"]
    assert 0.0 < low < row["here"] < high  # larger left than right, surely
    std = (high - low) / (2.0 * 1.96)
    assert abs(row["here"] - 2.3e-3) < 2.0 * np.hypot(std, 0.4e-3)
    assert document["estimators"]["wheel_radius"]["alarms"] == []


def test_with_a_calibration_of_this_car_the_right_rear_is_called_low(tmp_path: Path) -> None:
    """A calibration that says that left and right tyres of this car are alike when their pressures are."""
    table()
    alike = {name: {"level": 0.0, "std": 1e-4} for name in ("static_residual", "delta12", "delta34")}
    calibration, out = tmp_path / "calibration.json", tmp_path / "mustang.json"
    calibration.write_text(json.dumps({"calibration": {"wheel_radius": alike}}))
    assert main([str(PATH), "wheel_radius", "--calibration", str(calibration), "--json", str(out)]) == 0
    alarms = json.loads(out.read_text())["estimators"]["wheel_radius"]["alarms"]
    assert alarms
    assert "rr" in alarms[-1]["text"] or alarms[-1]["wheels"] == ["rr"]
    assert set(alarms[-1]["wheels"]) <= {"rr"}


def test_the_same_car_as_an_mdf4_log_gives_the_same_ratio(tmp_path: Path) -> None:
    """The reader for a new car is a column map: the built-in one serves channels of these names as well."""
    asammdf = pytest.importorskip("asammdf", reason="needs asammdf (the extra mdf)")
    data = table()
    file = asammdf.MDF(version="4.10")
    names = [name for name in data.dtype.names if name != "t_s"]
    file.append([asammdf.Signal(samples=data[name], timestamps=data["t_s"], name=name) for name in names])
    path = file.save(tmp_path / "mustang.mf4")
    rows = []
    for log_file, out in ((PATH, tmp_path / "csv.json"), (path, tmp_path / "mf4.json")):
        assert main([str(log_file), "wheel_radius", "--json", str(out)]) == 0
        rows.append(json.loads(out.read_text())["rows"])
    assert rows[0] == rows[1]
