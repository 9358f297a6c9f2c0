"""What the columns of a foreign log mean: a column map turns them into SI signals with this project's names.

A map is a TOML file (or the same as a dict):

    title = "Mustang, decoded CAN log"     # optional, kept in the log's notes
    delimiter = ","                        # CSV only; default ","
    skip_lines = 0                         # CSV only: lines before the header; default 0

    [time]                                 # CSV needs it; MDF channels bring their own time
    column = "t_s"
    scale = 1.0                            # to seconds; default 1
    from_first = false                     # true: count from the first sample (its time goes to notes.time_origin_s)

    [car]                                  # optional: fields of estimators.car.Car, SI; the default car fills the rest
    driven_axle = "rear"

    [constants]                            # optional; kept in the notes
    wheel_radius_m = 0.34

    [signals."wheel/fl/speed"]             # the signal's name
    column = "fl_kmh"                      # or columns = ["ax", "ay", ""] for a vector, "" = not measured (NaN)
    scale = 0.2777777777777778             # default 1; signal = (column * scale + offset) / constants[per]
    offset = 0.0                           # default 0
    per = "wheel_radius_m"                 # optional: name of a constant
    unit = "rad/s"
    frame = ""                             # default ""

An empty cell means that this signal has no sample in that row; `nan` means that the sensor said so. Left out:
resampling, text columns, and anything the map does not name.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.car import Car
from estimators.drive_log import DriveLog, Signal

BUILT_IN = Path(__file__).with_name("maps")
Samples = tuple[NDArray[np.float64], NDArray[np.float64]]  # time [s] (n,), raw value (n,)


@dataclass(frozen=True)
class MappedSignal:
    """One signal's columns and its way to SI: (column * scale + offset) / per."""

    columns: tuple[str, ...]
    scale: float = 1.0
    offset: float = 0.0
    per: float = 1.0
    unit: str = ""
    frame: str = ""
    is_vector: bool = False


@dataclass(frozen=True)
class ColumnMap:
    """A parsed column map; `source` is the file or `column map` and opens every error."""

    signals: Mapping[str, MappedSignal]
    time_column: str = ""
    time_scale: float = 1.0
    from_first: bool = False
    delimiter: str = ","
    skip_lines: int = 0
    notes: Mapping[str, Any] = field(default_factory=dict)
    source: str = "column map"

    @property
    def columns(self) -> frozenset[str]:
        """Every column that the map reads."""
        named = {column for signal in self.signals.values() for column in signal.columns if column}
        return frozenset(named | ({self.time_column} if self.time_column else set()))


def load_map(source: ColumnMap | Mapping[str, Any] | str | Path) -> ColumnMap:
    """A column map from a TOML file, a built-in map's name, or a dict. Raises ValueError with one line."""
    if isinstance(source, ColumnMap):
        return source
    if isinstance(source, Mapping):
        return _parsed(source, "column map")
    path = Path(source)
    if path.suffix != ".toml":
        path = BUILT_IN / f"{source}.toml"
        if not path.is_file():
            raise ValueError(
                f"{source}: no such column map, want a .toml file or one of {', '.join(_built_in_names())}"
            )
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: cannot read the column map: {error.strerror}") from None
    except ValueError as error:  # TOML syntax or text encoding
        raise ValueError(f"{path}: not a TOML column map: {str(error).splitlines()[0]}") from None
    return _parsed(content, str(path))


def fitting_map(path: Path, columns: Iterable[str]) -> ColumnMap:
    """The built-in map whose columns are all there, time aside: an MDF channel brings its own. ValueError if none."""
    present = set(columns)
    for name in _built_in_names():
        candidate = load_map(name)
        if candidate.columns - {candidate.time_column} <= present:
            return candidate
    shown = ", ".join(sorted(present)[:8])
    raise ValueError(
        f"{path}: no built-in column map fits columns {shown}; give one (built in: {', '.join(_built_in_names())})"
    )


def _built_in_names() -> list[str]:
    return sorted(path.stem for path in BUILT_IN.glob("*.toml"))


def _parsed(content: Mapping[str, Any], source: str) -> ColumnMap:
    _known(content, {"title", "delimiter", "skip_lines", "time", "car", "constants", "signals"}, source)
    time, constants, signals = (_table(content, key, source) for key in ("time", "constants", "signals"))
    _known(time, {"column", "scale", "from_first"}, f"{source} [time]")
    if not signals:
        raise ValueError(f'{source}: no signals, want tables such as [signals."wheel/fl/speed"]')
    notes: dict[str, Any] = {"column_map": Path(source).stem, "constants": dict(constants)}
    if car := _table(content, "car", source):
        try:
            Car.from_notes({"car": car})
        except ValueError as error:
            raise ValueError(f"{source} [car]: {error}") from None
        notes["car"] = dict(car)
    return ColumnMap(
        signals={name: _mapped(name, _table(signals, name, source), constants, source) for name in signals},
        time_column=str(time.get("column", "")),
        time_scale=_number(time, "scale", 1.0, f"{source} [time]"),
        from_first=bool(time.get("from_first", False)),
        delimiter=str(content.get("delimiter", ",")),
        skip_lines=int(_number(content, "skip_lines", 0, source)),
        notes=notes | ({"title": str(content["title"])} if "title" in content else {}),
        source=source,
    )


def _mapped(name: str, table: Mapping[str, Any], constants: Mapping[str, Any], source: str) -> MappedSignal:
    where = f"{source} [signals.{name!r}]"
    _known(table, {"column", "columns", "scale", "offset", "per", "unit", "frame"}, where)
    columns = table.get("columns", [table["column"]] if "column" in table else [])
    if not isinstance(columns, list) or not any(columns) or not all(isinstance(c, str) for c in columns):
        raise ValueError(f'{where}: columns {columns!r}, want column = "name" or columns = ["x", "y", "z"]')
    per = table.get("per")
    if per is not None and per not in constants:
        raise ValueError(f"{where}: per {per!r} is no constant, want one of {', '.join(constants) or 'none given'}")
    return MappedSignal(
        columns=tuple(columns),
        scale=_number(table, "scale", 1.0, where),
        offset=_number(table, "offset", 0.0, where),
        per=_number(constants, per, 1.0, where) if per is not None else 1.0,
        unit=str(table.get("unit", "")),
        frame=str(table.get("frame", "")),
        is_vector="columns" in table,
    )


def _table(content: Mapping[str, Any], key: str, source: str) -> Mapping[str, Any]:
    table = content.get(key, {})
    if not isinstance(table, Mapping):
        raise ValueError(f"{source}: {key} is {table!r}, want a table")
    return table


def _number(table: Mapping[str, Any], key: str, default: float, where: str) -> float:
    value = table.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise ValueError(f"{where}: {key} is {value!r}, want a number")
    return float(value)


def _known(table: Mapping[str, Any], keys: set[str], where: str) -> None:
    if unknown := sorted(set(table) - keys):
        raise ValueError(f"{where}: unknown key {unknown[0]!r}, want {', '.join(sorted(keys))}")


def mapped_log(path: Path, mapping: ColumnMap, samples: Callable[[str], Samples]) -> DriveLog:
    """The drive log that a map makes of a file; `samples` gives a column's raw samples and their times.

    Raises ValueError with the path if the columns of one vector have different clocks, or a time is not finite.
    """
    raw = {column: samples(column) for column in sorted(mapping.columns - {mapping.time_column})}
    starts = [time[0] for time, _ in raw.values() if len(time)]
    origin = float(min(starts)) if mapping.from_first and starts else 0.0
    signals = {}
    for name, mapped in mapping.signals.items():
        measured = [raw[column] for column in mapped.columns if column]
        time = measured[0][0]
        if any(not np.array_equal(time, other) for other, _ in measured[1:]):
            raise ValueError(
                f"{path}: columns {', '.join(mapped.columns)} of {name} have different clocks, map them apart"
            )
        parts = [raw[c][1] if c else np.full(len(time), np.nan) for c in mapped.columns]
        value = (np.stack(parts, axis=1) if mapped.is_vector else parts[0]) * mapped.scale + mapped.offset
        try:
            signals[name] = Signal(time - origin, value / mapped.per, mapped.unit, mapped.frame)
        except ValueError as error:
            raise ValueError(f"{path}: {name}: {error}") from None
    notes = dict(mapping.notes) | {"file": path.name} | ({"time_origin_s": origin} if mapping.from_first else {})
    return DriveLog(signals, notes)
