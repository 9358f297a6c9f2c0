"""Claims about tyre property sets: sources, scaling, rolling radius against pressure, and bad input."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import pytest

from models.slip_coefficients import SLIP_NAMES
from models.tyre_properties import DEFAULT_TYRE, FOLDER, NUMBERS, TyreProperties, load_tyre, tyre_names
from testbed.tyre import vertical
from testbed.tyre.contact import residual_longitudinal_stiffness


def rolling_radius(tyre: TyreProperties, share: float = 1.0, load: float | None = None) -> float:
    """Re [m] at the reference speed and a share of the nominal pressure."""
    law = vertical.vertical_law(tyre)
    omega = tyre.v0 / (tyre.r0 * tyre.q_re0)
    return vertical.effective_rolling_radius(law, omega, load or tyre.fz0, share * tyre.p0)


# ---------------------------------------------------------------- property sets


@pytest.mark.parametrize("name", tyre_names())
def test_every_number_has_a_unit_and_a_source(name):
    groups = tomllib.loads((FOLDER / f"{name}.toml").read_text(encoding="utf-8"))
    entries = {key: entry for group in groups.values() for key, entry in group.items()}
    assert set(entries) == set(NUMBERS)
    for key, entry in entries.items():
        assert set(entry) == {"value", "unit", "source"}, key
        assert entry["source"].strip(), key
        assert entry["unit"].strip(), key


def test_default_tyre_is_the_suv_with_the_seeds_stiffness():
    tyre = load_tyre()
    assert tyre.name == DEFAULT_TYRE
    assert (tyre.cz0, tyre.p0) == (264700.0, 250e3)
    law = vertical.vertical_law(tyre)
    assert vertical.mean_stiffness(law, tyre.p0, 0.0, tyre.fz0) == pytest.approx(tyre.cz0, rel=1e-12)


def test_belt_stiffness_of_the_book_tyre_is_that_of_its_frequencies():
    book, rounding = load_tyre("book-205-60r15"), 1e-3  # three figures are published
    assert book.sidewall_stiffness == pytest.approx(1.704e6, rel=rounding)
    assert book.torsional_stiffness == pytest.approx(7.82e4, rel=rounding)
    assert 1.0 / (1.0 / book.cz0 - 1.0 / book.sidewall_stiffness) == pytest.approx(2.39e5, rel=rounding)
    residual_damping_ratio = book.torsional_damping / (2.0 * math.sqrt(book.torsional_stiffness * book.belt_iyy))
    assert residual_damping_ratio == pytest.approx(book.damp_windup, rel=1e-12)


def test_suv_tyre_is_the_book_tyre_scaled():
    book, suv = load_tyre("book-205-60r15"), load_tyre()
    published_to, length, stiffness = 1e-3, suv.r0 / book.r0, suv.cz0 / book.cz0
    assert suv.belt_mass / book.belt_mass == pytest.approx(stiffness, rel=5e-3)
    for name in ("belt_iyy", "belt_ixx"):
        ratio = getattr(suv, name) / getattr(book, name)
        assert ratio == pytest.approx(suv.belt_mass / book.belt_mass * length**2, rel=published_to)
    for name in ("cx", "cy"):
        assert getattr(suv, name) / getattr(book, name) == pytest.approx(stiffness, rel=published_to)
    same = [name for name in SLIP_NAMES if name not in ("fz0", "p0", "r0")]
    assert [getattr(suv, name) for name in same] == [getattr(book, name) for name in same]
    assert residual_longitudinal_stiffness(suv) > 0.0


def test_a_quarter_less_pressure_shrinks_the_default_rolling_radius_as_on_real_cars():
    tyre = load_tyre()
    change = rolling_radius(tyre, 0.75) / rolling_radius(tyre) - 1.0
    assert -0.0030 < change < -0.0020
    step = 1e-3
    slope = math.log(rolling_radius(tyre, 1.0 + step) / rolling_radius(tyre, 1.0 - step)) / (2.0 * step * tyre.p0)
    assert slope == pytest.approx(4e-5 / 1e3, rel=1e-3)  # measured on real cars: 3.5e-5 to 4.6e-5 per kPa


def test_book_rolling_radius_moves_with_pressure_and_load_as_published():
    book, rounding = load_tyre("book-205-60r15"), 6e-5  # two figures are published
    assert rolling_radius(book, 0.75) / rolling_radius(book) - 1.0 == pytest.approx(-0.0061, abs=rounding)
    loaded = rolling_radius(book, load=5000.0) / rolling_radius(book, load=3000.0) - 1.0
    assert loaded == pytest.approx(-0.003, abs=5e-4)


def test_slip_array_holds_the_coefficients_by_name():
    tyre = load_tyre()
    assert dict(zip(SLIP_NAMES, tyre.slip_array(), strict=True)) == {n: getattr(tyre, n) for n in SLIP_NAMES}


# ---------------------------------------------------------------- bad property sets


def changed_set(folder: Path, old: str, new: str) -> Path:
    """The default set with one piece of text replaced."""
    text = (FOLDER / f"{DEFAULT_TYRE}.toml").read_text(encoding="utf-8")
    assert text.count(old) == 1, old
    path = folder / "my.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


def refusal(path: str | Path) -> str:
    """The one line with which a tyre is refused."""
    with pytest.raises(ValueError, match=r"\S") as caught:
        load_tyre(path)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_unknown_tyre_is_refused_with_the_valid_names(tmp_path):
    for name in ("suv", str(tmp_path / "absent.tir"), str(tmp_path / "absent.toml"), ""):
        assert all(valid in refusal(name) for valid in tyre_names())


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("r0 = { value = 0.3696", "r0 = { value = -0.3696", "r0 = -0.3696 must be positive"),
        ("r0 = { value = 0.3696", "r0 = { value = nan", "r0 = nan"),
        ("r0 = { value = 0.3696", "r0 = { value = '0.37'", "r0 = '0.37' is not a number"),
        ("r0 = { value = 0.3696", "r0 = { value = 0.2", "rim_radius"),
        ("cz0 = { value", "cz00 = { value", "unknown cz00"),
        ('unit = "N/m", source = "S1, kt0 at p0"', 'unit = "N/m"', "cz0 must be"),
        ("S1, kt0 at p0", " ", "cz0 has no source"),
        ("carcass_fraction = { value = 0.04", "carcass_fraction = { value = 1.04", "between 0 and 1"),
        ("q_fz2 = { value = 15.4", "q_fz2 = { value = 1e9", "q_fz2"),
        ("[vertical]", "[vertical", "TOML"),
    ],
)
def test_faulty_property_set_is_refused_by_name(tmp_path, old, new, told):
    path = changed_set(tmp_path, old, new)
    message = refusal(path)
    assert str(path) in message
    assert told in message


def test_truncated_or_empty_property_set_is_refused(tmp_path):
    path = tmp_path / "my.toml"
    text = (FOLDER / f"{DEFAULT_TYRE}.toml").read_text(encoding="utf-8")
    path.write_text(text[: text.index("[heat]")], encoding="utf-8")
    assert "missing heat_capacity" in refusal(path)
    path.write_text("", encoding="utf-8")
    assert "missing" in refusal(path)
    path.write_bytes(b"\xff\xfe\x00")
    assert str(path) in refusal(path)
