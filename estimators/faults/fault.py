"""A fault as it is typed: `SENSOR=KIND[:NUMBER[,NUMBER]][@FROM[-TO]]`.

    imu/accel/x=bias:0.3@30-60      0.3 m/s^2 too much from 30 s to 60 s
    wheel/rr=stuck@30               from 30 s on the wheel's sensor stays at its last speed
    wheel/fl=swap                   all the time; left and right exchanged

Numbers are in the unit that `targets.py` gives the sensor, times in seconds of the log's clock.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from estimators.faults.kind import SIGNAL, SIGNAL_RATE, Kind, Number, find_kind
from estimators.faults.targets import Target, find_target

FORM = "SENSOR=KIND[:NUMBERS][@FROM[-TO]], such as imu/accel/x=bias:0.3@30-60"
_TIME = r"\d+\.?\d*(?:[eE][+-]?\d+)?"
_FAULT = re.compile(rf"([^=]+)=([^:@]+)(?::([^@]*))?(?:@({_TIME})(?:-({_TIME}))?)?")


@dataclass(frozen=True)
class Fault:
    """text: as typed. numbers: SI. From start to end [s]."""

    text: str
    target: Target
    kind: type[Kind]
    numbers: tuple[float, ...]
    start: float
    end: float

    @property
    def what(self) -> str:
        """Kind and numbers as typed."""
        return self.text.partition("=")[2].partition("@")[0]


def parse_fault(text: str) -> Fault:
    """ValueError in one line names what is wrong and what is valid."""
    if not isinstance(text, str) or not (match := _FAULT.fullmatch(text.strip())):
        raise ValueError(f"fault {text!r}: want {FORM}")
    name, word, numbers, begin, finish = match.groups()
    try:
        target, kind = find_target(name), find_kind(word)
        given = _numbers(kind, target, numbers)
        if target.column is not None and kind.whole:
            raise ValueError(f"{kind.name} acts on whole messages; valid: {target.signals[0]}")
        if kind.wheels_only and not target.turns:
            raise ValueError(f"{kind.name} is of a wheel's ring; valid: wheel/WHEEL")
        if kind.name == "swap" and not target.wheel:
            raise ValueError(f"{target.name} has no other side; valid: a sensor of a wheel")
    except ValueError as error:
        raise ValueError(f"fault {text!r}: {error}") from None
    start, end = float(begin or 0.0), float(finish) if finish else math.inf
    if not start < end:
        raise ValueError(f"fault {text!r}: ends at {end:g} s, valid: after its start at {start:g} s")
    return Fault(text.strip(), target, kind, given, start, end)


def _numbers(kind: type[Kind], target: Target, text: str | None) -> tuple[float, ...]:
    """In SI."""
    words = text.split(",") if text is not None else []
    least = sum(number.default is None for number in kind.numbers)
    if not least <= len(words) <= len(kind.numbers):
        form = kind.name + (":" + ",".join(number.name for number in kind.numbers) if kind.numbers else "")
        raise ValueError(f"{len(words)} numbers; valid: {form}")
    typed = [_number(number, target, word) for number, word in zip(kind.numbers, words, strict=False)]
    typed += [number.default for number in kind.numbers[len(words) :] if number.default is not None]
    scales = [target.scale if number.unit in (SIGNAL, SIGNAL_RATE) else 1.0 for number in kind.numbers]
    return tuple(value * scale for value, scale in zip(typed, scales, strict=True))


def _number(number: Number, target: Target, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not number.low <= value <= number.high:
        unit = number.unit.replace(SIGNAL, target.unit)
        raise ValueError(f"{number.name} {word!r}; valid: {number.low:g} to {number.high:g} {unit}".rstrip())
    return value
