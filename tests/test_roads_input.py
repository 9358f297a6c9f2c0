"""Contract of every kind of road, friction maps, bad input and the command line."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from testbed.roads import Road, make_road, road_kinds
from testbed.roads.__main__ import main
from testbed.roads.friction import friction_at, parse_friction

ROOT = Path(__file__).resolve().parents[1]


def example_spec(example: str, folder: Path) -> str:
    """The kind's own example; a file kind's example is made here, for a name alone is no road."""
    path = folder / example
    rng = np.random.default_rng(1)
    if example.endswith(".txt"):
        path.write_text("".join(f"{0.2 * k:.3f} {z:.5f}\n" for k, z in enumerate(rng.normal(0.0, 0.01, 400))))
    elif example.endswith(".crg"):
        import pyopencrg

        pyopencrg.CrgRoad(rng.normal(0.0, 0.01, (300, 9)), u_inc=0.02, v=2.0).save(str(path))
    else:
        return example
    return str(path)


@pytest.mark.parametrize("kind", road_kinds(), ids=lambda kind: kind.example)
def test_every_kind_of_road_keeps_the_contract(kind, tmp_path: Path) -> None:
    spec = example_spec(kind.example, tmp_path)
    assert [other for other in road_kinds() if other.recognises(spec)] == [kind]
    road = make_road(spec, 5, 20.0, 60.0)
    assert isinstance(road.raw, Road)
    assert road.name == spec
    assert 0.01 <= road.spacing <= 0.05
    x, y = road.spacing * np.arange(-40, 3000), road.spacing * np.arange(-37, 41)
    z = road.heights(x, y)
    assert z.shape == (len(y), len(x))
    assert z.dtype == np.float64
    assert np.isfinite(z).all()
    assert not z[:, x <= 0.0].any()
    assert kind.example == "flat" or z[:, x > 5.0].std() > 1e-4
    # however the plane is cut, the same bytes; asked backwards, by another road made alike
    again = make_road(spec, 5, 20.0, 60.0)
    pieces = [[again.heights(x[i : i + 379], y[j : j + 11]) for i in range(0, 3040, 379)] for j in range(0, 78, 11)]
    assert np.block(pieces).tobytes() == z.tobytes()
    assert np.isfinite(again.heights(x + road.spacing * 10**6, y)).all()


def test_kinds_are_found_by_themselves() -> None:
    examples = {kind.example for kind in road_kinds()}
    assert {"flat", "A:200,D:300", "road.crg", "profile.txt"} <= examples


BAD_SPECS = [
    ("Z", "'Z' is unknown"),
    ("", "is unknown"),
    ("A:200,Q:30", "'Q' is unknown"),
    ("A:0,B", "'A:0'"),
    ("A:nan,B", "'A:nan'"),
    ("A:-5", "'A:-5'"),
    ("A,B", "'A'"),
    ("A:10,", "'' is unknown"),
    ("gd=0", "gd must be"),
    ("gd=x", "gd must be"),
    ("gd=nan", "gd must be"),
    ("/nowhere/x.crg", "no such file"),
    ("/nowhere/x.txt", "No such file"),
]


@pytest.mark.parametrize(("spec", "says"), BAD_SPECS)
def test_bad_road_is_named_in_one_line(spec: str, says: str) -> None:
    with pytest.raises(ValueError, match=re.escape(says)) as caught:
        make_road(spec, 1, 20.0, 60.0)
    assert "\n" not in str(caught.value)


BAD_OPTIONS = [
    ({"seed": -1}, "seed -1"),
    ({"speed": float("nan")}, "speed of nan"),
    ({"speed": 300.0}, "300"),
    ({"duration": 0.0}, "duration of 0.0"),
    ({"grade": 0.9}, "grade 0.9"),
    ({"bank": float("nan")}, "bank nan"),
    ({"obstacles": ["ramp@3:height=1,length=2"]}, "ramp@3"),
    ({"obstacles": ["cleat@x:height=20,length=30"]}, "place 'x'"),
    ({"obstacles": ["cleat@5:height=20"]}, "length ''"),
    ({"obstacles": ["cleat@5:height=-20,length=30"]}, "height '-20'"),
    ({"obstacles": ["cleat@5:depth=20,length=30"]}, "'depth'"),
    ({"obstacles": ["pothole@5:depth=20,length=30,side=up"]}, "side 'up'"),
    ({"obstacles": ["cleat@5:height=20,height=20,length=30"]}, "twice"),
]


@pytest.mark.parametrize(("options", "says"), BAD_OPTIONS)
def test_bad_option_is_named_in_one_line(options: dict, says: str) -> None:
    with pytest.raises(ValueError, match=re.escape(says)) as caught:
        make_road("flat", **({"seed": 1, "speed": 20.0, "duration": 60.0} | options))
    assert "\n" not in str(caught.value)


LINES = "".join(f"{k} 0.0\n" for k in range(20))
BAD_PROFILES = [
    ("", "0 points"),
    ("0 0\n1 0\n", "2 points"),
    (LINES + "21 x\n", "line 21: '21 x'"),
    (LINES + "5 0\n", "line 21: x = 5"),
    (LINES + "19 0\n", "line 21: x = 19"),
    (LINES + "20 nan\n", "line 21"),
    (LINES + "20\n", "line 21: '20'"),
    (LINES + "20 1 2\n", "line 21"),
    (LINES + "500 0\n", "line 21: x = 500"),
    ("\x00\xff" * 40, "not text"),
]


@pytest.mark.parametrize(("text", "says"), BAD_PROFILES)
def test_bad_profile_is_named_with_its_line(text: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.txt"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ValueError, match=r"bad\.txt") as caught:
        make_road(str(path), 1, 20.0, 60.0)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def _crg_bytes(folder: Path) -> bytes:
    return Path(example_spec("road.crg", folder)).read_bytes()


@pytest.mark.parametrize("share", [0.0, 0.05, 0.3, 0.9, 0.999])
def test_truncated_crg_is_named_in_one_line(share: float, tmp_path: Path) -> None:
    whole = _crg_bytes(tmp_path)
    path = tmp_path / "cut.crg"
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(ValueError, match=r"cut\.crg") as caught:
        make_road(str(path), 1, 20.0, 60.0)
    assert "\n" not in str(caught.value)


def test_damaged_crg_is_refused_in_one_line_or_read_soundly(tmp_path: Path) -> None:
    whole = _crg_bytes(tmp_path)
    rng = np.random.default_rng(4)
    path = tmp_path / "hit.crg"
    header = whole.index(b"$$$$")
    refusals = []
    for _ in range(60):
        damaged = bytearray(whole)
        for _ in range(60):
            damaged[int(rng.integers(header))] = int(rng.integers(256))
        path.write_bytes(bytes(damaged))
        try:
            road = make_road(str(path), 1, 20.0, 60.0)
        except ValueError as error:
            refusals.append(str(error))
        else:
            assert np.isfinite(road.heights(0.05 * np.arange(200), np.zeros(1))).all()
    assert len(refusals) > 3
    assert all("hit.crg" in refusal and "\n" not in refusal for refusal in refusals)


def test_friction_is_looked_up_by_section_and_side() -> None:
    road = parse_friction("0.9:100,0.9/0.2:50,0.5")
    where = [(-5.0, 1.0, 0.9), (99.9, -1.0, 0.9), (100.0, 0.0, 0.9), (120.0, -0.1, 0.2), (150.0, -1.0, 0.5)]
    for x, y, mu in where:
        assert friction_at(x, y, road.edges, road.left, road.right) == mu
    ended = parse_friction("1:10,0.3:10")
    assert friction_at(1e6, 0.0, ended.edges, ended.left, ended.right) == 0.3
    with pytest.raises(ValueError, match="read-only"):
        road.left[0] = 1.0


@pytest.mark.parametrize(
    "spec", ["", "0", "-0.5", "2.1", "nan", "inf", "0.9/0", "0.9/0.3/0.2", "0.9,0.3", "0.9:x,0.3", "0.9:0", "ice"]
)
def test_bad_friction_is_named_in_one_line(spec: str) -> None:
    with pytest.raises(ValueError, match=f"friction '{spec}'") as caught:
        parse_friction(spec)
    assert "\n" not in str(caught.value)


def test_command_line_prints_both_tracks(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["C", "--length", "300", "--seed", "2"]) == 0
    out = capsys.readouterr().out
    assert out.count("class C") == 2
    assert "left" in out
    assert "right" in out


def test_command_line_names_bad_input_on_one_line_with_status_2() -> None:
    command = [sys.executable, "-m", "testbed.roads", "Z"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=60)
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr.count("\n") == 1
    assert "'Z'" in run.stderr
    assert main(["C", "--length", "-3"]) == 2
