"""Who is accused, since when and how surely, from the alarms of both watches, cell by cell.

    servo    pinion   accused
    alarm    -        motor: does not do what is demanded
    -        alarm    angles: pinion, steering wheel and motor contradict one another
    alarm    alarm    motor angle: its sensor, where both errors are of one size; else motor and angles

An accusation is told once, and ends BACK after the last alarm. Where the pinion is not heard the first row cannot tell
the motor from its sensor, and says so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from estimators.estimator import Alarm, Flag
from estimators.grid import LATENCY
from estimators.steering_actuator.residuals import STEP
from estimators.steering_actuator.watching import BACK, Told

SERVO, PINION = 0, 1
ALIKE, SURE = 0.2, 3.0  # of two sizes: relative, in standard deviations
TEXTS = {
    "": "steering actuator agrees again",
    "motor": "motor does not do what is demanded",
    "motor or its angle": "motor does not do what is demanded, or its angle sensor errs",
    "angles": "angles of pinion, steering wheel and motor contradict one another",
    "motor angle": "motor angle sensor errs",
    "motor and angles": "motor does not do what is demanded, and angles contradict one another",
}


@dataclass
class _Side:
    first: Told
    last: Told


class Accusation:
    """rate: false alarms an hour, to be told."""

    def __init__(self, rate: float) -> None:
        self._rate = f"false alarms: one in {1.0 / rate:g} h"
        self._sides: list[_Side | None] = [None, None]
        self._told: set[str] = set()  # of this accusation
        self.who = ""

    def take(self, told: list[tuple[int, Told]], end: int, heard: int | None) -> tuple[list[Alarm], list[Flag]]:
        """told: (SERVO or PINION, alarm) in order of cells; end: cell before which all is known; heard:
        cell from which on the pinion is."""
        alarms, flags = list[Alarm](), list[Flag]()
        for side, alarm in told:
            flags += self._expire(alarm.cell)
            known = self._sides[side]
            self._sides[side] = _Side(known.first if known else alarm, alarm)
            alarms += self._accuse(alarm.cell, heard is not None and heard <= alarm.cell)
        return alarms, flags + self._expire(end)

    def _accuse(self, cell: int, pinion_heard: bool) -> list[Alarm]:
        self.who = who = self._culprit(pinion_heard)
        if who in self._told:
            return []
        self._told.add(who)
        side = self._sides[SERVO] or self._sides[PINION]
        assert side is not None
        since = min(s.first.since for s in self._sides if s) * STEP
        off = "it is unsteady"
        if _sized(side.last):
            off = f"by {np.degrees(side.last.size):+.1f} deg (std {np.degrees(side.last.std):.1f})"
        return [Alarm(_clock(cell), f"{TEXTS[who]}, {off}, since {since:.2f} s; {self._rate}")]

    def _culprit(self, pinion_heard: bool) -> str:
        servo, pinion = self._sides
        if servo and pinion:
            a, b = servo.last, pinion.last
            if not (_sized(a) and _sized(b)):
                return "motor angle"
            apart = abs(a.size - b.size)
            alike = apart <= SURE * np.hypot(a.std, b.std) + ALIKE * max(abs(a.size), abs(b.size))
            return "motor angle" if alike else "motor and angles"
        if servo:
            return "motor" if pinion_heard else "motor or its angle"
        return "angles" if pinion else ""

    def _expire(self, cell: int) -> list[Flag]:
        """What ends before a cell."""
        flags = list[Flag]()
        for i in sorted((SERVO, PINION), key=lambda i: s.last.cell if (s := self._sides[i]) else 0):
            side = self._sides[i]
            if side is not None and side.last.cell + BACK < cell:
                self._sides[i] = None
                if self._sides == [None, None]:
                    self.who = ""
                    self._told.clear()
                    flags.append(Flag(_clock(side.last.cell + BACK), TEXTS[""]))
        return flags


def _sized(told: Told) -> bool:
    """Whether the error has a mean, and is not only unsteady."""
    return bool(abs(told.size) > SURE * told.std)


def _clock(cell: int) -> float:
    """When a cell is told [s]."""
    return (cell + 1) * STEP + LATENCY
