"""Claims about `.tir` files: there and back, units, scaling, sides, versions, measured files, and bad input."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from models.tir import MANDATORY, ODD
from models.tyre_properties import NUMBERS, TyreProperties, load_tyre
from testbed.tyre import vertical
from testbed.tyre.contact import residual_longitudinal_stiffness
from testbed.tyre.magic_formula import slip_forces

DATA = Path(__file__).parents[1] / "../shared/data"
FED_ALPHA = {40: 406520.0, 95: 848550.0}  # pressure [psi] in the name, vertical stiffness in the file [N/m]
KEYS = {
    "r0": "UNLOADED_RADIUS", "fz0": "FNOMIN", "p0": "NOMPRES", "cz0": "VERTICAL_STIFFNESS", "v0": "LONGVL",
    "cx": "LONGITUDINAL_STIFFNESS", "cy": "LATERAL_STIFFNESS", "bottom_offset": "BOTTOM_OFFST",
    "bottom_stiffness": "BOTTOM_STIFF", "valid_pressure_min": "PRESMIN", "valid_pressure_max": "PRESMAX",
}  # fmt: skip


def refusal(path: str | Path) -> str:
    """The one line with which a tyre is refused."""
    with pytest.raises(ValueError, match=r"\S") as caught:
        load_tyre(path)
    message = str(caught.value)
    assert "\n" not in message
    return message


def write_tir(path: Path, tyre: TyreProperties, units: str = "", extra: str = "", **changes: str) -> Path:
    """A Magic Formula 6.1 file of a set; changes: text in place of a value, by upper-case key."""
    lines = [
        "$ written by a test \x85 and a character that Unicode takes for a line's end",
        "[UNITS]",
        units,
        "[MODEL]",
        "FITTYP = 61 $ version",
        extra,
        "[ALL]",
    ]
    for name in NUMBERS:
        key = KEYS.get(name, name.upper())
        lines.append(f"{key:24} = {changes.get(key, repr(getattr(tyre, name)))}   ! number")
    path.write_text("\n".join(lines) + "\n", encoding="latin-1")
    return path


def test_there_and_back_through_a_tir_file(tmp_path):
    tyre = load_tyre()
    again = load_tyre(write_tir(tmp_path / "suv.tir", tyre, extra="TYRESIDE = 'LEFT'"))
    for name in NUMBERS:
        assert getattr(again, name) == getattr(tyre, name), name


def test_units_section_converts(tmp_path):
    tyre = load_tyre()
    values = {
        "UNLOADED_RADIUS": tyre.r0 * 1e3, "WIDTH": tyre.width * 1e3, "RIM_RADIUS": tyre.rim_radius * 1e3,
        "BOTTOM_OFFST": tyre.bottom_offset * 1e3, "FNOMIN": tyre.fz0 / 1e3, "LONGVL": tyre.v0 * 1e3,
        "VERTICAL_STIFFNESS": tyre.cz0 / 1e6, "LONGITUDINAL_STIFFNESS": tyre.cx / 1e6,
        "LATERAL_STIFFNESS": tyre.cy / 1e6,
        "BOTTOM_STIFF": tyre.bottom_stiffness / 1e6, "BELT_MASS": tyre.belt_mass * 1e3, "BELT_IXX": tyre.belt_ixx * 1e9,
        "BELT_IYY": tyre.belt_iyy * 1e9, "NOMPRES": tyre.p0 / 1e5, "PRESMIN": tyre.valid_pressure_min / 1e5,
        "PRESMAX": tyre.valid_pressure_max / 1e5,
    }  # fmt: skip
    units = "LENGTH = 'mm'\nFORCE = 'kilonewton'\nMASS = 'gram'\nTIME='second'\nANGLE = 'degrees'\nPRESSURE = 'bar'"
    path = write_tir(tmp_path / "mm.tir", tyre, units, **{key: repr(value) for key, value in values.items()})
    again = load_tyre(path)
    for name in NUMBERS:
        assert getattr(again, name) == pytest.approx(getattr(tyre, name), rel=1e-12), name


def test_scaling_factors_act_like_friction_and_stiffness(tmp_path):
    tyre = load_tyre()
    factors = "LMUX = 0.8\nLMUY = 0.8"
    scaled = load_tyre(write_tir(tmp_path / "wet.tir", tyre, extra=factors))
    inputs = (0.05, 0.04, 0.02, 4000.0, 230e3, 20.0)
    wet = slip_forces(tyre.slip_array(), *inputs, 0.8, 1.0)
    folded = slip_forces(scaled.slip_array(), *inputs, 1.0, 1.0)
    assert np.allclose(folded, wet, rtol=1e-12)


def test_right_hand_file_is_mirrored_and_symmetric_file_made_even(tmp_path):
    tyre = load_tyre()
    right = load_tyre(write_tir(tmp_path / "right.tir", tyre, extra="TYRESIDE = 'Right'"))
    even = load_tyre(write_tir(tmp_path / "even.tir", tyre, extra="TYRESIDE = 'SYMMETRIC'"))
    assert all(getattr(right, name) == -getattr(tyre, name) for name in ODD)
    assert slip_forces(even.slip_array(), 0.0, 0.0, 0.0, 4000.0, 250e3, 20.0, 1.0, 1.0)[1:] == (0.0, 0.0)


def test_magic_formula_5_camber_is_kept_exactly(tmp_path):
    """MF 5.2: SHy holds PHY3 gamma, SVy holds Fz (PVY3 + PVY4 dfz) gamma, and nothing else depends on camber so."""
    tyre = dataclasses.replace(load_tyre(), phy3=0.031, pky4=2.0, pky5=0.0)
    path = write_tir(tmp_path / "mf5.tir", tyre)
    text = "\n".join(line for line in path.read_text("latin-1").split("\n") if not line.startswith(("PKY6", "PKY7")))
    path.write_text(text, "latin-1")
    old = load_tyre(path)
    plain = dataclasses.replace(old, **dict.fromkeys(ODD, 0.0), pky3=0.0, pey4=0.0)
    lean, fz = 1e-5, 4000.0
    q = plain.slip_array()
    fy = slip_forces(q, 0.0, 0.0, lean, fz, plain.p0, 20.0, 1.0, 1.0)[1]
    stiffness = (slip_forces(q, 0.0, 1e-6, 0.0, fz, plain.p0, 20.0, 1.0, 1.0)[1]) / 1e-6
    dfz = fz / plain.fz0 - 1.0
    expected = (stiffness * 0.031 + fz * (plain.pvy3 + plain.pvy4 * dfz)) * lean
    assert fy == pytest.approx(expected, rel=1e-5)  # second order in the small angle


@pytest.mark.parametrize("psi", FED_ALPHA)
def test_measured_truck_tyre_loads_with_its_stiffness_and_finite_forces(psi):
    path = DATA / f"fed_alpha_335_65R22.5_{psi}psi.tir"
    if not path.is_file():
        pytest.skip(f"needs {path}")
    tyre = load_tyre(path)
    law = vertical.vertical_law(tyre)
    assert vertical.mean_stiffness(law, tyre.p0, 0.0, tyre.fz0) == pytest.approx(FED_ALPHA[psi], rel=1e-9)
    assert tyre.p0 == pytest.approx(psi * 6894.757, abs=1e4)  # the file has one decimal of a bar
    assert residual_longitudinal_stiffness(tyre) > 0.0
    assert any("PFZ1" in note for note in tyre.notes)
    assert any("belt_mass" in note for note in tyre.notes)
    q = tyre.slip_array()
    for kappa, tan_alpha in ((0.1, 0.0), (-1.0, 0.1), (0.0, 0.1), (0.05, -0.05)):
        for pressure in (0.0, tyre.p0):
            fx, fy, mz = slip_forces(q, kappa, tan_alpha, 0.05, tyre.fz0, pressure, 15.0, 1.0, 1.0)
            assert math.isfinite(mz)
            assert fx * kappa >= 0.0
            assert math.hypot(fx, fy) < 1.5 * tyre.fz0
    assert slip_forces(q, 0.0, 0.1, 0.0, tyre.fz0, tyre.p0, 15.0, 1.0, 1.0)[1] < 0.0


# ---------------------------------------------------------------- bad .tir files


@pytest.mark.parametrize("core", MANDATORY)
def test_tir_without_a_core_key_is_refused_by_name(tmp_path, core):
    key = KEYS.get(core, core.upper())
    path = write_tir(tmp_path / "short.tir", load_tyre())
    kept = [line for line in path.read_text("latin-1").split("\n") if not line.startswith(f"{key} ")]
    path.write_text("\n".join(kept), "latin-1")
    message = refusal(path)
    assert key in message
    assert str(path) in message


def test_truncated_tir_is_refused_with_what_is_missing(tmp_path):
    path = write_tir(tmp_path / "cut.tir", load_tyre())
    text = path.read_text("latin-1")
    for share in (0.02, 0.1, 0.2, 0.4, 0.5):
        path.write_text(text[: int(share * len(text))], "latin-1")
        message = refusal(path)
        assert str(path) in message
        assert "missing" in message or "line" in message or "not a number" in message


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "empty"),
        (b" \n\n", "empty"),
        (b"\x00\x01\x02" * 50, "not a text file"),
        (b"hello\nworld\n", "line 1"),
        (b"PCX1 = 1.0\n", "no section"),
        (b"[UNITS\nLENGTH = 'meter'\n", "line 1"),
        (b"[UNITS]\nLENGTH = 'furlong'\n", "furlong"),
        (b"[A]\nPCX1 = 1.0\nPCX1 = 2.0\n", "line 3"),
        (b"[A]\nPCX1 = nan\n", "line 2"),
        (b"[A]\nPCX1 = 'one'\n", "PCX1"),
        (b"[UNITS]\nLENGTH = 'meter'\n", "missing UNLOADED_RADIUS"),
    ],
)
def test_malformed_tir_is_refused_with_path_and_place(tmp_path, content, told):
    path = tmp_path / "bad.tir"
    path.write_bytes(content)
    message = refusal(path)
    assert str(path) in message
    assert told in message


@pytest.mark.parametrize(
    ("key", "value"),
    [("UNLOADED_RADIUS", "0.0"), ("FNOMIN", "-4000"), ("VERTICAL_STIFFNESS", "0"), ("NOMPRES", "-1"), ("PCX1", "0")],
)
def test_impossible_number_in_a_tir_is_refused(tmp_path, key, value):
    path = write_tir(tmp_path / "bad.tir", load_tyre(), **{key: value})
    assert "must be positive" in refusal(path)
