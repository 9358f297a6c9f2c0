"""Study `detector-design`: Razavi, Error Detection in the Active Front Steering system, Lund 2006, chapters 4 and 5.

Its thresholds and drifts as printed, as they should be, and what false-alarm rate each really has; whether the designs
of `estimators.detectors` have the run lengths that they state; local detectors side by side. One file a topic:

    designs     stated over simulated run length, every kind of detector
    thresholds  Figures 4.1 to 4.12           variance   Figures 4.22 to 4.32
    conformed   Figures 4.13 to 4.21          local, scenarios   local detectors, Table 5.1

The thesis' residuals are not available: where it uses them, simulated ones with their stated properties stand in
(`residuals`). The table's `paper` is what the thesis prints, or what its formula gives where it only plots that;
`limit` what was asked for, or the right design.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import TYPE_CHECKING

from testbed.study.detector_design import conformed, designs, local, scenarios, thresholds, variance
from testbed.study.study import Row, Study, StudyRow, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PARTS: dict[str, ModuleType] = {
    module.PART: module for module in (designs, thresholds, variance, conformed, local, scenarios)
}
NEAR = (0.95, 1.05)  # of the worst stated over simulated run length, from which on the study objects


def simulate(task: Task) -> Row:
    """The row of a task, by its part."""
    row: Row = PARTS[task["part"]].simulate(task)
    return row


class DetectorDesignStudy(Study):
    name = "detector-design"
    about = "Which false-alarm rate do the thesis' detectors really have, and do designs here have the one they state?"
    paper = "Razavi, Error Detection in the Active Front Steering system, Lund 2006, chapters 4 and 5."
    runs = 4

    @property
    def work(self) -> Callable[[Task], Row]:
        return simulate

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        return [task for number in range(runs) for part in PARTS.values() for task in part.tasks(seed, number, small)]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        return [row for part in PARTS.values() for row in part.table(rows)]

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.detector_design.figures import figures  # matplotlib, only where something is drawn

        return figures(rows)

    def objections(self, rows: Sequence[Row]) -> list[str]:
        """A stated run length that a simulation surely contradicts: its whole interval outside of NEAR."""
        return [
            f"{kind}, ARL0 {asked:g}: stated over simulated run length is {ratio.value:.3f}"
            for (kind, asked), ratio in designs.ratios(rows).items()
            if ratio.low > NEAR[1] or ratio.high < NEAR[0]
        ]
