"""Files that become drive logs: recordings (.rrd), and logs of real cars (.csv, .mf4) through a column map.

This package is the one place in `estimators` that needs more than numpy; each format's library is imported when used.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from estimators.drive_log import DriveLog
from estimators.readers.column_map import ColumnMap

KINDS = (".rrd", ".csv", ".mf4")


def read_log(path: str | Path, column_map: ColumnMap | Mapping[str, Any] | str | Path | None = None) -> DriveLog:
    """The drive log in a file, whatever its kind; the suffix (any case) decides.

    path: `.rrd` (also one that a killed drive left behind), `.csv` or `.mf4`.
    column_map: what the columns of a CSV or MDF file mean, see `column_map.py`; None picks the built-in map that fits.
    Raises ValueError with one line that names the path: file absent, of unknown kind, empty, malformed or cut short.
    """
    path = Path(path)
    suffix = next((s for s in reversed(path.suffixes) if s != ".part"), "").lower()
    if suffix not in KINDS:
        raise ValueError(f"{path}: unknown kind of log {suffix!r}, want one of {', '.join(KINDS)}")
    if not path.is_file():
        raise ValueError(f"{path}: no such log, want a file that ends in {', '.join(KINDS)}")
    if path.stat().st_size == 0:
        raise ValueError(f"{path}: empty file, want a {suffix} log")
    if suffix == ".rrd":
        from estimators.readers.rrd import read_rrd

        if column_map is not None:
            raise ValueError(f"{path}: a recording names its own signals, a column map is for .csv and .mf4")
        return read_rrd(path)
    if suffix == ".csv":
        from estimators.readers.csv import read_csv

        return read_csv(path, column_map)
    from estimators.readers.mdf import read_mdf

    return read_mdf(path, column_map)
