"""CSV logs of real cars as drive logs, through a column map (`column_map.py` has its format).

One header line names the columns, every further line is one instant. Raises ValueError with one line that names the
path, the line and the cell. Left out: quoted line breaks, and more than one header line (`skip_lines` passes over what
precedes it).
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from estimators.drive_log import DriveLog
from estimators.readers.column_map import ColumnMap, Samples, fitting_map, load_map, mapped_log


def read_csv(path: str | Path, column_map: ColumnMap | Mapping[str, Any] | str | Path | None = None) -> DriveLog:
    """The log in a CSV file. column_map: a map, its TOML file or name; None picks the built-in map that fits."""
    path = Path(path)
    mapping = load_map(column_map) if column_map is not None else None
    lines = _lines(path)
    skipped = mapping.skip_lines if mapping else 0
    rows = [row for row in csv.reader(lines[skipped:], delimiter=mapping.delimiter if mapping else ",") if row]
    if not rows:
        raise ValueError(f"{path}: empty CSV log, want a header line and samples")
    header = [cell.strip() for cell in rows.pop(0)]
    if mapping is None:
        mapping = fitting_map(path, header)
    if not mapping.time_column:
        raise ValueError(f"{mapping.source}: no time column, a CSV log needs [time] column")
    if missing := sorted(mapping.columns - set(header)):
        raise ValueError(f"{path}: no column {missing[0]!r}, it has {', '.join(header)}")
    if not rows:
        raise ValueError(f"{path}: a header but no samples")
    for number, row in enumerate(rows, start=skipped + 2):
        if len(row) != len(header):
            raise ValueError(
                f"{path}: line {number} has {len(row)} cells, the header {len(header)}: cut short or malformed"
            )
    cells = dict(zip(header, zip(*rows, strict=True), strict=True))
    numbers = {c: _numbers(cells[c], f"{path}: column {c!r}", skipped + 2) for c in mapping.columns}
    time, timed = numbers[mapping.time_column]
    if not timed.all():
        raise ValueError(f"{path}: line {skipped + 2 + int(np.argmin(timed))} has no time in {mapping.time_column!r}")
    if len(time) > 1 and not time[-1] > time[0]:
        raise ValueError(
            f"{path}: {mapping.time_column!r} runs from {time[0]:g} to {time[-1]:g}, want time that goes forward"
        )

    def samples(column: str) -> Samples:
        value, present = numbers[column]
        return time[present] * mapping.time_scale, value[present]

    return mapped_log(path, mapping, samples)


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise ValueError(f"{path}: cannot read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a CSV log: it is not text") from None


def _numbers(cells: tuple[str, ...], where: str, first_line: int) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Cells as numbers (NaN where empty), and which were not empty."""
    present = np.array([bool(cell.strip()) for cell in cells])
    value = np.full(len(cells), np.nan)
    for index, cell in enumerate(cells):
        if present[index]:
            try:
                value[index] = float(cell)
            except ValueError:
                raise ValueError(f"{where}, line {first_line + index}: {cell!r} is not a number") from None
    return value, present
