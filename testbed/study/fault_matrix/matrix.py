"""What finished trials come to, cell by cell."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from estimators.scores.detection import detection_times
from estimators.scores.interval import Interval
from estimators.scores.survival import event_curve
from testbed.study.fault_matrix.faults import Cell, cells
from testbed.study.study import Row


@dataclass(frozen=True)
class Entry:
    """of: its trials, as of `trial.trial`."""

    cell: Cell
    of: Sequence[Mapping[str, Any]]

    @property
    def trials(self) -> int:
        """How many."""
        return len(self.of)

    @property
    def missed(self) -> int:
        """In which nobody accused the faulty sensor."""
        return sum(t["delay"] is None for t in self.of)

    @property
    def guarded(self) -> bool:
        """Whether any monitor ever accused it."""
        return self.missed < self.trials

    @property
    def accused(self) -> int:
        """In which anybody was accused."""
        return sum(t["told"] is not None for t in self.of)

    @property
    def isolated(self) -> int:
        """In which the first accusation was right."""
        return sum(t["isolated"] for t in self.of)

    @property
    def falsely(self) -> int:
        """In which an alarm accused another sensor, or a tyre."""
        return sum(bool(t["wrong"] or t["low"]) for t in self.of)

    @property
    def by(self) -> str:
        """Monitors that accused the faulty sensor first, the most frequent one first."""
        return ", ".join(name for name, _ in Counter(name for t in self.of for name in t["by"]).most_common())

    @property
    def others(self) -> str:
        """Whom alarms accused instead or besides, and by whom."""
        count = Counter((who, by) for t in self.of for who, by in [*t["wrong"], *t["low"]])
        kinds = Counter[tuple[str, str]]()
        for (who, by), n in count.items():
            kinds[who.rpartition("/")[0] if who.startswith(("low/", "wheel/")) else who, by] += n
        return ", ".join(f"{who} by {by} ({n})" for (who, by), n in kinds.most_common())

    def delay(self, probability: float) -> Interval:
        """[s] by which that share is told, infinite where it is not within the watched time."""
        given = [[t["delay"]] if t["delay"] is not None else [] for t in self.of]
        watched = np.full(self.trials, float(self.cell.sensor.watch))
        return event_curve(detection_times(given, np.zeros(self.trials), watched)).quantile(probability)


def matrix(rows: Sequence[Row]) -> dict[str, Entry]:
    """By the cell's name; cells without a trial are left out."""
    trials: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        for trial in row.get("trials", ()):
            trials.setdefault(trial["cell"], []).append(trial)
    return {cell.name: Entry(cell, trials[cell.name]) for cell in cells() if cell.name in trials}
