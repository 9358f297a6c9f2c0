"""Values of a campaign file that differ from drive to drive.

    { sweep = [50, 80] }             each value in turn: all sweeps of a file make a grid
    { choice = ["A", "B"] }          drawn for each drive, each value equally likely
    { uniform = [180, 250] }         drawn between two limits
    { log_uniform = [8e-6, 5e-4] }   the same in the logarithm
    { normal = [250, 5] }            drawn with mean and standard deviation

A draw depends on the campaign's seed, the drive's number and the field's name alone, so a field more leaves the
others' draws as they were.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

SWEEP = "sweep"
_DRAWS = {
    "choice": lambda rng, values: values[int(rng.integers(len(values)))],
    "uniform": lambda rng, limits: float(rng.uniform(*limits)),
    "log_uniform": lambda rng, limits: float(np.exp(rng.uniform(*np.log(limits)))),
    "normal": lambda rng, moments: float(rng.normal(*moments)),
}
KINDS = (SWEEP, *_DRAWS)


def is_distribution(value: Any) -> bool:
    """Whether a value of the file is one of KINDS (and not a plain table)."""
    return isinstance(value, Mapping) and len(value) == 1 and next(iter(value)) in KINDS


def check(name: str, value: Mapping[str, Any]) -> None:
    """ValueError names a distribution that makes no sense, and what would."""
    ((kind, numbers),) = value.items()
    if not isinstance(numbers, list) or not numbers:
        raise ValueError(f"{name}: {kind} = {numbers!r}, want a list of values")
    if kind in (SWEEP, "choice"):
        if len({_kind(value) for value in numbers}) > 1:
            raise ValueError(f"{name}: {kind} = {numbers!r}, want values of one kind: numbers, texts, tables or lists")
        return
    fits = len(numbers) == 2 and all(
        isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v) for v in numbers
    )
    if not fits:
        raise ValueError(f"{name}: {kind} = {numbers!r}, want two finite numbers")
    low, high = numbers
    if kind == "normal" and high < 0.0:
        raise ValueError(f"{name}: normal = {numbers!r}, want a standard deviation of 0 or more as second number")
    if kind != "normal" and low > high:
        raise ValueError(f"{name}: {kind} = {numbers!r}, want the lower limit first")
    if kind == "log_uniform" and low <= 0.0:
        raise ValueError(f"{name}: log_uniform = {numbers!r}, want limits above 0")


def _kind(value: Any) -> type:
    return float if isinstance(value, int | float) and not isinstance(value, bool) else type(value)


def leaves(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted name and value of each distribution, and of all else, in nested tables."""
    for key, value in table.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping) and not is_distribution(value):
            yield from leaves(value, f"{name}.")
        else:
            yield name, value


def draw(seed: int, number: int, name: str, value: Mapping[str, Any]) -> Any:
    """The value of a drawn field in the drive of that number."""
    ((kind, numbers),) = value.items()
    field = int.from_bytes(hashlib.sha256(name.encode()).digest()[:8], "big")
    return _DRAWS[kind](np.random.default_rng((seed, number, field)), numbers)


def filled(table: Mapping[str, Any], values: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """The table with its distributions replaced by their values, by dotted name."""
    out: dict[str, Any] = {}
    for key, value in table.items():
        name = f"{prefix}{key}"
        if is_distribution(value):
            out[key] = values[name]
        elif isinstance(value, Mapping):
            out[key] = filled(value, values, f"{name}.")
        else:
            out[key] = value
    return out
