"""Claims about logs of real cars: a column map makes SI signals of them, and bad files are refused by name."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from estimators.drive_log import WHEELS
from estimators.readers import read_log
from estimators.readers.column_map import load_map
from estimators.readers.rrd import save_log

MUSTANG = Path(__file__).parents[2] / "shared" / "data" / "mustang_wheels_tpms.csv"
MAP: dict[str, Any] = {
    "time": {"column": "t", "scale": 1e-3},
    "constants": {"radius_m": 0.5},
    "signals": {
        "wheel/fl/speed": {"column": "v", "scale": 1.0 / 3.6, "per": "radius_m", "unit": "rad/s"},
        "imu/accel": {"columns": ["ax", "", "az"], "unit": "m/s^2", "frame": "chassis"},
        "tyre/fl/temperature": {"column": "T", "offset": 273.15, "unit": "K"},
    },
}


def written(folder: Path, text: str) -> Path:
    (folder / "car.csv").write_text(text)
    return folder / "car.csv"


def test_columns_become_si_signals_on_their_own_clocks(tmp_path: Path) -> None:
    text = "t,v,ax,az,T\n0,36,1,9.8,20\n10,,1.5,9.9,\n10,72,nan,9.7,30\n5,18,2,9.6,\n"
    log = read_log(written(tmp_path, text), MAP)
    assert log["wheel/fl/speed"].value == pytest.approx(
        [20.0, 40.0, 10.0]
    )  # 36 km/h = 10 m/s on 0.5 m; empty: no sample
    assert log["wheel/fl/speed"].time.tolist() == [0.0, 0.01, 0.005]  # late where it came late
    accel = log["imu/accel"]
    assert (accel.unit, accel.frame, accel.value.shape) == ("m/s^2", "chassis", (4, 3))
    assert np.isnan(accel.value[:, 1]).all()  # not measured
    assert np.isnan(accel.value[2, 0])  # the sensor said so
    assert log["tyre/fl/temperature"].value == pytest.approx([293.15, 303.15])
    assert log.notes["constants"] == {"radius_m": 0.5}


def test_a_map_in_toml_is_the_map_in_a_dict(tmp_path: Path) -> None:
    toml = """
    title = "Semicolons"
    delimiter = ";"
    skip_lines = 1
    [time]
    column = "t"
    from_first = true
    [signals."steering/angle"]
    column = "delta"
    scale = 0.017453292519943295
    unit = "rad"
    """
    (tmp_path / "map.toml").write_text(toml)
    log = read_log(written(tmp_path, "made by a logger\nt;delta\n1.7e9;180\n1700000000.5;90\n"), tmp_path / "map.toml")
    assert log["steering/angle"].value == pytest.approx([np.pi, np.pi / 2])
    assert log["steering/angle"].time.tolist() == [0.0, 0.5]
    assert log.notes["time_origin_s"] == 1.7e9
    assert log.notes["title"] == "Semicolons"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "empty file"),
        ("\n\n", "empty CSV log"),
        ("t,v,ax,az,T\n", "a header but no samples"),
        ("t,v,ax,az,T\n0,36,1,9.8,20\n10,36,1", "line 3 has 3 cells, the header 5"),
        ("t,v,ax,az,T\n0,36,1,9.8,20\n10,fast,1,9.8,20\n", "column 'v', line 3: 'fast' is not a number"),
        ("t,v,ax,az\n0,36,1,9.8\n", "no column 'T', it has t, v, ax, az"),
        ("t,v,ax,az,T\n0,36,1,9.8,20\n,36,1,9.8,20\n", "line 3 has no time"),
        ("t,v,ax,az,T\n20,36,1,9.8,20\n10,36,1,9.8,20\n", "'t' runs from 20 to 10, want time that goes forward"),
        ("t,v,ax,az,T\ninf,36,1,9.8,20\n", "needs a finite time"),
    ],
)
def test_a_malformed_csv_log_is_refused_in_one_line(tmp_path: Path, text: str, said: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(ValueError, match=said) as caught:
        read_log(path, MAP)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_bytes_are_no_csv_log(tmp_path: Path) -> None:
    (tmp_path / "car.csv").write_bytes(b"\xff\xfe\x00binary\x99")
    with pytest.raises(ValueError, match="not text"):
        read_log(tmp_path / "car.csv", MAP)


def test_columns_that_no_built_in_map_knows_are_listed(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"no built-in column map fits columns speed, zeit.*mustang"):
        read_log(written(tmp_path, "zeit,speed\n0,1\n"))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"signals": {}}, "no signals"),
        ({"signals": {"a": {}}}, r"columns \[\], want"),
        ({"signals": {"a": {"column": "x", "scale": "big"}}}, "scale is 'big', want a number"),
        ({"signals": {"a": {"column": "x", "scale": float("nan")}}}, "scale is nan"),
        ({"signals": {"a": {"column": "x", "per": "r"}}}, "per 'r' is no constant"),
        ({"signals": {"a": {"column": "x", "gain": 2}}}, "unknown key 'gain', want column, columns"),
        (
            {"car": {"driven_axle": "middle"}, "signals": {"a": {"column": "x"}}},
            r"\[car\]: car driven_axle is 'middle'",
        ),
        ({"singals": {"a": {"column": "x"}}}, "unknown key 'singals'"),
    ],
)
def test_a_wrong_column_map_is_refused(wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        load_map(wrong)


def test_an_unknown_map_lists_the_built_in_ones(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"no such column map, want a \.toml file or one of mustang"):
        load_map("audi")
    (tmp_path / "bad.toml").write_text("signals = [")
    with pytest.raises(ValueError, match=r"bad\.toml: not a TOML column map"):
        load_map(tmp_path / "bad.toml")


@pytest.fixture
def mustang() -> Path:
    if not MUSTANG.is_file():
        pytest.skip(f"needs {MUSTANG}")
    return MUSTANG


def test_the_mustang_log_reads_with_the_built_in_map(mustang: Path, tmp_path: Path) -> None:
    log = read_log(mustang)
    start, end = log.span
    assert (start, end) == (pytest.approx(0.018), pytest.approx(70.359))
    speeds = [log[f"wheel/{wheel}/speed"] for wheel in WHEELS]
    assert {speed.unit for speed in speeds} == {"rad/s"}
    assert max(s.value.max() for s in speeds) * 0.34 * 3.6 == pytest.approx(48.0, abs=1.0)  # km/h; its README: 0-48
    pressures = {wheel: log[f"tyre/{wheel}/pressure"].value / 1e3 for wheel in WHEELS}
    assert {w: p[0] for w, p in pressures.items()} == {"fl": 193.0, "fr": 186.0, "rl": 198.0, "rr": 133.0}
    assert (pressures["rr"].min(), pressures["rr"].max()) == (133.0, 134.0)
    save_log(log, tmp_path / "mustang.rrd")
    assert read_log(tmp_path / "mustang.rrd") == log


def test_the_mustang_accelerates_forwards_where_its_wheels_do(mustang: Path) -> None:
    log = read_log(mustang)
    speed = log["wheel/rl/speed"]
    grid = np.arange(0.5, 70.0, 0.1)
    gained = np.gradient(np.interp(grid, speed.time, np.convolve(speed.value, np.ones(33) / 33, "same")), grid)
    felt = np.interp(grid, log["imu/accel"].time, log["imu/accel"].value[:, 0])
    assert np.corrcoef(gained, felt)[0, 1] > 0.8  # axis and sign of the map; 0.9 measured


def test_mdf_without_its_package_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "car.mf4").write_bytes(b"MDF     4.10")
    monkeypatch.setitem(sys.modules, "asammdf", None)
    with pytest.raises(ValueError, match=r"needs asammdf, install it with: pip install 'vehicle-testbed\[mdf\]'"):
        read_log(tmp_path / "car.mf4", MAP)


def test_mdf_channels_become_signals_on_their_own_clocks(tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", reason="needs asammdf (the extra mdf)")
    file = asammdf.MDF(version="4.10")
    fast, slow = np.arange(100) * 0.01, np.arange(10) * 0.1
    file.append([asammdf.Signal(samples=fast * 3.6, timestamps=fast, name="v")])
    file.append([asammdf.Signal(samples=slow + 200.0, timestamps=slow, name="p")])
    path = file.save(tmp_path / "car.mf4")
    columns = {"wheel/fl/speed": {"column": "v", "scale": 1 / 3.6}, "tyre/fl/pressure": {"column": "p", "scale": 1e3}}
    log = read_log(path, {"signals": columns})
    assert log["wheel/fl/speed"].value == pytest.approx(fast)
    assert log["tyre/fl/pressure"].value == pytest.approx((slow + 200.0) * 1e3)
    assert log["tyre/fl/pressure"].time == pytest.approx(slow)
    content = Path(path).read_bytes()
    for length in (100, 500, 2000):
        (tmp_path / "cut.mf4").write_bytes(content[:length])
        with pytest.raises(ValueError, match=r"cut\.mf4: "):
            read_log(tmp_path / "cut.mf4", {"signals": columns})
