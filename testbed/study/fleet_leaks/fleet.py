"""A fleet's record from a Parquet file: columns `mongoID` (vehicle), `timestamp` (ISO 8601, UTC) and `pressure_*` (one
a tyre, bar, at one temperature).

Vehicles and tyres without a pressure are left out. A vehicle is named by the first characters of its identifier that
tell it from the others, a tyre by its column's ending. The estimator's numbers were chosen on the vehicles `TUNED_ON`.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from estimators.slow_leak.days import Days, days_of, together

BAR = 1e5  # Pa
VEHICLE, TIME, PRESSURE = "mongoID", "timestamp", "pressure_"
NAME_LENGTH = 8
TUNED_ON = ("638eed8b", "64218239", "66f2dd6d", "66f67679")


@dataclass(frozen=True, eq=False)
class Trailer:
    """name; tyres: names; time: [s] since 1970, shape (n,); pressure: gauge [Pa], shape (n, tyres), NaN where none."""

    name: str
    tyres: tuple[str, ...]
    time: NDArray[np.float64]
    pressure: NDArray[np.float64]

    @property
    def tuning(self) -> bool:
        """Whether the estimator's numbers were chosen on it."""
        return self.name in TUNED_ON

    def tyre_days(self, tyre: int) -> Days:
        """Of one tyre, by column."""
        return days_of(self.time, self.pressure[:, tyre])

    def days(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Day numbers since 1970, shape (n,), and days' values [Pa], shape (n, tyres)."""
        return together([self.tyre_days(tyre) for tyre in range(len(self.tyres))])


def check_fleet(file: Path) -> None:
    """ValueError in one line if the file is absent or not such a record."""
    if not file.is_file():
        raise ValueError(f"no fleet record {file}: name the Parquet file with --data FILE")
    try:
        names = pq.read_schema(file).names
    except (pa.ArrowInvalid, OSError) as error:
        raise ValueError(f"{file} is not a Parquet file ({str(error).splitlines()[0]})") from None
    missing = [n for n in (VEHICLE, TIME) if n not in names]
    if missing or not any(n.startswith(PRESSURE) for n in names):
        raise ValueError(
            f"{file} has the columns {', '.join(names)}; want {VEHICLE}, {TIME} and at least one {PRESSURE}NAME"
        )


def digest(file: Path) -> str:
    """Of the file's content: results of another one are not taken up again."""
    return hashlib.sha256(file.read_bytes()).hexdigest()[:16]


@lru_cache(maxsize=2)
def read_fleet(file: Path) -> tuple[Trailer, ...]:
    """The vehicles with pressures, by name. ValueError as of `check_fleet`, or if a column cannot be read."""
    check_fleet(file)
    try:
        table = pq.read_table(file)
        vehicle = np.array(table[VEHICLE].to_pylist(), dtype=object)
        text = np.array([str(stamp)[:19].replace(" ", "T") for stamp in table[TIME].to_pylist()], dtype="U19")
        stamps = text.astype("datetime64[s]").astype(np.int64).astype(np.float64)
        columns = [n for n in table.column_names if n.startswith(PRESSURE)]
        bar = np.stack([np.array(table[n].to_pylist(), dtype=np.float64) for n in columns], axis=1)
    except (pa.ArrowInvalid, OSError, TypeError, ValueError) as error:
        raise ValueError(f"{file} cannot be read as a fleet record ({str(error).splitlines()[0]})") from None
    found = []
    for name in sorted({str(v) for v in vehicle}):
        rows = vehicle.astype(str) == name
        known = np.isfinite(bar[rows]).any(axis=0)
        if known.any():
            tyres = tuple(n.removeprefix(PRESSURE) for n, k in zip(columns, known, strict=True) if k)
            found.append(Trailer(name, tyres, stamps[rows], BAR * bar[rows][:, known]))
    if not found:
        raise ValueError(f"{file} holds no pressure of any vehicle")
    length = NAME_LENGTH
    while len({t.name[:length] for t in found}) < len(found):
        length += 1
    return tuple(Trailer(t.name[:length], t.tyres, t.time, t.pressure) for t in found)
