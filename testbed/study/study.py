"""What a study is: runs of some work, and the figures that they come to.

One file (or package) in this folder adds a study: a subclass of `Study` with a name is found by itself. A study names
its tasks (JSON values) and a module's function that turns a task into a row (JSON values); where and how often the work
runs, what of it is finished already, and how the figures are shown is not its business.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from estimators.scores.interval import Interval

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Task = dict[str, Any]
Row = dict[str, Any]


@dataclass(frozen=True)
class StudyRow:
    """A figure. unit: as printed, "-" for none; paper: what the paper says; here: what was measured; ci95: its 95 %
    interval; limit: what physics or the design allows. None where there is none."""

    name: str
    unit: str
    paper: float | None = None
    here: float | None = None
    ci95: tuple[float, float] | None = None
    limit: float | None = None

    @classmethod
    def of(
        cls, name: str, unit: str, here: Interval | None, paper: float | None = None, limit: float | None = None,
        scale: float = 1.0,
    ) -> StudyRow:  # fmt: skip
        """The row of a figure with its interval, both times `scale` (above 0); None: nothing was measured."""
        if here is None:
            return cls(name, unit, paper, None, None, limit)
        return cls(name, unit, paper, scale * here.value, (scale * here.low, scale * here.high), limit)

    def as_json(self) -> dict[str, Any]:
        """JSON values; what is not finite is null, an interval with one such end keeps the other."""
        ends = None if self.ci95 is None else [_finite(end) for end in self.ci95]
        return {
            "name": self.name,
            "unit": self.unit,
            "paper": _finite(self.paper),
            "here": _finite(self.here),
            "ci95": None if ends in (None, [None, None]) else ends,
            "limit": _finite(self.limit),
        }


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


class Study(ABC):
    """name: as typed; about: its question in one line; paper: what it reproduces or rests on; runs: repetitions when
    none are asked for, which two cores finish within 30 minutes; data: the measured data that it reads, if any, which
    need not be there (its tasks then raise ValueError)."""

    name: str
    about: str
    paper: str
    runs: int
    data: Path | None = None

    @property
    @abstractmethod
    def work(self) -> Callable[[Task], Row]:
        """A module's function, so that another process can call it."""

    @abstractmethod
    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        """The tasks of the first `runs` repetitions. A repetition's tasks depend on its number and the seed alone, so
        that more repetitions begin with the same ones. small: fewer or shorter ones, seconds for each repetition, for a
        first look and the tests; the table may then lack figures."""

    @abstractmethod
    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        """The figures that finished rows come to; `rows` has those without an error, in the order of the tasks."""

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        """Pictures by file name without ending."""
        return {}

    def pages(self, rows: Sequence[Row]) -> Mapping[str, str]:
        """HTML pages by file name without ending."""
        return {}

    def printed(self, table: Sequence[StudyRow]) -> list[StudyRow]:
        """The rows of the table that are printed; the JSON has all."""
        return list(table)

    def objections(self, rows: Sequence[Row]) -> list[str]:
        """Lines on what is not as it should be; none where all is well, or the study expects nothing."""
        return []


def run_seed(seed: int, number: int, purpose: int = 0) -> int:
    """Seed of repetition `number`: repetitions and studies' seeds that follow one another have nothing in common, nor
    have the drives of different purposes."""
    return int(np.random.SeedSequence((seed, number, purpose)).generate_state(1)[0])
