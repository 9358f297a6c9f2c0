"""The drive log: everything a drive's sensors said, each signal on its own clock.

A log maps names to signals. Names are paths (`wheel/fl/speed`) and become Rerun entities unchanged. Wheels are always
named fl, fr, rl, rr. Signals of the car's bus come first; `truth/...` is what a simulator knows and an estimator may
not read; `est/METHOD/...` (with `/std` beside it) and `alarm/METHOD` are what estimators said.

Times are seconds on a grid of one nanosecond, which a double holds exactly enough to survive a file unchanged for 50
days.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

WHEELS = ("fl", "fr", "rl", "rr")
HIDDEN = "truth/"  # names that begin so are kept from every estimator


@dataclass(frozen=True, eq=False)
class Signal:
    """Samples of one quantity.

    time: [s], shape (n,), finite; rounded to whole nanoseconds. Order is as recorded: a late sample stays where it
    came. value: shape (n,) or (n, k), float64 (NaN: the sensor said so) ; text signals (alarms) hold str objects, shape
    (n,). unit: SI, "" for a ratio or a count. frame: where a vector is expressed, "" if scalar.
    Arrays are copied in and read-only.
    """

    time: NDArray[np.float64]
    value: NDArray[Any]
    unit: str = ""
    frame: str = ""

    def __init__(self, time: ArrayLike, value: ArrayLike, unit: str = "", frame: str = "") -> None:
        seconds = np.array(time, dtype=np.float64).reshape(-1)
        if not np.isfinite(seconds).all():
            raise ValueError(f"time holds {seconds[~np.isfinite(seconds)][0]}: every sample needs a finite time [s]")
        values = np.array(value)
        values = values.astype(object) if values.dtype.kind in "UO" else values.astype(np.float64)
        if values.ndim not in (1, 2) or len(values) != len(seconds):
            raise ValueError(
                f"value has shape {values.shape}, want ({len(seconds)},) or ({len(seconds)}, k) as time has"
            )
        seconds = np.rint(seconds * 1e9) / 1e9 + 0.0  # no negative zero
        seconds.flags.writeable = values.flags.writeable = False
        for name, content in (("time", seconds), ("value", values), ("unit", unit), ("frame", frame)):
            object.__setattr__(self, name, content)

    def __len__(self) -> int:
        return len(self.time)

    def __eq__(self, other: object) -> bool:
        """Equal to the last bit, NaN equal to NaN."""
        if not isinstance(other, Signal):
            return NotImplemented
        same_kind = (self.unit, self.frame, self.value.dtype, self.value.shape) == (
            other.unit,
            other.frame,
            other.value.dtype,
            other.value.shape,
        )
        return same_kind and self.time.tobytes() == other.time.tobytes() and _same(self.value, other.value)

    __hash__ = None  # type: ignore[assignment]

    def between(self, start: float, end: float) -> Signal:
        """Samples with start <= time < end [s], order kept."""
        inside = (self.time >= start) & (self.time < end)
        return Signal(self.time[inside], self.value[inside], self.unit, self.frame)


def _same(a: NDArray[Any], b: NDArray[Any]) -> bool:
    return bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))


@dataclass(frozen=True)
class DriveLog(Mapping[str, Signal]):
    """Signals by name, and notes: scenario, versions, seed, the car as its maker would describe it (JSON values
    only)."""

    signals: Mapping[str, Signal]
    notes: Mapping[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Signal:
        try:
            return self.signals[name]
        except KeyError:
            raise KeyError(f"no signal {name!r} in this log; it has {', '.join(sorted(self.signals))}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.signals)

    def __len__(self) -> int:
        return len(self.signals)

    @property
    def span(self) -> tuple[float, float]:
        """First and last time of any sample [s]; (0, 0) of an empty log."""
        ends = [(s.time.min(), s.time.max()) for s in self.signals.values() if len(s)]
        return (float(min(e[0] for e in ends)), float(max(e[1] for e in ends))) if ends else (0.0, 0.0)

    def visible(self) -> DriveLog:
        """The log as an estimator may see it: nothing under `truth/`, no earlier estimates or alarms, and of the notes
        the car alone: a scenario tells the true pressures."""
        kept = {n: s for n, s in self.signals.items() if not n.startswith((HIDDEN, "est/", "alarm/"))}
        return DriveLog(kept, {name: note for name, note in self.notes.items() if name == "car"})
