"""The `.tir` text format: sections, KEY = value lines, comments, tables and units, read into SI numbers.

    [UNITS]                                     $ a comment
    LENGTH   = 'mm'
    [VERTICAL]
    FNOMIN   = 4.0e3    ! another

A comment starts with `$` or `!` outside quotes. Rows of numbers or of {column names} belong to tables,
which are skipped. A number given twice must be the same. Units: LENGTH, FORCE, MASS, TIME, PRESSURE apply to the keys
of QUANTITY; ANGLE applies to ranges of validity alone, since the coefficients are defined in radians.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

UNITS: dict[str, dict[str, float]] = {
    "LENGTH": {"meter": 1.0, "m": 1.0, "mm": 1e-3, "millimeter": 1e-3, "cm": 1e-2, "centimeter": 1e-2, "km": 1e3,
               "kilometer": 1e3, "inch": 0.0254, "in": 0.0254, "foot": 0.3048, "ft": 0.3048, "mile": 1609.344},
    "FORCE": {"newton": 1.0, "n": 1.0, "kilonewton": 1e3, "kn": 1e3, "kg_force": 9.80665, "kilogram_force": 9.80665,
              "pound_force": 4.4482216, "lbf": 4.4482216, "dyne": 1e-5},
    "ANGLE": {"radians": 1.0, "radian": 1.0, "rad": 1.0, "degrees": math.pi / 180.0, "degree": math.pi / 180.0,
              "deg": math.pi / 180.0},
    "MASS": {"kg": 1.0, "kilogram": 1.0, "gram": 1e-3, "g": 1e-3, "pound_mass": 0.45359237, "lbm": 0.45359237,
             "slug": 14.593903, "tonne": 1e3},
    "TIME": {"second": 1.0, "sec": 1.0, "s": 1.0, "millisecond": 1e-3, "ms": 1e-3, "minute": 60.0, "min": 60.0,
             "hour": 3600.0, "h": 3600.0},
    "PRESSURE": {"pascal": 1.0, "pa": 1.0, "kpa": 1e3, "kilopascal": 1e3, "mpa": 1e6, "megapascal": 1e6, "bar": 1e5,
                 "psi": 6894.757},
}  # fmt: skip

# Powers of the units in every key that carries one; all other numbers are taken as they stand.
QUANTITY: dict[str, dict[str, int]] = {
    "UNLOADED_RADIUS": {"LENGTH": 1}, "WIDTH": {"LENGTH": 1}, "RIM_RADIUS": {"LENGTH": 1}, "RIM_WIDTH": {"LENGTH": 1},
    "BOTTOM_OFFST": {"LENGTH": 1}, "LONGVL": {"LENGTH": 1, "TIME": -1}, "FNOMIN": {"FORCE": 1},
    "VERTICAL_STIFFNESS": {"FORCE": 1, "LENGTH": -1}, "LONGITUDINAL_STIFFNESS": {"FORCE": 1, "LENGTH": -1},
    "LATERAL_STIFFNESS": {"FORCE": 1, "LENGTH": -1}, "BOTTOM_STIFF": {"FORCE": 1, "LENGTH": -1},
    "BELT_MASS": {"MASS": 1}, "BELT_IXX": {"MASS": 1, "LENGTH": 2}, "BELT_IYY": {"MASS": 1, "LENGTH": 2},
    "NOMPRES": {"PRESSURE": 1}, "INFLPRES": {"PRESSURE": 1}, "IP_NOM": {"PRESSURE": 1}, "IP": {"PRESSURE": 1},
    "PRESMIN": {"PRESSURE": 1}, "PRESMAX": {"PRESSURE": 1},
}  # fmt: skip

_LINE = re.compile(r"""^(?P<key>[A-Za-z]\w*)\s*=\s*(?P<value>'[^']*'|"[^"]*"|[^\s$!]*)\s*(?P<rest>.*)$""")
_TABLE_ROW = re.compile(r"^(\{.*\}?|[-+.\d][-+.\deEdD\s,]*)$")


@dataclass(frozen=True)
class TirFile:
    """A property file's numbers in SI and its texts, both by upper-case key."""

    path: Path
    numbers: dict[str, float]
    texts: dict[str, str]
    sections: tuple[str, ...]

    def text(self, key: str) -> str:
        """The text of `key` in upper case, empty where the file has none."""
        return self.texts.get(key, "").upper()


def read_tir_file(path: str | Path) -> TirFile:
    """Read a `.tir` file. ValueError of one line with path (and line number) if it is no such file."""
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}") from None
    if not content.strip():
        raise ValueError(f"{path}: is empty")
    if b"\0" in content:
        raise ValueError(f"{path}: is not a text file")
    numbers: dict[str, float] = {}
    texts: dict[str, str] = {}
    sections: list[str] = []
    for count, line in enumerate(re.split(r"\r\n|\r|\n", content.decode("latin-1")), start=1):
        line = line.strip()
        if not line or line[0] in "$!":
            continue
        if line.startswith("["):
            name, bracket, _ = line[1:].partition("]")
            if not bracket:
                raise ValueError(f"{path}, line {count}: section {line!r} has no closing bracket")
            sections.append(name.strip().upper())
            continue
        if _TABLE_ROW.match(re.split(r"[$!]", line)[0].strip()):
            continue
        _read_key(line, f"{path}, line {count}", numbers, texts)
    if not sections:
        raise ValueError(f"{path}: has no section such as [UNITS]; it is not a tyre property file")
    return TirFile(path, _in_si(path, numbers, texts), texts, tuple(sections))


def _read_key(line: str, where: str, numbers: dict[str, float], texts: dict[str, str]) -> None:
    """Put the key of one line into `numbers` or `texts`."""
    match = _LINE.match(line)
    if match is None:
        raise ValueError(f"{where}: {line[:60]!r} is neither KEY = value, [SECTION], table row nor comment")
    key, value, rest = match["key"].upper(), match["value"], match["rest"]
    if value[:1] in ("'", '"') and len(value) >= 2:
        texts[key] = value[1:-1].strip()
        return
    if rest and rest[0] not in "$!":
        texts[key] = f"{value} {rest}"
        return
    try:
        number = float(value.replace("D", "e").replace("d", "e"))
    except ValueError:
        texts[key] = value
        return
    if not math.isfinite(number):
        raise ValueError(f"{where}: {key} = {value} is not a finite number")
    if numbers.get(key, number) != number:
        raise ValueError(f"{where}: {key} = {value} was {numbers[key]} before")
    numbers[key] = number


def _in_si(path: Path, numbers: dict[str, float], texts: dict[str, str]) -> dict[str, float]:
    """The numbers with the file's units applied."""
    factor = {}
    for unit, names in UNITS.items():
        name = texts.get(unit, "").lower()
        if name and name not in names:
            raise ValueError(f"{path}: unit {unit} = {name!r} is unknown; valid: {', '.join(names)}")
        factor[unit] = names[name] if name else 1.0
    scale = {
        key: math.prod(factor[unit] ** power for unit, power in powers.items()) for key, powers in QUANTITY.items()
    }
    return {key: value * scale.get(key, 1.0) for key, value in numbers.items()}
