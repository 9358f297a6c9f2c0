"""MDF4 logs (ASAM .mf4) of real cars as drive logs, through a column map whose columns are channel names.

`column_map.py` has the map's format; each channel brings its own clock. Needs the package asammdf, the extra `mdf` of
this project. Left out: text channels, and channels whose name occurs in several groups (they are refused).
"""

from __future__ import annotations

import gc
import struct
import sys
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from estimators.drive_log import DriveLog
from estimators.readers.column_map import ColumnMap, Samples, fitting_map, load_map, mapped_log


def read_mdf(path: str | Path, column_map: ColumnMap | Mapping[str, Any] | str | Path | None = None) -> DriveLog:
    """The log in an MDF file. Raises ValueError with one line if asammdf is missing or the file is no MDF."""
    path = Path(path)
    try:
        from asammdf import MDF
        from asammdf.blocks.utils import MdfException
    except ImportError:
        raise ValueError(
            f"{path}: reading .mf4 needs asammdf, install it with: pip install 'vehicle-testbed[mdf]'"
        ) from None
    damage = (MdfException, ValueError, KeyError, IndexError, TypeError, struct.error, zlib.error, OSError)
    mapping = load_map(column_map) if column_map is not None else None
    reason = ""
    with _quiet_destructors():
        try:
            file = MDF(path)
        except damage as error:
            reason = _line(error)
    if reason:
        raise ValueError(f"{path}: not a readable MDF4 log: {reason}")

    def samples(channel: str) -> Samples:
        try:
            found = file.get(channel)
            return found.timestamps * wanted.time_scale, np.asarray(found.samples, dtype=np.float64)
        except damage as error:
            raise ValueError(f"{path}: channel {channel!r}: {_line(error)}") from None

    with file:
        names = set(file.channels_db)
        wanted = mapping or fitting_map(path, names)
        if missing := sorted(wanted.columns - names - {wanted.time_column}):
            raise ValueError(f"{path}: no channel {missing[0]!r}, it has {', '.join(sorted(names)[:12])}")
        return mapped_log(path, wanted, samples)


@contextmanager
def _quiet_destructors() -> Iterator[None]:
    """A half-made MDF object complains on stderr when it is collected, whenever that is: now, and unheard."""
    hook, sys.unraisablehook = sys.unraisablehook, lambda _: None
    try:
        yield
    finally:
        gc.collect()
        sys.unraisablehook = hook


def _line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
