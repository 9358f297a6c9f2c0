"""Tables of estimates: numbers as fine as they are known, units of the field, nothing wider than a terminal."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from estimators.estimate_table import estimate_tables, number, unit_shown


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (248.912, 2.31, "248.9±2.3"),
        (235.02, 11.4, "235±11"),
        (-5.31, 59.2, "-5±59"),
        (1.0, 0.0, "1"),
        (0.0123456, None, "0.01235"),
        (None, None, "-"),
        (2.0, float("inf"), "2"),
        (1e-16, 1e-8, "0.000000"),
    ],
)
def test_a_number_has_two_digits_of_its_deviation(value: float | None, std: float | None, text: str) -> None:
    assert number(value, std) == text


def test_units_are_those_of_the_field() -> None:
    assert unit_shown("fl/pressure", "Pa") == ("kPa", 1e-3)
    assert unit_shown("fl/pressure_change", "") == ("%", 100.0)
    assert unit_shown("fl/low_probability", "") == ("-", 1.0)
    assert unit_shown("fl/antiphase_frequency", "Hz") == ("Hz", 1.0)


def test_wheels_stand_side_by_side_and_the_car_below_within_80_columns() -> None:
    def entry(value: float, std: float, unit: str) -> dict[str, object]:
        return {"value": value, "std": std, "unit": unit}

    wheels = {f"{w}/relative_pressure_change": entry(-5310.0, 59200.0, "Pa") for w in ("fl", "fr", "rr")}
    said = {"wheel_radius": wheels | {"delta12": entry(1e-4, 4e-4, "")}, "vibration": {}}
    out = io.StringIO()
    for table in estimate_tables(said, "at the end"):
        Console(file=out, width=80).print(table)
    text = out.getvalue()
    assert max(len(line.rstrip()) for line in text.splitlines()) <= 80
    (row,) = [line for line in text.splitlines() if line.strip().startswith("relative pressure")]
    assert row.split() == ["relative", "pressure", "change", "-5±59", "-5±59", "-", "-5±59"]
    assert "delta12 (%)" in text
    assert "0.010±0.040" in text
    assert "vibration" not in text
