"""Study `itpms-vibration`: Persson, Gustafsson, Drevo, SAE 2002-01-1250, Figures 2, 3 and 4, and what physics allows.

Which mode: the linearised car and the spectra say that the antiphase rotation of rim against belt (86 Hz front, 88
rear) carries the pressure from 47 km/h on, not the in-phase one that the paper names: it moves 1.8 times as much with
pressure, slip damps it at 0.07 instead of 0.2 to 0.4, and it stands out of the timing noise. The in-phase one is read
from 32 to 58 km/h; rows that end in `_in_phase` are about it, all others about the antiphase mode.

METHOD_std_over_bound: scatter of the frequency at the end of 60 s over repetitions, in the worst of the cells (road
class and speed; the level of each wheel and cell is taken off), over the Cramer-Rao bound of 60 s for the cell's own
mean spectrum, so for the signal-to-noise of that drive. Interval: chi-square of that cell; the worst of eleven is high
by chance too: `..._worst_by_chance` is the median of the worst if all cells scattered as `..._all_cells`, the figure
without that selection, says. Front and rear wheel roll over the same road and err alike at a
high signal-to-noise (correlation up to 0.9), so the intervals are too narrow by up to a root of two. A biased method
may scatter less than the bound: AR(2) does, because its band-pass holds it; see its sensitivity. The bound is that of a
stationary Gaussian spectrum of the model's form over the mode's band.

METHOD_bias_hz: worst of white noise of 30 and 100 % (of the r.m.s. within the mode's band) added to the tracked wheel
speed, and of two truths: a process whose frequency is known (error), and the multibody car on C at 80 km/h (shift
against the same method on the same drive without noise; each noise is added and taken off, so that the interval is
that of the bias and not of the drives). The known process is the honest one, but has the model's own form; the car has
another, but its truth is only known to what roads do: `vibration_minus_linearised_hz`. A worst one of several noisy
ones is beyond the truth: the process is heard in so many records that its interval is narrow against the bar, and each
shape's own row (`..._km_h`) has not been selected.

Sensitivities: d ln f / d ln p, simulated from 100 to 70 % in all tyres on the same road; limit: the linearised car.
share_separated: runs of Figure 4 on the right side of half the expected change, one at each pressure a repetition; each
wheel on its own, relative to its mean at nominal pressure; a wheel that was not heard counts as wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from testbed.study.itpms_vibration import drives, rows_of_bias, rows_of_pressure, rows_of_scatter
from testbed.study.study import Row, Study, StudyRow, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class ItpmsVibrationStudy(Study):
    name = "itpms-vibration"
    about = "Which vibration of a wheel tells its pressure, how well, and how near to the bound do methods come?"
    paper = "Persson, Gustafsson, Drevo, SAE 2002-01-1250, Figures 2, 3 and 4."
    runs = 16

    @property
    def work(self) -> Callable[[Task], Row]:
        return drives.work

    def tasks(self, runs: int, seed: int, small: bool) -> list[Task]:
        return [task for number in range(runs) for task in drives.tasks(seed, number, small)]

    def table(self, rows: Sequence[Row]) -> list[StudyRow]:
        return [*rows_of_scatter.table(rows), *rows_of_bias.table(rows), *rows_of_pressure.table(rows)]

    def figures(self, rows: Sequence[Row]) -> Mapping[str, Figure]:
        from testbed.study.itpms_vibration.figures import figures  # matplotlib, only where something is drawn

        return figures(rows)
